"""The feasible set: the slope bound against an oracle, the projection, and what is said about a triple outside."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import reference
from psp_model import (
    BEST_FIXED,
    ModelError,
    PlatoonParameters,
    PotentialParameters,
    max_slope,
    project,
    require_feasible,
)
from psp_model.law.potential import potential_slope
from psp_model.parameters import ALPHA_MAX, ALPHA_MIN, P_MAX, P_MIN
from psp_model.selection.feasible import SLOPE_ERROR, cell_bound
from strategies import CONSTANTS, any_triple, feasible_triple

GOLDEN = (5**0.5 - 1) / 2


def golden_section(function: Callable[[float], float], a: float, b: float) -> float:
    """The largest value of a function with one maximum in [a, b]."""
    c, d = b - GOLDEN * (b - a), a + GOLDEN * (b - a)
    while b - a > 1e-9:
        if function(c) > function(d):
            b, d = d, c
            c = b - GOLDEN * (b - a)
        else:
            a, c = c, d
            d = a + GOLDEN * (b - a)
    return max(function(a), function(b))


def true_maximum(shape: PotentialParameters, points: int = 1201) -> float:
    """max |V'| on the hill by a grid and a golden section around each of its best points, all from the oracle."""

    def size(s: float) -> float:
        return abs(reference.V_slope(s, shape.alpha, shape.r, shape.p, True, reference.Constants()))

    grid = np.linspace(shape.r, shape.r + 3.0, points).tolist()
    values = [size(s) for s in grid]
    best = max(values)
    for k in range(1, points - 1):
        if values[k] >= max(values[k - 1], values[k + 1]) and values[k] > 0.9 * best:
            best = max(best, golden_section(size, grid[k - 1], grid[k + 1]))
    return best


def tolerance(slope: float) -> float:
    """What max_slope promises, and the rounding of two ways to write V'."""
    return max(SLOPE_ERROR, 1e-12 * slope) + 1e-13 * slope


@given(any_triple())
@settings(max_examples=120)
def test_max_slope_finds_the_maximum(shape: PotentialParameters) -> None:
    true = true_maximum(shape)
    assert abs(max_slope(shape, CONSTANTS) - true) <= tolerance(true)


@pytest.mark.parametrize("p", [3.0, 5.0, 9.0])
@pytest.mark.parametrize("r", [5 + 1e-9, 5 + 1e-6, 5.001, 5.1, 16.9999, 17.0])
@pytest.mark.parametrize("alpha", [ALPHA_MIN, ALPHA_MAX])
def test_max_slope_at_the_edges_of_the_bounds(alpha: float, r: float, p: float) -> None:
    shape = PotentialParameters(alpha, r, p)
    true = true_maximum(shape)
    assert abs(max_slope(shape, CONSTANTS) - true) <= tolerance(true)


@pytest.mark.parametrize("seed", range(12))
def test_max_slope_at_the_slope_limit(seed: int) -> None:
    """Where the decision falls: triples that the projection has put on the limit."""
    rng = np.random.default_rng(seed)
    shape = project(PotentialParameters(float(10 ** rng.uniform(-3, -1)), float(rng.uniform(6, 17)), 9.0), CONSTANTS)
    true = true_maximum(shape)
    assert true == pytest.approx(CONSTANTS.z, abs=1e-6)
    assert true <= CONSTANTS.z + SLOPE_ERROR
    assert abs(max_slope(shape, CONSTANTS) - true) <= tolerance(true)


def test_max_slope_may_stop_at_enough() -> None:
    shape = PotentialParameters(1e-3, 8.0, 9.0)
    assert 4.0 < max_slope(shape, CONSTANTS, enough=4.0) <= max_slope(shape, CONSTANTS)


@given(any_triple(), st.floats(0, 1), st.floats(0, 1))
@settings(max_examples=300)
def test_cell_bound_bounds(shape: PotentialParameters, one: float, other: float) -> None:
    a, b = shape.r + 3.0 * min(one, other), shape.r + 3.0 * max(one, other)
    if not shape.r <= a < b <= shape.r + 3.0:
        return
    lower, upper = cell_bound(np.array([a]), np.array([b]), shape, CONSTANTS)
    inside = np.abs(potential_slope(np.linspace(a, b, 1001), shape, CONSTANTS)).max()
    assert lower[0] <= inside * (1 + 1e-14)
    assert inside <= upper[0] * (1 + 1e-14) + 1e-14


