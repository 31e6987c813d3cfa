"""Theorem 1 and the lemma behind it, over all of Omega: the algebra down to L + 1e-6, runs down to L + 1e-3."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import reference
from psp_model import (
    BEST_FIXED,
    V_OLD,
    Lemma1Policy,
    ModelError,
    PlatoonState,
    PotentialParameters,
    SampledPlatoon,
    Sampling,
    feedback,
    potential_slope,
    simulate,
)
from psp_model.law.feedback import f, gain, repulsion
from psp_model.sampling.loop import Instant, step
from strategies import CONSTANTS, Vector, feasible_triple, omega, paper_start, shapes

ORACLE = reference.Constants()
Start = tuple[Vector, Vector]


@given(omega(1e-6), shapes())
@settings(max_examples=300)
def test_signs_that_keep_speeds_inside(start: Start, shape: PotentialParameters) -> None:
    s, v = start
    u = repulsion(s, shape, CONSTANTS)
    assert (gain(u, CONSTANTS) >= CONSTANTS.mu).all()
    assert (feedback(s, np.zeros_like(v), shape, CONSTANTS) > 0).all()
    assert (feedback(s, np.full_like(v, CONSTANTS.v_max), shape, CONSTANTS) < 0).all()
    a = feedback(s, v, shape, CONSTANTS)
    assert (a[v == 0] > 0).all() and (a[v == CONSTANTS.v_max] < 0).all()


@given(omega(1e-6), shapes())
@settings(max_examples=300)
def test_feedback_equals_the_literal_form_of_the_paper(start: Start, shape: PotentialParameters) -> None:
    s, v = start
    ours = feedback(s, v, shape, CONSTANTS)
    hill = shape.hill == 1.0
    literal = reference.accelerations(s.tolist(), v.tolist(), shape.alpha, shape.r, shape.p, hill, ORACLE)
    # the literal form cancels terms of the size of u and of the slopes behind it
    slopes = np.abs(potential_slope(s, shape, CONSTANTS))
    around = np.maximum(np.append(slopes, 0.0), np.insert(slopes, 0, 0.0))
    assert (np.abs(ours - literal) <= 1e-13 * (1.0 + 20.0 * around)).all()


@given(st.floats(-1e12, 1e12) | st.floats(-0.3, 0.3) | st.sampled_from([-0.2, -0.1, 0.0]))
def test_f_is_the_paper_s_smoothed_positive_part(x: float) -> None:
    value = float(f(np.array([x]), CONSTANTS.epsilon)[0])
    assert value == pytest.approx(reference.f(x, ORACLE), rel=1e-12, abs=1e-14)
    assert value >= max(x, 0.0)
    assert float(f(np.array([np.nextafter(x, np.inf)]), CONSTANTS.epsilon)[0]) >= value


def instants(platoon: SampledPlatoon, periods: int) -> list[Instant]:
    """Every sampling instant of a run, the short ones included."""
    seen: list[Instant] = [platoon.now]
    while seen[-1].ends <= (periods, 0.0):
        seen.append(step(platoon.loop, seen[-1])[0])
    return seen


def assert_in_omega(seen: list[Instant]) -> None:
    for now in seen:
        assert (now.s > CONSTANTS.L).all(), (now.period, now.fraction, now.s)
        assert (now.v >= 0).all() and (now.v <= CONSTANTS.v_max).all(), (now.period, now.fraction, now.v)


@given(omega(1e-3, most=12), shapes())
@settings(max_examples=60)
def test_policy_3_never_leaves_omega(start: Start, shape: PotentialParameters) -> None:
    s, v = start
    sampling = Sampling(0.01, Lemma1Policy.SHORTEN)
    seen = instants(SampledPlatoon.begin(PlatoonState(s, v), shape, sampling=sampling), 30)
    assert_in_omega(seen)
    assert all(now.span * 0.01 < now.T_max for now in seen)


@pytest.mark.parametrize(("shape", "spacing"), [(V_OLD, 0.02), (BEST_FIXED, 0.001)], ids=["V_old", "V_new"])
def test_policy_3_keeps_a_crowd_at_L_inside_omega(shape: PotentialParameters, spacing: float) -> None:
    """Thirty vehicles, a hair above L apart, alternately standing and at the speed limit."""
    s, v = np.full(29, CONSTANTS.L + spacing), np.where(np.arange(30) % 2 == 0, 0.0, CONSTANTS.v_max)
    seen = instants(SampledPlatoon.begin(PlatoonState(s, v), shape, sampling=Sampling(0.01, Lemma1Policy.SHORTEN)), 20)
    assert seen[-1].violations > 20
    assert_in_omega(seen)


@pytest.mark.parametrize("T", [0.05, 0.3, 2.0])
def test_policy_3_lives_with_periods_far_too_long(T: float) -> None:
    s, v = paper_start(5, 7)
    platoon = SampledPlatoon.begin(PlatoonState(s, v), V_OLD, sampling=Sampling(T, Lemma1Policy.SHORTEN))
    assert_in_omega(instants(platoon, round(10.0 / T)))


@pytest.mark.parametrize(("shape", "vehicles"), [(V_OLD, 4), (BEST_FIXED, 2), (BEST_FIXED, 5), (feasible_triple(3), 5)])
def test_speeds_tend_to_v_star_and_slopes_to_0(shape: PotentialParameters, vehicles: int) -> None:
    """Near lambda V' vanishes with the square of the distance, so what remains falls as a power of time only."""
    s, v = paper_start(20 + vehicles, vehicles)
    v[0], v[-1] = 0.0, CONSTANTS.v_max
    sampling = Sampling(0.02, Lemma1Policy.SHORTEN)
    run = simulate(PlatoonState(s, v), shape, sampling=sampling, duration=256.0, output_step=64.0)
    speeds = np.abs(run.v - CONSTANTS.v_star).max(axis=1)
    slopes = np.abs(potential_slope(run.s.T, shape, CONSTANTS)).max(axis=0)
    for remainder in (speeds, slopes):
        assert remainder[4] < 0.01
        assert remainder[4] < 0.5 * remainder[1] + 1e-9


