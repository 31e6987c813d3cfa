"""Files that are there in full or not at all, also after a full disk or a kill."""

from __future__ import annotations

import io
import os
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

MOST_BYTES = 1 << 32  # that an NPZ file may hold
UNFINISHED: set[Path] = set()
"""Files that are being written now: code that ends the process without unwinding removes them."""


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A place beside `path` to write to; what was written takes the place of `path` when the block ends well.

    Parameters
    ----------
    path : the file; missing folders are made

    Yields
    ------
    path with the same ending, as writers go by it; removed where the block fails
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.stem}.{os.getpid()}.partial{path.suffix}")  # two processes do not share it
    UNFINISHED.add(partial)
    try:
        yield partial
        with partial.open("rb") as file:
            os.fsync(file.fileno())
        partial.replace(path)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise
    finally:
        UNFINISHED.discard(partial)


def write_whole(path: Path, content: bytes | str) -> None:
    """Write a file in one go, text as UTF-8 with plain newlines.

    Parameters
    ----------
    path : the file; missing folders are made
    content : of the file
    """
    with whole_file(path) as partial:
        partial.write_bytes(content.encode() if isinstance(content, str) else content)


def read_arrays(path: Path) -> dict[str, Any]:
    """The arrays of an NPZ file by name; nothing in the file is run.

    Parameters
    ----------
    path : the file

    Raises
    ------
    ValueError : where it is damaged, holds anything but plain arrays, or more than MOST_BYTES of them
    OSError : where it cannot be read
    """
    content = path.read_bytes()
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
        if size > MOST_BYTES:
            raise ValueError(f"more than {MOST_BYTES} bytes")
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except ValueError:
        raise
    except Exception as error:  # zipfile, zlib and numpy raise a class of their own for every kind of damage
        raise ValueError(str(error)) from None
