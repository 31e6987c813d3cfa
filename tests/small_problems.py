"""Small problems for the tests of the offline half."""

from __future__ import annotations

import numpy as np

from psp_model import StartDomain
from psp_model.offline.plan import Plan
from psp_model.selection.search.engine import Problem
from psp_model.selection.search.search import EFFORTS, Effort

TINY = Effort(r_step=0.5, levels=6, alphas=(), seeds=2, survivors=1, rounds=2, finalists=1, ridges=0)
PLAN = Plan(11, 5, Problem(3, horizon=2.0), effort="tiny", chunk=2)


def teach_tiny() -> None:
    """Make the effort `tiny` known in this process; Dask's workers are told, too."""
    EFFORTS["tiny"] = TINY


def draw(vehicles: int, count: int, seed: int = 0) -> np.ndarray:
    """(count, 2n-1) starts from the training domain."""
    s, v = StartDomain().draw(np.random.default_rng(seed), vehicles, count)
    return np.concatenate([s, v]).T