def test_too_many_short_periods_are_a_clear_error_and_the_run_can_go_on() -> None:
    start = PlatoonState(np.array([CONSTANTS.L + 1e-3]), np.array([0.0, CONSTANTS.v_max]))
    tight = Sampling(0.01, Lemma1Policy.SHORTEN, max_short_periods=10)
    platoon = SampledPlatoon.begin(start, V_OLD, sampling=tight)
    with pytest.raises(ModelError) as caught:
        platoon.advance_to(1, 0.0)
    assert caught.value.key == "short_periods"
    assert "max_short_periods = 10" in str(caught.value) and "raise max_short_periods" in str(caught.value)
    stopped = platoon.now
    assert (stopped.period, stopped.fraction > 0.0) == (0, True)
    platoon.sampling = replace(tight, max_short_periods=100_000)
    platoon.advance_to(1, 0.0)
    untroubled = SampledPlatoon.begin(start, V_OLD, sampling=platoon.sampling)
    untroubled.advance_to(1, 0.0)
    assert np.array_equal(platoon.now.s, untroubled.now.s) and np.array_equal(platoon.now.v, untroubled.now.v)


@pytest.mark.parametrize("spacing", [1e-9, 1e-12, 2e-15])
def test_runs_that_start_at_L_end_in_omega_or_in_a_clear_error(spacing: float) -> None:
    sampling = Sampling(0.01, Lemma1Policy.SHORTEN, max_short_periods=3000)
    start = PlatoonState(np.array([CONSTANTS.L + spacing, 9.0]), np.array([10.0, 20.0, 30.0]))
    platoon = SampledPlatoon.begin(start, V_OLD, sampling=sampling)
    try:
        platoon.advance_to(2, 0.0)
    except ModelError as error:
        assert error.key == "short_periods"
    assert_in_omega([platoon.now])
