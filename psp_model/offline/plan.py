"""What a data set is made of: a plan, cut into chunks that can be solved anywhere and in any order."""

from __future__ import annotations

import io
import json
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..selection.search.engine import Problem
from ..selection.search.search import EFFORTS, Search
from ..state import StartDomain

Array = NDArray[Any]


@dataclass(frozen=True)
class Plan:
    """Everything that a data set's content depends on.

    Attributes
    ----------
    starts : how many
    seed : of their drawing
    problem : what is solved for them
    domain : what they are drawn from, uniformly
    effort : name in `search.EFFORTS`
    tables : whether J on the main grid is kept
    chunk : starts that are solved together
    """

    starts: int
    seed: int
    problem: Problem = field(default_factory=Problem)
    domain: StartDomain = field(default_factory=StartDomain)
    effort: str = "full"
    tables: bool = True
    chunk: int = 100

    @property
    def chunks(self) -> int:
        """How many chunks there are."""
        return -(-self.starts // self.chunk)

    def draw(self) -> Array:
        """(starts, 2n-1) array, spacings [m] then speeds [m/s] of each start."""
        s, v = self.domain.draw(np.random.default_rng(self.seed), self.problem.vehicles, self.starts)
        return np.concatenate([s, v]).T

    def as_json(self) -> str:
        """The plan as text, to compare plans by."""
        return json.dumps(asdict(self), sort_keys=True)


@lru_cache(maxsize=4)
def _search(problem: Problem, effort: str, threads: int | None) -> Search:
    return Search(problem, EFFORTS[effort], threads)


def solve_chunk(plan: Plan, number: int, threads: int | None = None) -> bytes:
    """Solve one chunk of a plan, here or on any worker.

    Parameters
    ----------
    plan, number : which chunk
    threads : for the rollouts; the result does not depend on them

    Returns
    -------
    the chunk's columns as the bytes of an NPZ file
    """
    starts = plan.draw()[number * plan.chunk : (number + 1) * plan.chunk]
    columns = solve_or_record(_search(plan.problem, plan.effort, threads), starts, plan.tables)
    file = io.BytesIO()
    arrays: dict[str, Any] = {"starts": starts, **columns}
    np.savez(file, **arrays)
    return file.getvalue()


def solve_or_record(search: Search, starts: Array, tables: bool) -> dict[str, Array]:
    """Solve starts; where one fails, say why in its row and go on.

    Parameters
    ----------
    search : the solver
    starts : (B, 2n-1) array
    tables : whether J on the main grid is kept

    Returns
    -------
    triples (B, 3), J (B,), T_max (B,), error (B,) text, empty where solved, and table (B, R * P) where asked for
    """
    try:
        found = search.solve(starts)
    except (ModelError, ArithmeticError) as error:
        if len(starts) > 1:
            parts = [solve_or_record(search, start[None], tables) for start in starts]
            return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
        return _failed(search, str(error), tables)
    solved = np.isfinite(found.J)
    columns = {"triples": found.triples, "J": found.J, "T_max": found.T_max}
    columns["error"] = np.where(solved, "", "no candidate has a finite J")
    return columns | ({"table": found.tables.reshape(len(starts), -1)} if tables else {})


def _failed(search: Search, reason: str, tables: bool) -> dict[str, Array]:
    """The row of a start that could not be solved."""
    nan = np.full((1,), np.nan)
    columns = {"triples": np.full((1, 3), np.nan), "J": nan, "T_max": nan, "error": np.array([reason])}
    cells = search.grid.r.size * search.grid.level.size
    return columns | ({"table": np.full((1, cells), np.nan, np.float32)} if tables else {})
