"""Lemma 1: sharp at every one of its bounds, and the three policies on either side of them."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from psp_model import (
    V_OLD,
    Lemma1Policy,
    ModelError,
    PlatoonState,
    SampledPlatoon,
    Sampling,
    StartDomain,
    largest_period,
    simulate,
)
from psp_model.law.feedback import feedback
from psp_model.sampling.hold import advance
from psp_model.sampling.lemma1 import violation
from strategies import CONSTANTS, Vector, paper_start

L, V_MAX = CONSTANTS.L, CONSTANTS.v_max

# name: spacings, speeds, accelerations, and the bound that is the smallest, by hand
BOUNDS = {
    "spacing": ([5.7, 9.0], [30.0, 30.0, 30.0], [1.0, -1.0, 0.0], 0.7 / 35),
    "last spacing": ([9.0, 5.35], [30.0, 30.0, 30.0], [1.0, -1.0, 0.0], 0.35 / 35),
    "leader too fast": ([9.0, 9.0], [34.0, 30.0, 30.0], [40.0, -1.0, 2.0], 1.0 / 40),
    "last too fast": ([9.0, 9.0], [34.0, 30.0, 34.9], [4.0, -1.0, 2.0], 0.1 / 2),
    "too slow": ([9.0, 9.0], [34.0, 0.3, 30.0], [1.0, -6.0, 2.0], 0.3 / 6),
    "gently too fast": ([25.0, 25.0], [30.0, 34.9, 30.0], [0.0, 0.5, 0.0], 0.1 / 0.5),
    "alone too fast": ([], [34.0], [40.0], 1.0 / 40),
    "spacing and speed at once": ([12.0], [30.0, 34.0], [0.0, 5.0], 0.2),
}


@pytest.mark.parametrize("name", BOUNDS)
def test_T_max_is_the_smallest_bound(name: str) -> None:
    s, v, a, bound = BOUNDS[name]
    assert largest_period(np.array(s), np.array(v), np.array(a), CONSTANTS) == pytest.approx(bound, rel=1e-13)


@pytest.mark.parametrize("name", ["leader too fast", "last too fast", "too slow", "gently too fast"])
def test_speed_bounds_are_exact(name: str) -> None:
    """A period a millionth shorter keeps all speeds strictly inside, a millionth longer does not."""
    s, v, a, bound = BOUNDS[name]
    for factor, inside in ((1 - 1e-6, True), (1 + 1e-6, False)):
        _, after = advance(np.array(s), np.array(v), np.array(a), bound * factor)
        assert bool(((after > 0) & (after < V_MAX)).all()) is inside


def test_spacing_bound_is_exact_for_the_worst_speeds() -> None:
    """Leader standing, follower at v_max: the spacing falls to L in exactly (s - L)/v_max."""
    s, v, a = np.array([5.7]), np.array([0.0, V_MAX]), np.zeros(2)
    bound = float(largest_period(s, v, a, CONSTANTS))
    assert advance(s, v, a, bound * (1 - 1e-9))[0][0] > L > advance(s, v, a, bound * (1 + 1e-9))[0][0]


def test_held_speeds_bound_nothing() -> None:
    v = np.array([0.0, V_MAX, 30.0])
    assert largest_period(np.array([40.0, 40.0]), v, np.zeros(3), CONSTANTS) == pytest.approx(1.0)


@given(st.integers(0, 10_000), st.integers(2, 9))
def test_any_certified_period_stays_in_omega_throughout(seed: int, vehicles: int) -> None:
    rng = np.random.default_rng(seed)
    s, v = rng.uniform(5.05, 25, vehicles - 1), rng.uniform(0, V_MAX, vehicles)
    a = feedback(s, v, V_OLD, CONSTANTS)
    T = float(largest_period(s, v, a, CONSTANTS)) * (1 - 1e-12)
    for tau in np.linspace(0.0, T, 21):
        spacings, speeds = advance(s, v, a, tau)
        assert (spacings > L).all() and (speeds >= 0).all() and (speeds <= V_MAX).all()


@pytest.mark.parametrize("policy", list(Lemma1Policy))
def test_T_is_certified_strictly_below_T_max_only(policy: Lemma1Policy) -> None:
    s, v = paper_start(2, 7)
    start = PlatoonState(s, v)
    T_max = float(largest_period(s, v, feedback(s, v, V_OLD, CONSTANTS), CONSTANTS))
    below = SampledPlatoon.begin(start, V_OLD, sampling=Sampling(float(np.nextafter(T_max, 0.0)), policy)).now
    assert (below.violations, below.span, below.T_max) == (0, 1.0, T_max)
    if policy is Lemma1Policy.ERROR:
        with pytest.raises(ModelError, match="is not below T_max"):
            SampledPlatoon.begin(start, V_OLD, sampling=Sampling(T_max, policy))
    else:
        at = SampledPlatoon.begin(start, V_OLD, sampling=Sampling(T_max, policy)).now
        assert (at.violations, at.span) == (1, 0.5 if policy is Lemma1Policy.SHORTEN else 1.0)


@cache
def start_too_fast_for(T: float) -> tuple[Vector, Vector]:
    """The start of the paper's domain, out of 200, that V_old drives furthest above v_max when sampled with T."""
    s, v = StartDomain().draw(np.random.default_rng(7), 7, 200)
    start, fastest = (s.copy(), v.copy()), v.max(axis=0)
    for _ in range(round(2.0 / T)):
        s, v = advance(s, v, feedback(s, v, V_OLD, CONSTANTS), T)
        fastest = np.maximum(fastest, v.max(axis=0))
    worst = int(np.argmax(fastest))
    return start[0][:, worst], start[1][:, worst]


