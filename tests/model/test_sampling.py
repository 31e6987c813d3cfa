"""The sampling clock: what happens at the sampling instants does not depend on who looks when."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import frexp

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from psp_model import (
    BEST_FIXED,
    V_OLD,
    Lemma1Policy,
    ModelError,
    ObjectiveWeights,
    PlatoonState,
    SampledPlatoon,
    Sampling,
)
from psp_model.law.feedback import feedback
from psp_model.platoon import Observation
from psp_model.sampling.clock import MOST_PERIODS, TIME_TOLERANCE, locate
from psp_model.sampling.lemma1 import largest_period
from psp_model.sampling.loop import Instant, step
from strategies import CONSTANTS, paper_start

T = 0.01  # [s]
END = 1.0  # [s]
STATE = ("x", "s", "v", *(name for name in Instant._fields if name != "vehicles"))


def steps_of(step: float) -> list[float]:
    """Communication points of a master that adds its step up, rounding errors and all."""
    times, time = [], 0.0
    while (time := time + step) < END + 1e-9:
        times.append(time)
    return times


def random_times(seed: int) -> list[float]:
    return sorted(np.random.default_rng(seed).uniform(0, END, 250).tolist())


def noisy(times: list[float]) -> list[float]:
    rng = np.random.default_rng(1)
    return [time + rng.uniform(-1e-12, 1e-12) for time in times]


SEQUENCES: dict[str, list[float]] = {
    "T": steps_of(T),
    "5 T": steps_of(5 * T),
    "T/4": steps_of(T / 4),
    "0.037 s": steps_of(0.037),
    "random": random_times(3),
    "T with noise": noisy(steps_of(T)),
    "T/4 with noise": noisy(steps_of(T / 4)),
    "zero steps between": sorted(steps_of(T / 2) * 3),
    "one leap": [END],
}


def walk(platoon: SampledPlatoon, times: list[float]) -> dict[int, Observation]:
    """Look at all times, as a master does; what was seen at the sampling instants, by their number."""
    seen = {0: platoon.observe(0, 0.0)}
    for time in times:
        at = locate(time, platoon.sampling.T)
        platoon.advance_to(*at)
        observed = platoon.observe(*at)
        if at[1] == 0.0:
            seen[at[0]] = observed
    return seen


def platoon(policy: Lemma1Policy, spacing: float | None = None) -> SampledPlatoon:
    s, v = paper_start(8, 5)
    if spacing is not None:
        s[1] = spacing
    return SampledPlatoon.begin(PlatoonState(s, v, x_leader=100.0), V_OLD, sampling=Sampling(T, policy))


CASES: dict[str, Callable[[], SampledPlatoon]] = {
    "policy 1": lambda: platoon(Lemma1Policy.ERROR),
    "policy 2, violated": lambda: platoon(Lemma1Policy.WARN, spacing=6.5),
    "policy 3, shortened": lambda: platoon(Lemma1Policy.SHORTEN, spacing=CONSTANTS.L + 0.02),
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("name", SEQUENCES)
def test_the_same_at_common_sampling_instants(name: str, case: str) -> None:
    plain, other = CASES[case](), CASES[case]()
    expected, seen = walk(plain, SEQUENCES["T"]), walk(other, [*SEQUENCES[name], END])
    assert len(seen) >= 2
    for k, observation in seen.items():
        for name, one, another in zip(Observation._fields, observation, expected[k], strict=True):
            assert np.array_equal(one, another), (k, name)
    assert plain.now.violations == other.now.violations
    assert (plain.now.violations > 0) == (case != "policy 1")


@given(st.lists(st.floats(1e-6, 0.2), min_size=1, max_size=30))
@settings(max_examples=40)
def test_any_steps_lead_to_the_same_sampling_instants(steps: list[float]) -> None:
    walked, leapt = CASES["policy 1"](), CASES["policy 1"]()
    walk(walked, np.cumsum(steps).tolist())
    leapt.advance_to(walked.now.period, 0.0)
    for name in STATE:
        assert np.array_equal(getattr(walked.now, name), getattr(leapt.now, name)), name


def test_between_instants_the_state_is_the_exact_polynomial() -> None:
    run = CASES["policy 1"]()
    run.advance_to(7, 0.0)
    now = run.now
    for fraction in (0.1, 0.5, 0.999):
        tau = fraction * T
        seen = run.observe(7, fraction)
        x = run.observe(7, 0.0).x + tau * now.v + tau**2 / 2 * now.a
        np.testing.assert_allclose(seen.x, x, rtol=0, atol=1e-12)
        np.testing.assert_allclose(seen.s, x[:-1] - x[1:], rtol=0, atol=1e-12)
        np.testing.assert_allclose(seen.v, now.v + tau * now.a, rtol=0, atol=1e-12)
        assert np.array_equal(seen.a, now.a)


def test_between_short_periods_too_time_counts_from_the_last_instant() -> None:
    run = CASES["policy 3, shortened"]()
    run.advance_to(0, 0.3)
    now = run.now
    assert 0.0 < now.fraction <= 0.3 and now.span < 1.0
    for part in (0.0, 0.25, 1.0):
        tau = part * now.span * T
        seen = run.observe(0, now.fraction + part * now.span)
        np.testing.assert_allclose(seen.v, now.v + tau * now.a, rtol=0, atol=1e-12)
        moved = tau * now.v + tau**2 / 2 * now.a
        np.testing.assert_allclose(seen.s, now.s + moved[:-1] - moved[1:], rtol=0, atol=1e-12)


def test_running_cost_between_instants_is_the_integral() -> None:
    """Simpson's rule is exact for the quadratic spacings and the constant accelerations."""
    run, weights = CASES["policy 1"](), ObjectiveWeights()
    middle, end = run.observe(0, 0.5), run.observe(0, 1.0)
    area = T / 6 * (run.now.s.sum() + 4 * middle.s.sum() + end.s.sum())
    assert end.cost[1] == pytest.approx(weights.w2 * area / weights.s_ref, rel=1e-13)
    assert end.cost[0] == pytest.approx(weights.w1 * T * (run.now.a**2).sum() / weights.a_ref**2, rel=1e-13)


