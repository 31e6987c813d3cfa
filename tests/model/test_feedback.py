"""The functions that the feedback law is written with, one by one against the paper's formulas."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import reference
from psp_model import V_OLD, PlatoonParameters, PotentialParameters
from psp_model.law.feedback import command, f, g, gain, repulsion
from psp_model.law.potential import potential_slope
from strategies import CONSTANTS, Vector, omega, shapes

OTHERS = PlatoonParameters(L=4.0, lam=18.0, v_star=20.0, v_max=28.0, epsilon=0.7, mu=0.8)
SUMS = st.floats(-1e6, 1e6) | st.floats(-1.0, 1.0) | st.sampled_from([-0.7, -0.2, -0.1, 0.0, 0.5])
both = pytest.mark.parametrize("constants", [CONSTANTS, OTHERS], ids=["paper", "others"])


def oracle(constants: PlatoonParameters) -> reference.Constants:
    c = constants
    return reference.Constants(c.L, c.lam, c.v_star, c.v_max, c.epsilon, c.mu)


@both
@given(x=SUMS)
def test_f_and_g_equal_the_paper_s_cases(constants: PlatoonParameters, x: float) -> None:
    expected = reference.g(x, oracle(constants))
    assert float(f(np.array([x]), constants.epsilon)[0]) == pytest.approx(reference.f(x, oracle(constants)), rel=1e-12)
    # the paper's form subtracts two terms of the size of x
    assert float(g(np.array([x]), constants)[0]) == pytest.approx(expected, rel=1e-12, abs=1e-14 * (1 + abs(x)))
    assert float(gain(np.array([x]), constants)[0]) == pytest.approx(
        constants.mu + expected, rel=1e-12, abs=1e-14 * (1 + abs(x))
    )


@both
@given(u=SUMS, v=st.floats(0.0, 28.0))
def test_command_is_the_paper_s_feedback_with_its_gain(constants: PlatoonParameters, u: float, v: float) -> None:
    c = oracle(constants)
    expected = -(c.mu + reference.g(u, c)) * (v - c.v_star) + u
    assert float(command(np.array([u]), np.array([v]), constants)[0]) == pytest.approx(
        expected, rel=1e-12, abs=1e-13 * (1 + abs(u))
    )


@given(omega(1e-3, most=9), shapes())
def test_repulsion_adds_the_slopes_of_both_sides(start: tuple[Vector, Vector], shape: PotentialParameters) -> None:
    s, _ = start
    slopes = potential_slope(s, shape, CONSTANTS)
    u = repulsion(s, shape, CONSTANTS)
    assert u.tolist() == reference.forces(slopes.tolist())


@pytest.mark.parametrize("batch", [(), (4,), (2, 3)])
def test_nothing_acts_on_a_lone_vehicle(batch: tuple[int, ...]) -> None:
    u = repulsion(np.zeros((0, *batch)), V_OLD, CONSTANTS)
    assert u.shape == (1, *batch) and not u.any()
