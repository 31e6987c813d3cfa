"""The Parquet file of a data set: schema with units, provenance, and a hash of the content."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..parameters import ObjectiveWeights, PlatoonParameters
from ..selection.search.engine import Problem
from ..selection.search.search import EFFORTS, Grid, Search
from ..state import StartDomain
from ..whole_file import whole_file
from .errors import OfflineError
from .plan import Plan

Array = NDArray[Any]

FORMAT = "psp-platoon data set 1"
_UNITS = {"alpha": "1", "r": "m", "p": "1", "J": "1", "T_max": "s", "table": "1"}
_ROW_GROUP = 2000


@dataclass(frozen=True)
class Dataset:
    """Starts and their optima; starts that could not be solved are left out.

    Attributes
    ----------
    starts : (B, 2n-1) spacings [m], then speeds [m/s]
    triples : (B, 3) alpha [1], r [m], p [1]
    J : (B,) at the optima
    tables : (B, R, P) float32, J on `grid`, or None where the file has none
    problem, domain, effort : what was solved, from where, how
    sha256 : hash of the whole content
    failures : how many starts of the file could not be solved
    drawn, seed : how many starts were drawn, and their seed
    """

    starts: Array
    triples: Array
    J: Array
    tables: Array | None
    problem: Problem
    domain: StartDomain
    effort: str
    sha256: str
    failures: int
    drawn: int
    seed: int

    def first(self, count: int | None) -> Dataset:
        """The first `count` starts, all where it is None; the hash stays that of the whole."""
        tables = None if self.tables is None else self.tables[:count]
        parts: dict[str, Any] = {
            "starts": self.starts[:count],
            "triples": self.triples[:count],
            "J": self.J[:count],
            "tables": tables,
        }
        return replace(self, **parts)

    @property
    def grid(self) -> Grid:
        """The grid that the tables stand on."""
        return Search(self.problem, EFFORTS[self.effort]).grid


def start_columns(vehicles: int) -> list[str]:
    """Names of the columns that hold a start of n `vehicles`: s_2..s_n, v_1..v_n."""
    return [f"s_{i}" for i in range(2, vehicles + 1)] + [f"v_{i}" for i in range(1, vehicles + 1)]


def _unit(name: str) -> str:
    return _UNITS.get(name) or {"s": "m", "v": "m/s"}[name[0]]


def _content_hash(columns: dict[str, Array], errors: list[str]) -> str:
    """SHA-256 over names, shapes and bytes of all columns."""
    digest = hashlib.sha256()
    for name, values in columns.items():
        digest.update(f"{name}{values.shape}{values.dtype.str}".encode())
        digest.update(np.ascontiguousarray(values).data)
    digest.update(json.dumps(errors).encode())
    return digest.hexdigest()


def write_dataset(plan: Plan, solved: dict[str, Array], path: Path) -> None:
    """Write a solved plan; the same plan and columns give the same bytes.

    Parameters
    ----------
    plan : what was solved
    solved : starts, triples, J, T_max, error and perhaps table, as `plan.solve_chunk` gives them
    path : the file
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = dict(zip(start_columns(plan.problem.vehicles), solved["starts"].T, strict=True))
    columns |= dict(zip(("alpha", "r", "p"), solved["triples"].T, strict=True))
    columns |= {name: solved[name] for name in ("J", "T_max", "table") if name in solved}
    errors = [str(text) for text in solved["error"]]
    arrays, fields = [], []
    for name, values in columns.items():
        flat = pa.array(np.ascontiguousarray(values).reshape(-1))
        arrays.append(flat if values.ndim == 1 else pa.FixedSizeListArray.from_arrays(flat, values.shape[1]))
        fields.append(pa.field(name, arrays[-1].type, nullable=False, metadata={"unit": _unit(name)}))
    arrays.append(pa.array([text or None for text in errors], pa.string()))
    fields.append(pa.field("error", pa.string()))
    about = {
        "format": FORMAT,
        "plan": plan.as_json(),
        "sha256": _content_hash(columns, errors),
        "versions": json.dumps({name: version(name) for name in ("numpy", "casadi", "pyarrow", "ziglang")}),
    }
    table = pa.Table.from_arrays(arrays, schema=pa.schema(fields, metadata=about))
    with whole_file(path) as partial:
        pq.write_table(table, partial, compression="zstd", row_group_size=_ROW_GROUP, use_dictionary=False)


