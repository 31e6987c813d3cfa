"""V and V': the paper's conditions, finite differences, and smoothness where the pieces meet."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import reference
from psp_model import BEST_FIXED, V_OLD, PotentialParameters, potential, potential_slope
from psp_model.law.potential import on_hill, stacked
from strategies import CONSTANTS, any_triple, feasible_triple

SHAPES = [V_OLD, BEST_FIXED, PotentialParameters(1e-2, 9.0, 3.0), PotentialParameters(1e-1, 17.0, 6.5)]
SHAPES += [feasible_triple(seed) for seed in range(6)]
ids = [f"{shape.alpha:.2g},{shape.r:.4g},{shape.p:.3g}" for shape in SHAPES]
every_shape = pytest.mark.parametrize("shape", SHAPES, ids=ids)
L, LAM = CONSTANTS.L, CONSTANTS.lam


def V(s: float, shape: PotentialParameters) -> float:
    return float(potential(np.array([s]), shape, CONSTANTS)[0])


def slope(s: float, shape: PotentialParameters) -> float:
    return float(potential_slope(np.array([s]), shape, CONSTANTS)[0])


@given(any_triple() | st.just(V_OLD), st.floats(5.0001, 40))
def test_equals_the_paper_s_formulas(shape: PotentialParameters, s: float) -> None:
    hill = shape.hill == 1.0
    expected = reference.V(s, shape.alpha, shape.r, shape.p, hill, reference.Constants())
    expected_slope = reference.V_slope(s, shape.alpha, shape.r, shape.p, hill, reference.Constants())
    assert V(s, shape) == pytest.approx(expected, rel=1e-11, abs=1e-11)
    assert slope(s, shape) == pytest.approx(expected_slope, rel=1e-11, abs=1e-9)


@given(any_triple() | st.just(V_OLD), st.floats(5.2, 25))
def test_slope_is_the_derivative_of_the_potential(shape: PotentialParameters, s: float) -> None:
    h = 1e-3
    edges = [shape.r, shape.r + 3.0, LAM]
    assume(all(abs(s - edge) > 3 * h for edge in edges))  # the stencil must not straddle two pieces
    difference = (V(s - 2 * h, shape) - 8 * V(s - h, shape) + 8 * V(s + h, shape) - V(s + 2 * h, shape)) / (12 * h)
    # fourth order: the remainder is h^4/30 times a fifth derivative, large near L and on steep hills
    scale = 1.0 + max(V(s - 2 * h, shape), V(s + 2 * h, shape))
    assert slope(s, shape) == pytest.approx(difference, rel=2e-6, abs=2e-8 * scale)


@every_shape
def test_twice_continuously_differentiable_where_the_pieces_meet(shape: PotentialParameters) -> None:
    """Jumps of V, V' and V'' across r, r + 3 and lambda vanish with the distance; V'' by differences from one side."""
    for edge in (shape.r, shape.r + 3.0, LAM):
        if edge <= L:
            continue  # V_old has no hill
        below, at, above = edge - 1e-9, edge, edge + 1e-9
        for function in (V, slope):
            middle = function(at, shape)
            assert function(below, shape) == pytest.approx(middle, abs=1e-6)
            assert function(above, shape) == pytest.approx(middle, abs=1e-6)
        jumps = []
        for h in (1e-2, 1e-3, 1e-4):
            left = (slope(edge, shape) - slope(edge - h, shape)) / h
            right = (slope(edge + h, shape) - slope(edge, shape)) / h
            jumps.append(abs(right - left))
        assert jumps[0] < 20.0
        # V''' is bounded at p = 3 and q^(p-3) smaller above: the jump of V'' falls with h
        assert jumps[1] < 0.2 * jumps[0] + 1e-9 and jumps[2] < 0.2 * jumps[1] + 1e-7


def test_below_p_3_the_second_derivative_jumps() -> None:
    """The paper's reason for p >= 3; this also shows that the test above can fail."""
    shape = PotentialParameters(1e-3, 11.0, 2.0)
    jumps = [
        abs((slope(11.0 + h, shape) - slope(11.0, shape)) / h - (slope(11.0, shape) - slope(11.0 - h, shape)) / h)
        for h in (1e-3, 1e-4, 1e-5)
    ]
    assert min(jumps) > 0.4


