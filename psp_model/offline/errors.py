"""What goes wrong offline: files and options, as opposed to values outside the model's domain."""

from __future__ import annotations

from ..errors import PspError


class OfflineError(PspError, ValueError):
    """One sentence: what was found, what was expected, remedy."""
