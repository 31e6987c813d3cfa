"""What a command raises when its input is no good."""

from __future__ import annotations


class BadInput(Exception):
    """One sentence for the user: value, what was expected, remedy; `psp` prints it and exits with code 2."""