def read_dataset(path: Path) -> Dataset:
    """Read a data set and check that it is one, whole and unchanged.

    Parameters
    ----------
    path : the file

    Returns
    -------
    Dataset

    Raises
    ------
    OfflineError : where the file is missing, not a data set of ours, or its content does not fit its hash
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.read_table(path)
    except FileNotFoundError:
        raise OfflineError(f"there is no data set {path}", "make one with make_dataset", "no_dataset") from None
    except (OSError, pa.ArrowException):
        problem = f"{path} is not a Parquet file that can be read"
        raise OfflineError(problem, "make it again with make_dataset", "unreadable_dataset") from None
    about = {key.decode(errors="replace"): value for key, value in (table.schema.metadata or {}).items()}
    about = {key: value.decode(errors="replace") for key, value in about.items()}
    if about.get("format") != FORMAT:
        remedy = "give a file made by make_dataset"
        raise OfflineError(f"{path} has not the schema {FORMAT!r}", remedy, "foreign_dataset")
    names = [name for name in table.column_names if name != "error"]
    expected = _expected_columns(about.get("plan", ""), len(names))
    if names not in (expected, [*expected, "table"]) or "error" not in table.column_names:
        raise OfflineError(f"{path} has the columns {', '.join(names)} and not those of its plan: make it again")
    columns = {name: _numbers(table.column(name)) for name in names}
    errors = [text or "" for text in table.column("error").to_pylist()]
    if _content_hash(columns, errors) != about.get("sha256"):
        raise OfflineError(f"{path} was changed after it was made (its hash does not fit): make it again")
    try:
        return _dataset(json.loads(about["plan"]), columns, errors, about["sha256"])
    except (ArithmeticError, AttributeError, KeyError, TypeError, ValueError):  # the hash does not cover the plan
        raise OfflineError(f"{path} has a plan that cannot be read: make it again") from None


def _expected_columns(plan: str, most: int) -> list[str]:
    """The columns of a plan, none where it cannot be read or would have more than so many."""
    try:
        vehicles = int(json.loads(plan)["problem"]["vehicles"])
    except (ArithmeticError, KeyError, TypeError, ValueError, RecursionError):
        return []
    return [*start_columns(vehicles), "alpha", "r", "p", "J", "T_max"] if vehicles < most else []


def _numbers(column: Any) -> Array:
    """A column as an array, lists of numbers as rows."""
    import pyarrow as pa

    joined = column.combine_chunks()
    if pa.types.is_fixed_size_list(joined.type):
        return np.asarray(joined.flatten()).reshape(len(joined), -1)
    return np.asarray(joined)


def _dataset(plan: dict[str, Any], columns: dict[str, Array], errors: list[str], sha256: str) -> Dataset:
    settings = plan["problem"]
    constants, weights = PlatoonParameters(**settings.pop("constants")), ObjectiveWeights(**settings.pop("weights"))
    problem, domain = Problem(constants=constants, weights=weights, **settings), StartDomain(**plan["domain"])
    solved = np.array([not text for text in errors], dtype=bool)
    rows = {name: values[solved] for name, values in columns.items()}
    starts = np.stack([rows[name] for name in start_columns(problem.vehicles)], axis=1)
    triples = np.stack([rows[name] for name in ("alpha", "r", "p")], axis=1)
    tables = None
    if "table" in rows:
        grid = Search(problem, EFFORTS[plan["effort"]]).grid
        tables = rows["table"].reshape(-1, grid.r.size, grid.level.size)
    failures = int((~solved).sum())
    made = plan["effort"], sha256, failures, plan["starts"], plan["seed"]
    return Dataset(starts, triples, rows["J"], tables, problem, domain, *made)