def test_cell_bound_holds_the_third_derivative_of_the_paper_s_potential() -> None:
    """At 50,000 places, near L, at the hill's edges and with p = 3 among them; JAX differentiates the formula."""
    jax = pytest.importorskip("jax")
    rng, count = np.random.default_rng(4), 50_000
    alpha, p = 10 ** rng.uniform(-3, -1, count), np.where(rng.random(count) < 0.3, 3.0, rng.uniform(3, 9, count))
    r = 5 + np.where(rng.random(count) < 0.7, 10 ** rng.uniform(-6, 1, count), rng.uniform(0, 12, count))
    depth = 10 ** rng.uniform(-2, np.log10(1.5), count)
    s = np.where(rng.random(count) < 0.5, r + depth, r + 3.0 - depth)

    def V(s: float, alpha: float, r: float, p: float) -> float:
        return alpha * (20.0 - s) ** 3 / (s - 5.0) + ((r + 3.0 - s) * (s - r)) ** p / (s - 5.0) ** 2

    third = jax.grad(jax.grad(jax.grad(V)))
    with jax.enable_x64(True):
        true = np.abs(np.asarray(jax.jit(jax.vmap(third))(s, alpha, r, p)))
    width = 1e-3 * depth
    shapes = SimpleNamespace(alpha=alpha, r=r, p=p, hill=1.0)
    lower, upper = cell_bound(s, s + width, shapes, CONSTANTS)
    rounding = 8.0 * np.spacing(upper) / width**2
    assert ((upper - lower) * 8.0 / width**2 >= true * (1 - 1e-6) - rounding).all()
    assert np.median(rounding / true) < 1e-6


def test_cell_bound_tightens_with_the_square_of_the_width() -> None:
    widths = 0.1 / 2.0 ** np.arange(6)
    lower, upper = cell_bound(np.full(6, 12.0), 12.0 + widths, BEST_FIXED, CONSTANTS)
    ratios = (upper - lower)[:-1] / (upper - lower)[1:]
    assert (ratios > 3.5).all()


@pytest.mark.parametrize("seed", range(25))
def test_project_leaves_feasible_triples_alone(seed: int) -> None:
    shape = feasible_triple(seed)
    require_feasible(shape, CONSTANTS)
    assert project(shape, CONSTANTS) == shape


anywhere = st.builds(PotentialParameters, st.floats(-1, 2), st.floats(-50, 90), st.floats(-20, 40))
huge = st.sampled_from([-1e308, -1.0, 0.0, 5.0, 5.0 + 1e-12, 17.0, 1e308])


@given(anywhere | any_triple() | st.builds(PotentialParameters, huge, huge, huge))
@settings(max_examples=80)
def test_project_ends_in_the_feasible_set_and_stays(shape: PotentialParameters) -> None:
    inside = project(shape, CONSTANTS)
    require_feasible(inside, CONSTANTS)
    assert project(inside, CONSTANTS) == inside


@given(
    any_triple(),
    st.builds(
        lambda L, room, z: PlatoonParameters(L=L, lam=L + 3 + room, z=z),
        st.floats(1, 9),
        st.floats(0.01, 30),
        st.floats(0.05, 20),
    ),
)
@settings(max_examples=80)
def test_project_for_other_constants(shape: PotentialParameters, constants: PlatoonParameters) -> None:
    """The result is feasible; and where none is said to exist, a plain search finds none either."""
    try:
        inside = project(shape, constants)
    except ModelError as error:
        assert error.key == "empty"
        rng = np.random.default_rng(0)
        for _ in range(60):
            r = constants.L + (constants.lam - 3 - constants.L) * (1 - rng.uniform() ** 2)
            other = PotentialParameters(float(10 ** rng.uniform(-3, -1)), float(r), float(3 + 6 * rng.uniform() ** 4))
            with pytest.raises(ModelError):
                require_feasible(other, constants)
        return
    require_feasible(inside, constants)
    assert project(inside, constants) == inside


