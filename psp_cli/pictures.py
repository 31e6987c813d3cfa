"""Names of pictures, films and pages: their ending says what they are, and is checked before any work is done."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from .bad_input import BadInput

PICTURES = (".png", ".svg", ".pdf")
FILMS = (".mp4", ".gif")
PAGES = (".html", ".htm")


def require_ending(path: Path | None, endings: Sequence[str], option: str) -> None:
    """Refuse a name whose ending is none of those that can be written.

    Parameters
    ----------
    path : of the file, None where none is asked for
    endings : in lower case, with their dots
    option : that gave the name

    Raises
    ------
    BadInput : where the ending is another one
    """
    if path is None or path.suffix.lower() in endings:
        return
    known = f"{', '.join(endings[:-1])} or {endings[-1]}"
    raise BadInput(f"{option} {path} ends in none of the formats that can be written: give it a name with {known}")
