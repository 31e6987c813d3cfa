"""The law for any desired speed from 0 to v_max: Theorem 1's signs, the paper's law in between, a standing platoon."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from psp_model import BEST_FIXED, V_OLD, Lemma1Policy, PlatoonState, PotentialParameters, SampledPlatoon, Sampling
from psp_model.law.feedback import SPEED_MARGIN, feedback, feedback_towards, repulsion
from psp_model.law.potential import potential_slope
from psp_model.sampling.hold import Motion, advance, travelled
from psp_model.sampling.lemma1 import largest_period
from psp_model.vehicles.ideal import STOPPING, IdealPlant
from strategies import CONSTANTS, Vector, omega, shapes

V_MAX = CONSTANTS.v_max
EDGES = [0.0, 1e-300, 1e-9, SPEED_MARGIN, V_MAX - SPEED_MARGIN, float(np.nextafter(V_MAX, 0.0)), V_MAX]
desired_speeds = st.floats(0.0, V_MAX) | st.sampled_from(EDGES)
Start = tuple[Vector, Vector]


@given(omega(1e-6), shapes(), desired_speeds)
@settings(max_examples=120)
def test_theorem_1_s_signs_hold_for_every_desired_speed(
    start: Start, shape: PotentialParameters, desired: float
) -> None:
    s, v = start
    standing = feedback_towards(s, np.zeros_like(v), shape, CONSTANTS, desired)
    fastest = feedback_towards(s, np.full_like(v, V_MAX), shape, CONSTANTS, desired)
    assert (standing >= CONSTANTS.mu * desired).all() and (fastest <= CONSTANTS.mu * (desired - V_MAX)).all()
    assert np.isfinite(feedback_towards(s, v, shape, CONSTANTS, desired)).all()


@given(omega(1e-6), shapes(), st.floats(SPEED_MARGIN, V_MAX - SPEED_MARGIN))
@settings(max_examples=60)
def test_away_from_the_bounds_it_is_the_paper_s_law_bit_for_bit(
    start: Start, shape: PotentialParameters, desired: float
) -> None:
    expected = feedback(*start, shape, replace(CONSTANTS, v_star=desired))
    assert feedback_towards(*start, shape, CONSTANTS, desired).tolist() == expected.tolist()


@given(omega(1e-6), shapes(), st.floats(V_MAX - SPEED_MARGIN, V_MAX))
@settings(max_examples=60)
def test_faster_it_is_the_paper_s_law_for_the_edge_with_its_goal_moved(
    start: Start, shape: PotentialParameters, desired: float
) -> None:
    """Gains and repulsion stay those of v* = v_max - margin: what is added does not depend on the vehicle's speed."""
    s, v = start
    edge = V_MAX - SPEED_MARGIN
    added, elsewhere = (
        feedback_towards(s, speeds, shape, CONSTANTS, desired) - feedback_towards(s, speeds, shape, CONSTANTS, edge)
        for speeds in (v, V_MAX - v)
    )
    scale = 1e-13 * (1.0 + np.abs(repulsion(s, shape, CONSTANTS))) * V_MAX
    assert (np.abs(added - elsewhere) <= scale).all()
    assert (added >= CONSTANTS.mu * (desired - edge) - scale).all()


@given(omega(1e-2), shapes(), st.floats(1e-6, SPEED_MARGIN))
@settings(max_examples=60)
def test_slower_it_is_a_feedback_of_the_paper_s_form_with_less_repulsion(
    start: Start, shape: PotentialParameters, desired: float
) -> None:
    """F = -k (v - v_d) + (v_d / margin) u with k >= mu, from which the Lyapunov argument of Theorem 1 follows."""
    s, v = start
    weaker = desired / SPEED_MARGIN * repulsion(s, shape, CONSTANTS)
    force = feedback_towards(s, v, shape, CONSTANTS, desired)
    rest = force - weaker + CONSTANTS.mu * (v - desired)  # of the sign opposite to v - v_d
    tolerance = 1e-12 * (1.0 + np.abs(force) + np.abs(weaker) + V_MAX)
    assert (rest * np.sign(v - desired) <= tolerance).all()


@given(omega(1e-6), shapes())
@settings(max_examples=60)
def test_told_to_stand_speeds_fall_and_the_potential_stays_bounded(start: Start, shape: PotentialParameters) -> None:
    """Every speed falls by mu v at least, and sum V + margin sum v never grows (docs/theory.md)."""
    s, v = start
    a = feedback_towards(s, v, shape, CONSTANTS, 0.0)
    assert (a <= -CONSTANTS.mu * v).all()
    slopes = potential_slope(s, shape, CONSTANTS)
    of_potential = slopes * (v[:-1] - v[1:])  # dV(s_i)/dt
    rate = of_potential.sum() + SPEED_MARGIN * a.sum()
    scale = 1.0 + np.abs(slopes).sum() * V_MAX
    assert rate <= -CONSTANTS.mu * SPEED_MARGIN * v.sum() + 1e-12 * scale


