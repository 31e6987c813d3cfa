"""The error of the commands."""

from __future__ import annotations

from psp_model.errors import PspError


class InputError(PspError):
    """One sentence for the user: value, what was expected, remedy; `psp` prints it and exits with code 2."""
