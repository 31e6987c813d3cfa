"""The compiled rollouts against the model run step by step in NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from psp_model import PlatoonState, PotentialParameters, simulate
from psp_model.selection.search.engine import Engine, Problem
from small_problems import draw

TRIPLES = np.array([[1e-3, 11.0, 5.5], [2e-3, 8.0, 3.2], [1e-3, 13.7, 6.6]])


@pytest.mark.parametrize("vehicles", [2, 4, 7])
def test_rollouts_in_double_equal_simulate(vehicles: int) -> None:
    starts = draw(vehicles, 3)
    J, T_max = Engine(Problem(vehicles), "double").costs(starts, np.arange(3), TRIPLES)
    for start, triple, cost, bound in zip(starts, TRIPLES, J, T_max, strict=True):
        run = simulate(PlatoonState(start[: vehicles - 1], start[vehicles - 1 :]), PotentialParameters(*triple))
        assert cost == pytest.approx(run.J, abs=1e-9)
        assert bound == pytest.approx(run.T_max[:-1].min(), abs=1e-12)


def test_rollouts_in_float_are_close_to_double() -> None:
    starts, which = draw(7, 50), np.repeat(np.arange(50), 3)
    triples = np.tile(TRIPLES, (50, 1))
    single, _ = Engine(Problem(), "float").costs(starts, which, triples)
    double, _ = Engine(Problem(), "double").costs(starts, which, triples)
    assert np.median(np.abs(single / double - 1)) < 2e-5  # a run close to a cliff may fall on its other side


def test_result_does_not_depend_on_threads_or_neighbours() -> None:
    starts, triples = draw(4, 9000, seed=3), np.tile(TRIPLES, (3000, 1))
    problem = Problem(4, horizon=0.5)
    one, _ = Engine(problem, threads=1).costs(starts, np.arange(9000), triples)
    two, _ = Engine(problem, threads=2).costs(starts, np.arange(9000), triples)
    alone, _ = Engine(problem).costs(starts[4097:4098], np.zeros(1, int), triples[4097:4098])
    assert (one == two).all()
    assert alone[0] == one[4097]