@every_shape
def test_conditions_of_the_paper(shape: PotentialParameters) -> None:
    near = [V(L + 10.0**-k, shape) for k in range(1, 15)]
    assert near == sorted(near) and near[-1] > 1e13 * shape.alpha  # V -> infinity as s -> L
    for s in (LAM, np.nextafter(LAM, 99.0), 20.5, 23.0, 1e3, 1e9):
        assert V(s, shape) == 0.0 and slope(s, shape) == 0.0
    grid = np.linspace(L + 1e-3, LAM, 5001)
    assert (potential(grid, shape, CONSTANTS) >= 0).all()


@every_shape
def test_the_hill_stays_inside_r_to_r_plus_3(shape: PotentialParameters) -> None:
    grid = np.linspace(L + 1e-2, 25.0, 4001)
    difference = potential(grid, shape, CONSTANTS) - potential(grid, replace(shape, hill=0.0), CONSTANTS)
    slopes = potential_slope(grid, shape, CONSTANTS) - potential_slope(grid, replace(shape, hill=0.0), CONSTANTS)
    outside = (grid <= shape.r) | (grid >= shape.r + 3.0)
    assert (difference[outside] == 0).all() and (slopes[outside] == 0).all()
    assert shape is V_OLD or (difference[~outside] > 0).all()


@every_shape
def test_on_hill_holds_strictly_between_r_and_r_plus_3(shape: PotentialParameters) -> None:
    r = shape.r
    inside = [np.nextafter(r + 1e-9, 99.0), r + 1e-3, r + 1.5, r + 3.0 - 1e-3]
    outside = [r - 5.0, r - 1e-3, r, r + 3.0, r + 3.0 + 1e-3, r + 9.0]
    assert on_hill(np.array(inside), shape).all()
    assert not on_hill(np.array(outside), shape).any()


def test_V_old_decreases_strictly_up_to_lambda() -> None:
    grid = np.linspace(L + 1e-3, LAM - 1e-6, 2001)
    assert (potential_slope(grid, V_OLD, CONSTANTS) < 0).all()


@pytest.mark.parametrize("r", [8.0, 11.0, 16.0])
def test_the_minimum_before_the_hill_is_near_r(r: float) -> None:
    """Paper, influence of r: the local minimum lies close to r."""
    grid = np.linspace(r - 1.0, r + 1.0, 20001)
    minimum = grid[np.argmin(potential(grid, replace(BEST_FIXED, r=r), CONSTANTS))]
    assert r < minimum < r + 0.7


@pytest.mark.parametrize(
    ("shape", "text"),
    [
        (BEST_FIXED, "V_new, alpha = 0.001, r = 11 m, p = 5.5"),
        (PotentialParameters(0.0123456, 9.87654321, 3), "V_new, alpha = 0.01235, r = 9.877 m, p = 3"),
        (V_OLD, "V_old"),
        (replace(V_OLD, alpha=0.02), "alpha = 0.02, no hill"),
        (replace(V_OLD, r=9.0), "alpha = 1, no hill"),
    ],
)
def test_a_potential_is_printed_by_its_parameters(shape: PotentialParameters, text: str) -> None:
    assert str(shape) == text


def test_a_potential_of_arrays_is_printed_as_what_it_holds() -> None:
    together = stacked([BEST_FIXED, V_OLD])
    assert str(together) == repr(together) and "array" in str(together)


def test_potentials_of_one_family_become_one_of_arrays() -> None:
    class Named(NamedTuple):
        k: float
        j: float

    together = stacked([BEST_FIXED, V_OLD])
    assert isinstance(together, PotentialParameters)
    assert [getattr(together, name).tolist() for name in ("alpha", "r", "p", "hill")] == [
        [1e-3, 1.0],
        [11.0, 0.0],
        [5.5, 0.0],
        [1.0, 0.0],
    ]
    named = stacked([Named(1.0, 2.0), Named(3.0, 4.0), Named(5.0, 6.0)])
    assert isinstance(named, Named) and named.k.tolist() == [1.0, 3.0, 5.0] and named.j.tolist() == [2.0, 4.0, 6.0]
