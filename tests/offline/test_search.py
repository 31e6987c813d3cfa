"""The search against brute force, and its answers against the model's own idea of feasible."""

from __future__ import annotations

import numpy as np
import pytest

from psp_model import PlatoonParameters, PotentialParameters, max_slope, require_feasible
from psp_model.selection.feasible import slope_within_limit
from psp_model.selection.search.engine import Engine, Problem
from psp_model.selection.search.search import Search, Solutions
from psp_model.selection.search.slope_limit import SlopeLimit
from small_problems import draw

CONSTANTS = PlatoonParameters()


@pytest.fixture(scope="module")
def solved() -> tuple[np.ndarray, Solutions]:
    starts = draw(4, 6, seed=11)
    return starts, Search(Problem(4)).solve(starts)


def brute_force_points() -> np.ndarray:
    points = []
    for alpha in (1e-3, 3e-3):
        for r in np.arange(6.0, 17.01, 0.1):
            for p in np.arange(3.0, 7.6, 0.15):
                if not slope_within_limit(PotentialParameters(alpha, float(r), float(p)), CONSTANTS):
                    break
                points.append((alpha, r, p))
    return np.array(points)


def test_search_is_not_above_a_regular_grid(solved: tuple[np.ndarray, Solutions]) -> None:
    starts, found = solved
    points = brute_force_points()
    engine = Engine(Problem(4))
    grid = [engine.costs(start[None], np.zeros(len(points), int), points)[0].min() for start in starts]
    assert (np.array(grid) * 1.001 >= found.J).all()


def test_answers_are_feasible_and_certified(solved: tuple[np.ndarray, Solutions]) -> None:
    _, found = solved
    for triple in found.triples:
        require_feasible(PotentialParameters(*map(float, triple)), CONSTANTS)
    assert (found.T_max > 0.01).all()


def test_J_is_that_of_the_answer(solved: tuple[np.ndarray, Solutions]) -> None:
    starts, found = solved
    J, _ = Engine(Problem(4), "double").costs(starts, np.arange(len(starts)), found.triples)
    assert (J == found.J).all()


def test_slope_limit_is_where_the_slope_reaches_z() -> None:
    rng = np.random.default_rng(0)
    alpha, r = np.exp(rng.uniform(np.log(1e-3), np.log(2e-2), 40)), rng.uniform(8.5, 17.0, 40)
    for a, place, p in zip(alpha, r, SlopeLimit(CONSTANTS).largest_p(alpha, r), strict=True):
        assert max_slope(PotentialParameters(float(a), float(place), float(p)), CONSTANTS) == pytest.approx(
            4.0, abs=0.02
        )
