"""Files of starts to be solved, and of their optima."""

from __future__ import annotations

import csv
import io
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..parameters import PlatoonParameters
from ..state import PlatoonState
from ..validate import validate
from ..whole_file import read_arrays, write_whole
from .errors import OfflineError

Array = NDArray[Any]

_COLUMN = re.compile(r"^(s|v)(?:0|_start)?[_\[]?(\d{1,9})\]?$")
_EXPECTED = "CSV needs the columns s_2..s_n and v_1..v_n"


def read_starts(path: Path, constants: PlatoonParameters | None = None) -> Array:
    """Starts from a CSV file (columns s_2..s_n, v_1..v_n, any order) or an NPZ file (s0 [B, n-1], v0 [B, n]).

    Parameters
    ----------
    path : the file
    constants : that say which starts are admissible

    Returns
    -------
    (B, 2n-1) array, spacings [m] then speeds [m/s]

    Raises
    ------
    OfflineError : where the file is missing, empty, of another form, or a start is not admissible
    """
    if path.suffix.lower() not in (".csv", ".npz"):
        raise OfflineError(f"{path} is neither CSV nor NPZ: name it .csv or .npz after what it holds")
    try:
        s, v = _from_csv(path) if path.suffix.lower() == ".csv" else _from_npz(path)
    except OSError as error:
        raise OfflineError(f"{path} could not be read ({error.strerror or error}): give a file that is there") from None
    if not len(s):
        raise OfflineError(f"{path} holds no start: give it one row for each start")
    for row, (spacings, speeds) in enumerate(zip(s, v, strict=True), start=1):
        try:
            validate(PlatoonState(spacings, speeds, constants or PlatoonParameters()))
        except ModelError as error:
            raise OfflineError(f"{path}, start {row}: {error.problem}", error.remedy) from None
    return np.concatenate([s, v], axis=1)


def _from_npz(path: Path) -> tuple[Array, Array]:
    try:
        arrays = read_arrays(path)
    except ValueError:
        raise OfflineError(f"{path} is not an NPZ file that can be read: write it with numpy.savez") from None
    if set(arrays) != {"s0", "v0"}:
        found = ", ".join(sorted(arrays)) or "none"
        raise OfflineError(f"{path} holds the arrays {found}: it needs s0 [B, n-1] and v0 [B, n] and no others")
    try:
        s, v = arrays["s0"].astype(float), arrays["v0"].astype(float)
    except (TypeError, ValueError):
        raise OfflineError(f"{path} holds something else than numbers: s0 and v0 must be numeric arrays") from None
    if s.ndim != 2 or v.ndim != 2 or len(s) != len(v) or v.shape[1] != s.shape[1] + 1 or v.shape[1] < 2:
        shapes = f"s0 {list(s.shape)} and v0 {list(v.shape)}"
        raise OfflineError(f"{path} holds {shapes}: n >= 2 vehicles need s0 [B, n-1] and v0 [B, n]")
    return s, v


def _from_csv(path: Path) -> tuple[Array, Array]:
    try:
        rows = [row for row in csv.reader(io.StringIO(path.read_text(encoding="utf-8-sig"))) if row]
    except (UnicodeDecodeError, csv.Error):
        raise OfflineError(f"{path} is not a text file", _EXPECTED) from None
    if not rows:
        raise OfflineError(f"{path} is empty", _EXPECTED)
    names, places = rows[0], {}
    for place, name in enumerate(names):
        match = _COLUMN.match(name.strip())
        if match is None or (match[1], int(match[2])) in places:
            problem = "unknown" if match is None else "repeated"
            raise OfflineError(f"{path} has the {problem} column {name.strip()!r}", f"{_EXPECTED} and no others")
        places[match[1], int(match[2])] = place
    n = max((number for _, number in places), default=0)
    if n > len(places):
        raise OfflineError(f"{path} names vehicle {n} and has {len(places)} columns", _EXPECTED)
    wanted = [("s", i) for i in range(2, n + 1)] + [("v", i) for i in range(1, n + 1)]
    if n < 2 or set(wanted) != set(places):
        missing = ", ".join(f"{kind}_{i}" for kind, i in wanted if (kind, i) not in places)
        raise OfflineError(f"{path} lacks or misnumbers columns ({missing or 'too few vehicles'})", _EXPECTED)
    table = _numbers(path, rows[1:], len(names))[:, [places[key] for key in wanted]]
    return table[:, : n - 1], table[:, n - 1 :]


def _numbers(path: Path, rows: list[list[str]], columns: int) -> Array:
    """The cells of a CSV file as numbers."""
    table = np.empty((len(rows), columns))
    for number, row in enumerate(rows, start=1):
        if len(row) != columns:
            raise OfflineError(f"{path}, start {number} has {len(row)} cells", f"give it {columns}, as the header has")
        try:
            table[number - 1] = [float(cell) for cell in row]
        except ValueError:
            raise OfflineError(
                f"{path}, start {number} holds something else than numbers, {row}", "give numbers"
            ) from None
    return table


def write_optima(path: Path, columns: dict[str, Array]) -> None:
    """Write optima as CSV or NPZ: alpha, r, p, J and T_max [B], whole or not at all.

    Parameters
    ----------
    path : the file, .npz or else CSV
    columns : triples (B, 3), J, T_max and error, as `plan.solve_or_record` gives them

    Raises
    ------
    OfflineError : where the file cannot be written
    """
    arrays = dict(zip(("alpha", "r", "p"), columns["triples"].T, strict=True))
    arrays |= {"J": columns["J"], "T_max": columns["T_max"]}
    if path.suffix.lower() == ".npz":
        file = io.BytesIO()
        np.savez(file, **arrays)
        content = file.getvalue()
    else:
        lines = [",".join(arrays)] + [
            ",".join(f"{value:.17g}" for value in row) for row in zip(*arrays.values(), strict=True)
        ]
        content = ("\n".join(lines) + "\n").encode()
    try:
        write_whole(path, content)
    except OSError as error:
        raise OfflineError(
            f"{path} could not be written ({error.strerror or error}): make room there or choose another place"
        ) from None