def test_at_a_sampling_instant_acceleration_and_T_max_belong_to_the_state_shown() -> None:
    run = CASES["policy 1"]()
    for period in range(5):
        run.advance_to(period, 0.0)
        seen = run.observe(period, 0.0)
        assert np.array_equal(seen.a, feedback(seen.s, seen.v, V_OLD, CONSTANTS))
        assert run.now.T_max == largest_period(seen.s, seen.v, seen.a, CONSTANTS)


def test_sampling_again_at_the_same_instant_replaces_its_verdict_and_later_adds_to_it() -> None:
    run = CASES["policy 3, shortened"]()
    first = run.now
    assert first.violations == 1
    run = run.take_over(0, 0.0, first.x, first.s, first.v, V_OLD)
    assert run.now.violations == 1
    apart = np.full(first.s.size, 40.0)
    run = run.take_over(0, 0.0, first.x, apart, first.v, V_OLD)
    assert run.now.violations == 0 and run.now.T_max > T
    run = run.take_over(0, 0.0, first.x, first.s, first.v, V_OLD)
    assert run.now.violations == 1
    run = run.take_over(0, 0.5 * run.now.span, first.x, first.s, first.v, V_OLD)
    assert run.now.violations == 2
    run = run.take_over(0, run.now.fraction, first.x, apart, first.v, V_OLD)
    assert run.now.violations == 1


def test_sampling_again_at_the_same_instant_where_T_is_T_max() -> None:
    s, v = paper_start(8, 5)
    bound = float(largest_period(s, v, feedback(s, v, V_OLD, CONSTANTS), CONSTANTS))
    run = SampledPlatoon.begin(PlatoonState(s, v), V_OLD, sampling=Sampling(bound, Lemma1Policy.SHORTEN))
    assert run.now.violations == 1
    run = run.take_over(0, 0.0, 0.0, s, v, V_OLD)
    assert run.now.violations == 1


def test_the_cost_goes_on_through_a_change() -> None:
    changed, plain = CASES["policy 1"](), CASES["policy 1"]()
    for run in (changed, plain):
        run.advance_to(3, 0.0)
    halfway = plain.observe(3, 0.5)
    changed = changed.take_over(3, 0.5, float(halfway.x[0]), halfway.s, halfway.v, BEST_FIXED)
    assert np.array_equal(changed.now.cost, halfway.cost) and min(changed.now.cost) > 0
    assert np.array_equal(changed.now.a, feedback(halfway.s, halfway.v, BEST_FIXED, CONSTANTS))


def test_a_change_that_is_not_certified_leaves_the_platoon_as_it_was() -> None:
    run = CASES["policy 1"]()
    run.advance_to(3, 0.0)
    before, close = run.now, run.now.s.copy()
    close[0] = CONSTANTS.L + 1e-3
    with pytest.raises(ModelError) as caught:
        run.take_over(3, 0.5, before.x, close, before.v, BEST_FIXED)
    assert caught.value.key.startswith("lemma1_")
    assert run.now is before and run.shape is V_OLD


def test_policy_3_spans_are_dyadic_and_end_at_nominal_instants() -> None:
    run = CASES["policy 3, shortened"]()
    nominal, shortened = set(), 0
    for _ in range(20_000):
        now = run.now
        if now.fraction == 0.0:
            nominal.add(now.period)
        ends = now.fraction + now.span
        assert ends <= 1.0 and now.span * T < now.T_max
        assert (now.fraction * 2.0**52).is_integer()
        if ends < 1.0:
            assert frexp(now.span)[0] == 0.5
            shortened += 1
        if now.period == 30:
            break
        run.advance_to(*((now.period + 1, 0.0) if ends == 1.0 else (now.period, ends)))
    assert nominal == set(range(31))
    assert shortened > 10


