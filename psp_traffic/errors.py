"""What goes wrong in traffic: a scenario that does not fit, a controller FMU that fails."""

from __future__ import annotations

from psp_model.errors import PspError


class TrafficError(PspError, ValueError, RuntimeError):
    """One sentence: what was found, remedy."""
