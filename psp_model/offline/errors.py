"""What goes wrong offline: files and settings, as opposed to values outside the model's domain."""

from __future__ import annotations

from ..errors import PspError


class OfflineError(PspError, ValueError):
    """One sentence: what was found, what was expected, remedy.

    Parameters
    ----------
    problem, remedy : as for `PspError`
    key : name of the case, for programs that have a remedy of their own for it (`psp_cli/remedies.py`)
    """

    def __init__(self, problem: str, remedy: str | None = None, key: str | None = None):
        super().__init__(problem, remedy)
        self.args, self.key = (problem, remedy, key), key
