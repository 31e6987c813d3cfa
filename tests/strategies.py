"""What the tests of the model draw from: states of Omega, starts of the paper, triples of the feasible set."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

import reference
from psp_model import V_OLD, PlatoonParameters, PotentialParameters, StartDomain

CONSTANTS = PlatoonParameters()
Vector = NDArray[np.float64]


def paper_start(seed: int, vehicles: int) -> tuple[Vector, Vector]:
    """One start of the paper's domain."""
    s, v = StartDomain().draw(np.random.default_rng(seed), vehicles, 1)
    return s[:, 0], v[:, 0]


def steepest(alpha: float, r: float, p: float, points: int = 20_001) -> float:
    """max |V_new'| over a plain grid on the hill, from the oracle."""
    c = reference.Constants()
    step = 3.0 / (points - 1)
    return max(abs(reference.V_slope(r + k * step, alpha, r, p, True, c)) for k in range(points))


def feasible_triple(seed: int) -> PotentialParameters:
    """A random triple inside the paper's bounds and, by the oracle, under the slope limit."""
    rng = np.random.default_rng(seed)
    while True:
        alpha, r, p = 10 ** rng.uniform(-3, -1), rng.uniform(5, 17), rng.uniform(3, 9)
        if steepest(alpha, r, p, 301) < 3.99:
            return PotentialParameters(float(alpha), float(r), float(p))


def any_triple() -> st.SearchStrategy[PotentialParameters]:
    """Triples inside the paper's bounds, the slope limit aside."""
    alpha = st.floats(-3, -1).map(lambda exponent: float(np.clip(10.0**exponent, 1e-3, 1e-1)))
    return st.builds(PotentialParameters, alpha, st.floats(5.001, 17), st.floats(3, 9))


def shapes() -> st.SearchStrategy[PotentialParameters]:
    """V_old, or V_new with a feasible triple."""
    return st.just(V_OLD) | st.integers(0, 40).map(feasible_triple)


@st.composite
def omega(draw: Any, closest: float, most: int = 30) -> tuple[Vector, Vector]:
    """Spacings and speeds anywhere in Omega, with spacings down to L + closest and speeds of 0 and v_max included."""
    n = draw(st.integers(2, most))
    near = st.floats(math.log(closest), math.log(60.0)).map(lambda y: CONSTANTS.L + max(math.exp(y), closest))
    speed = st.floats(0, CONSTANTS.v_max) | st.sampled_from([0.0, CONSTANTS.v_max, CONSTANTS.v_star])
    s = draw(st.lists(near | st.floats(5.5, 25), min_size=n - 1, max_size=n - 1))
    v = draw(st.lists(speed, min_size=n, max_size=n))
    return np.array(s), np.array(v)