@given(omega(1e-2, most=8), shapes())
@settings(max_examples=20)
def test_told_to_stand_a_platoon_comes_to_rest(start: Start, shape: PotentialParameters) -> None:
    """Under sampling too, as long as Lemma 1 holds: nobody goes further than v / mu."""
    s, v = start
    moved, furthest = np.zeros_like(v), v / CONSTANTS.mu
    for _ in range(150):
        a = feedback_towards(s, v, shape, CONSTANTS, 0.0)
        tau = 0.999 * min(float(largest_period(s, v, a, CONSTANTS)), 0.5)
        moved += travelled(v, a, tau)
        s, v = advance(s, v, a, tau)
        assert (s > CONSTANTS.L).all() and (v >= 0).all()
    assert (moved <= furthest * (1 + 1e-12)).all()


@pytest.mark.parametrize("shape", [V_OLD, BEST_FIXED])
@pytest.mark.parametrize("spacing", [CONSTANTS.L + 1e-9, 6.0, 11.0, 19.0, 40.0])
def test_who_stands_and_is_told_to_stand_is_commanded_nothing(shape: PotentialParameters, spacing: float) -> None:
    s, v = np.array([spacing, 8.0, spacing]), np.zeros(4)
    assert feedback_towards(s, v, shape, CONSTANTS, 0.0).tolist() == [0.0] * 4


@given(
    st.lists(st.floats(0.0, 35.0) | st.sampled_from([0.0, 1e-300, 1e-17]), min_size=3, max_size=3),
    st.lists(st.floats(-1e4, 1e4) | st.sampled_from([0.0, -5e-324]), min_size=3, max_size=3),
    st.floats(1e-6, 10.0),
)
def test_the_plant_s_vehicles_do_not_reverse(v: list[float], a: list[float], T: float) -> None:
    start = Motion(3.0, np.array([1e4, 1e4]), np.array(v))
    end, _ = STOPPING.advance(start, np.array(a), T)
    for i in range(3):
        stands_at = v[i] / -a[i] if a[i] < 0 else np.inf
        expected = T * v[i] + 0.5 * T * T * a[i] if stands_at >= T else 0.5 * v[i] * stands_at
        moved = end.positions()[i] - start.positions()[i]
        assert moved == pytest.approx(expected, rel=1e-9, abs=1e-9 * (1 + T * T * abs(a[i])))
        assert end.v[i] == max(v[i] + T * a[i], 0.0)


def test_a_plant_that_brakes_at_standstill_stands_exactly() -> None:
    plant = IdealPlant.begin(PlatoonState(np.array([6.0, 7.0]), np.array([0.005, 0.0, 3.0])), 0.01)
    plant = plant.advanced_to(1, np.array([-1.0, -2.0, -8.0]))
    seen = plant.now
    assert seen.v.tolist() == [0.0, 0.0, 3.0 - 0.08]
    plant = plant.advanced_to(1000, np.array([-1.0, -2.0, -8.0]))
    assert plant.now.v.tolist() == [0.0] * 3 and plant.now.x == seen.x and plant.now.s[0] == seen.s[0]


@pytest.mark.parametrize("policy", [Lemma1Policy.WARN, Lemma1Policy.SHORTEN])
@pytest.mark.parametrize("shape", [V_OLD, BEST_FIXED], ids=["V_old", "V_new"])
def test_a_closed_loop_lives_with_speeds_at_the_bounds_and_a_rounding_error_beyond(
    shape: PotentialParameters, policy: Lemma1Policy
) -> None:
    s, v = np.array([90.0, 80.0, 95.0]), np.array([0.0, V_MAX, 0.0, V_MAX])
    platoon = SampledPlatoon.begin(PlatoonState(s, v), shape, sampling=Sampling(0.01, policy))
    beyond = platoon.now.vehicles._replace(v=v + np.array([-1e-18, 1e-14, -1e-12, 7e-15]))
    platoon.now = platoon.now._replace(vehicles=beyond)
    platoon.advance_to(1, 0.0)
    for period in range(2, 150):
        platoon.advance_to(period, 0.0)
        assert (platoon.now.v >= 0.0).all() and (platoon.now.v <= V_MAX).all()
        assert (platoon.now.s > CONSTANTS.L).all()