def test_exactly_max_short_periods_are_allowed_in_one_call() -> None:
    run, needed = CASES["policy 3, shortened"](), 0
    while run.now.period == 0:
        ends = run.now.fraction + run.now.span
        needed += ends < 1.0  # the one that ends at the nominal instant is none of the short ones
        run.advance_to(*((1, 0.0) if ends == 1.0 else (0, ends)))
    assert needed > 3
    run = CASES["policy 3, shortened"]()
    run.sampling = replace(run.sampling, max_short_periods=needed)
    run.advance_to(1, 0.0)
    run = CASES["policy 3, shortened"]()
    run.sampling = replace(run.sampling, max_short_periods=needed - 1)
    with pytest.raises(ModelError) as caught:
        run.advance_to(1, 0.0)
    assert caught.value.key == "short_periods"
    assert run.now.fraction > 0.0 and f"t = {run.now.fraction * T:.10g} s" in str(caught.value)


def test_policy_3_takes_the_longest_dyadic_span_that_is_certified() -> None:
    now = CASES["policy 3, shortened"]().now
    assert now.span * T < now.T_max <= 2 * now.span * T


def test_violations_count_uncertified_instants_without_shortening_what_is_certified() -> None:
    run = CASES["policy 3, shortened"]()
    now, counted = run.now, int(run.now.T_max <= T)
    while now.ends <= (50, 0.0):
        now, _ = step(run.loop, now)
        counted += now.T_max <= T
    run.advance_to(50, 0.0)
    assert run.now.violations == now.violations == counted > 0
    assert CASES["policy 1"]().now.violations == 0


@pytest.mark.parametrize("case", CASES)
def test_a_kept_instant_restores_the_run_bit_for_bit(case: str) -> None:
    run = CASES[case]()
    run.advance_to(13, 0.0)
    kept = run.now
    first = walk(run, [0.2, 0.317, 0.5])
    run.advance_to(80, 0.0)
    run.now = kept
    again = walk(run, [0.2, 0.317, 0.5])
    resumed = SampledPlatoon(run.loop, run.sampling, kept._replace())
    elsewhere = walk(resumed, [0.2, 0.317, 0.5])
    for k in (20, 50):
        for expected, *others in zip(first[k], again[k], elsewhere[k], strict=True):
            assert all(np.array_equal(one, expected) for one in others)


def test_a_kept_instant_is_not_changed_by_going_on() -> None:
    run = CASES["policy 1"]()
    kept = run.now
    copies = {name: np.copy(getattr(kept, name)) for name in STATE}
    run.advance_to(50, 0.5)
    run.observe(50, 0.5)
    for name, copy in copies.items():
        assert np.array_equal(getattr(kept, name), copy), name


@given(st.integers(0, 10**7), st.floats(-0.9, 0.9), st.sampled_from([0.01, 0.02, 0.1, 1.0, 0.003]))
def test_locate_rounds_to_a_nominal_instant_within_its_tolerance_only(k: int, noise: float, period: float) -> None:
    rounding = 1e-15 * k  # [sampling periods]
    near = locate((k + noise * TIME_TOLERANCE) * period, period)
    assert near == (k, 0.0)
    far = locate((k + 0.5 + 0.49 * noise) * period, period)
    assert far[0] == k and far[1] == pytest.approx(0.5 + 0.49 * noise, abs=1e-9 + 10 * rounding)


def test_locate_at_the_ends_of_its_tolerance_and_of_what_can_be_counted() -> None:
    assert locate(TIME_TOLERANCE, 1.0) == (0, 0.0)
    assert locate(float(np.nextafter(TIME_TOLERANCE, 1.0)), 1.0)[1] > 0.0
    assert locate(MOST_PERIODS - 1.0, 1.0) == (int(MOST_PERIODS) - 1, 0.0)
    for time in (MOST_PERIODS, -MOST_PERIODS, float("inf"), float("nan")):
        with pytest.raises(ModelError) as caught:
            locate(time, 1.0)
        assert caught.value.key == "periods"
    with pytest.raises(ModelError, match=r"^1e\+200 s are more .* T = 0\.25 s"):
        locate(1e200, 0.25)


def test_the_platoon_drives_far_without_losing_its_spacings() -> None:
    """Spacings are integrated themselves: a leader at 10 million metres changes nothing about them."""
    s, v = paper_start(8, 5)
    near = SampledPlatoon.begin(PlatoonState(s, v), BEST_FIXED)
    far = SampledPlatoon.begin(PlatoonState(s, v, x_leader=1e7), BEST_FIXED)
    near.advance_to(500, 0.0)
    far.advance_to(500, 0.0)
    assert np.array_equal(near.now.s, far.now.s) and np.array_equal(near.now.a, far.now.a)