def test_V_old_at_20_ms_is_refused_where_it_would_break_the_speed_limit() -> None:
    start = PlatoonState(*start_too_fast_for(0.02))
    with pytest.raises(ModelError) as caught:
        simulate(start, V_OLD, sampling=Sampling(0.02), duration=2.0)
    assert caught.value.key == "lemma1_fast"
    ignored = simulate(start, V_OLD, sampling=Sampling(0.02, Lemma1Policy.WARN), duration=2.0)
    assert ignored.v.max() > V_MAX + 0.1
    assert ignored.violations >= 1
    certified = simulate(start, V_OLD, sampling=Sampling(0.01))
    assert certified.v.max() < V_MAX and certified.violations == 0 and (certified.T_max > 0.01).all()


def test_policy_3_takes_the_same_start_through_at_20_ms() -> None:
    start = PlatoonState(*start_too_fast_for(0.02))
    run = simulate(start, V_OLD, sampling=Sampling(0.02, Lemma1Policy.SHORTEN))
    assert run.v.max() < V_MAX and run.v.min() > 0 and run.s.min() > L
    assert run.violations >= 1


def test_policy_1_refuses_during_the_run_too_and_stays_at_that_instant() -> None:
    """Far apart at first, and closing in: the refused instant is kept and can be looked at."""
    start = PlatoonState(np.array([30.0]), np.array([0.0, V_MAX]))
    platoon = SampledPlatoon.begin(start, V_OLD, sampling=Sampling(0.3))
    with pytest.raises(ModelError) as caught:
        platoon.advance_to(20, 0.0)
    now = platoon.now
    assert 0 < now.period < 20 and now.T_max <= 0.3
    assert caught.value.key == "lemma1_fast" and f"t = {now.period * 0.3:.10g} s" in str(caught.value)
    assert np.array_equal(platoon.observe(now.period, 0.0).v, now.v)


@pytest.mark.parametrize(
    ("name", "key", "words"),
    [
        ("spacing", "lemma1_spacing", ["vehicle 2", "s[2] = 5.7 m", "L = 5 m", "35 m/s", "T < 0.02 s"]),
        ("last spacing", "lemma1_spacing", ["vehicle 3", "s[3] = 5.35 m", "T < 0.01 s"]),
        ("leader too fast", "lemma1_fast", ["vehicle 1", "v[1] = 34 m/s", "a[1] = 40 m/s2", "35 m/s", "T < 0.025 s"]),
        ("too slow", "lemma1_slow", ["vehicle 2", "v[2] = 0.3 m/s", "a[2] = -6 m/s2", "a stop, 0 m/s", "T < 0.05 s"]),
        ("gently too fast", "lemma1_fast", ["vehicle 2", "v[2] = 34.9 m/s", "a[2] = 0.5 m/s2", "T < 0.2 s"]),
        ("alone too fast", "lemma1_fast", ["vehicle 1", "v[1] = 34 m/s", "a[1] = 40 m/s2", "T < 0.025 s"]),
        ("spacing and speed at once", "lemma1_spacing", ["vehicle 2", "s[2] = 12 m", "T < 0.2 s"]),
    ],
)
def test_the_violation_names_vehicle_values_bound_and_remedy(name: str, key: str, words: list[str]) -> None:
    s, v, a, _ = BOUNDS[name]
    error = violation(1.25, 0.3, np.array(s), np.array(v), np.array(a), CONSTANTS)
    assert error.key == key
    for word in [*words, "T = 0.3 s", "t = 1.25 s", "lemma1_policy 3"]:
        assert word in str(error), (word, str(error))


def test_policy_2_warns_once_per_stretch_and_counts_every_instant() -> None:
    sentences: list[str] = []
    start = PlatoonState(*start_too_fast_for(0.02))
    platoon = SampledPlatoon.begin(start, V_OLD, sampling=Sampling(0.02, Lemma1Policy.WARN), warn=sentences.append)
    uncertified = [platoon.now.T_max <= 0.02]
    for period in range(1, 200):
        platoon.advance_to(period, 0.0)
        uncertified.append(platoon.now.T_max <= 0.02)
    stretches = sum(now and not before for before, now in zip([False, *uncertified], uncertified, strict=False))
    assert platoon.now.violations == sum(uncertified) > 0
    assert len(sentences) == stretches > 0


def test_a_resumed_platoon_is_silent_until_it_is_told_whom_to_warn() -> None:
    start, sampling = PlatoonState(*start_too_fast_for(0.02)), Sampling(0.02, Lemma1Policy.WARN)
    original = SampledPlatoon.begin(start, V_OLD, sampling=sampling)
    resumed = SampledPlatoon(original.loop, sampling, original.now)
    for platoon in (original, resumed):
        platoon.advance_to(100, 0.0)
    assert resumed.now.violations == original.now.violations > 0
    sentences: list[str] = []
    again = SampledPlatoon(original.loop, sampling, original.now)
    again.now, again.warn = SampledPlatoon.begin(start, V_OLD, sampling=sampling).now, sentences.append
    again.advance_to(100, 0.0)
    assert sentences and np.array_equal(again.now.v, resumed.now.v)


def test_policy_2_says_where_the_model_ends() -> None:
    """Driven far beyond its certificate, a spacing can pass L; the run must stop there and not divide by zero."""
    start = PlatoonState(np.array([5.5, 9.0]), np.array([0.0, V_MAX, V_MAX]))
    platoon = SampledPlatoon.begin(start, V_OLD, sampling=Sampling(0.1, Lemma1Policy.WARN))
    with pytest.raises(ModelError) as caught:
        platoon.advance_to(10, 0.0)
    assert caught.value.key == "left_spacing" and "lemma1_policy 3" in str(caught.value)
    assert platoon.now.s.min() <= start.constants.L < start.s.min()  # what is said is what is shown