@pytest.mark.parametrize("room", [0.2, 0.8, 2.0, 10.0])
def test_project_finds_the_last_feasible_triple(room: float) -> None:
    """With z between the flattest hill of all, found by a grid in alpha and r, and what alpha = 1e-3 can do."""
    constants = PlatoonParameters(lam=8.0 + room)
    slopes = [
        max_slope(PotentialParameters(float(alpha), r, 3.0), constants)
        for alpha in np.geomspace(ALPHA_MIN, ALPHA_MAX, 60)
        for r in (5 + 0.5 * room, 5 + 0.9 * room, 5 + room)
    ]
    tight = replace(constants, z=min(slopes) * (1 + 1e-6))
    assert min(slopes) < max_slope(PotentialParameters(ALPHA_MIN, 5 + room, 3.0), constants)
    for alpha in (ALPHA_MIN, 0.01, ALPHA_MAX):
        inside = project(PotentialParameters(alpha, 6.0, 5.0), tight)
        require_feasible(inside, tight)
        assert project(inside, tight) == inside
    with pytest.raises(ModelError, match="no alpha, r, p"):
        project(BEST_FIXED, replace(constants, z=min(slopes) * 0.98))


@pytest.mark.parametrize("shape", [PotentialParameters(1e-3, 9.0, 9.0), PotentialParameters(1e-1, 15.0, 8.0)])
def test_project_lowers_p_no_further_than_needed(shape: PotentialParameters) -> None:
    inside = project(shape, CONSTANTS)
    assert (inside.alpha, inside.r) == (shape.alpha, shape.r)
    assert true_maximum(replace(inside, p=inside.p + 1e-6)) > CONSTANTS.z


def test_nothing_above_p_7_5_is_feasible() -> None:
    """Design, section 1: a stronger statement than the paper's for p > 9."""
    slopes = [max_slope(PotentialParameters(a, 17.0, 7.6), CONSTANTS) for a in (1e-3, 1e-2, 1e-1)]
    assert min(slopes) > CONSTANTS.z


OUTSIDE = [
    (PotentialParameters(0.0009, 11, 5.5), "alpha", ["alpha = 0.0009", "[0.001, 0.1]"]),
    (PotentialParameters(0.11, 11, 5.5), "alpha", ["alpha = 0.11", "[0.001, 0.1]"]),
    (PotentialParameters(1e-3, 5.0, 5.5), "r", ["r = 5 m", "L = 5 m", "lambda - 3 m = 17 m"]),
    (PotentialParameters(1e-3, 17.01, 5.5), "r", ["r = 17.01 m", "17 m"]),
    (PotentialParameters(1e-3, 11, 2.99), "p", ["p = 2.99", "[3, 9]"]),
    (PotentialParameters(1e-3, 11, 9.01), "p", ["p = 9.01", "[3, 9]"]),
    (PotentialParameters(1e-3, 8, 7.0), "slope", ["m/s2", "p = 7", "z = 4 m/s2", "lower p"]),
]


@pytest.mark.parametrize(("shape", "key", "words"), OUTSIDE)
def test_require_feasible_names_the_violated_bound(shape: PotentialParameters, key: str, words: list[str]) -> None:
    with pytest.raises(ModelError) as caught:
        require_feasible(shape, CONSTANTS)
    assert caught.value.key == key
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_bounds_belong_to_the_feasible_set() -> None:
    roomy = replace(CONSTANTS, z=1e6)
    for alpha in (ALPHA_MIN, ALPHA_MAX):
        for r in (6.0, 17.0):
            for p in (P_MIN, P_MAX):
                require_feasible(PotentialParameters(alpha, r, p), roomy)


@pytest.mark.parametrize("lam", [1e80, 1e103, 1e110, 1e160])
def test_a_slope_whose_bound_overflows_is_refused_and_takes_no_memory(lam):
    """Without a limit the search would cut the hill into cells as long as there is memory."""
    with pytest.raises(ModelError, match="must not exceed z"):
        require_feasible(BEST_FIXED, PlatoonParameters(lam=lam))
