"""The pure loop: functions of explicit state that change nothing, and that the shell around them only repeats."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import reference
from class_examples import plain
from psp_model import (
    BEST_FIXED,
    V_OLD,
    Actuation,
    DelayedVehicles,
    Lemma1Policy,
    ModelError,
    ObjectiveWeights,
    PlatoonState,
    PotentialParameters,
    SampledPlatoon,
    Sampling,
)
from psp_model.platoon import loop_of
from psp_model.sampling.hold import IDEAL, Motion
from psp_model.sampling.loop import SHORTEST, Instant, Loop, Verdict, after, begin, refusal, resample, step
from psp_model.vehicles.ideal import STOPPING
from strategies import CONSTANTS, paper_start

WEIGHTS = ObjectiveWeights(w1=0.3, s_ref=7.0)
PLANTS: dict[str, Any] = {"ideal": IDEAL, "stopping": STOPPING, "delayed": DelayedVehicles(Actuation(0.013, 0.1))}


def loop_with(T: float = 0.01, policy: int = 1, shape: PotentialParameters = BEST_FIXED, plant: Any = IDEAL) -> Loop:
    return loop_of(shape, CONSTANTS, WEIGHTS, Sampling(T, policy), plant=plant)


def arrays_in(one: Any) -> list[np.ndarray[Any, Any]]:
    """All arrays of a state, however deep."""
    if isinstance(one, np.ndarray):
        return [one]
    return [array for part in one for array in arrays_in(part)] if isinstance(one, tuple | list) else []


@given(st.integers(0, 50), st.integers(1, 9), st.sampled_from(list(PLANTS)), st.sampled_from([1, 3]))
@settings(max_examples=40)
def test_the_same_inputs_give_the_same_outputs_and_are_left_as_they_were(seed, n, name, policy) -> None:
    loop = loop_with(0.03, policy, V_OLD, PLANTS[name])
    s, v = paper_start(seed, n)
    kept = plain((s, v))
    first, again = begin(loop, 1.5, s, v), begin(loop, 1.5, s, v)
    assert plain(first) == plain(again) and plain((s, v)) == kept and s.flags.writeable and v.flags.writeable
    now, _ = first
    for _ in range(3):
        before = plain(now)
        motion = (0.5, now.s + 0.25, now.v * 0.99)
        at = (now.period, now.fraction + 0.25 * now.span)
        for function, told in ((step, ()), (resample, (at, motion)), (after, (0.004,))):
            assert plain(function(loop, now, *told)) == plain(function(loop, now, *told))
        assert plain(now) == before
        now, _ = step(loop, now)


@pytest.mark.parametrize("name", PLANTS)
def test_no_array_of_a_state_can_be_written_to(name: str) -> None:
    s, v = paper_start(3, 4)
    platoon = SampledPlatoon.begin(PlatoonState(s, v), BEST_FIXED, plant=PLANTS[name])
    states = [platoon.now]
    platoon.advance_to(5, 0.25)
    seen = [platoon.now, platoon.observe(5, 0.0)]
    changed = platoon.take_over(5, 0.25, 3.0, s + 1.0, v, V_OLD)
    for one in [*states, *seen, changed.now]:
        spacings, speeds, held = one.s, one.v, getattr(one, "a", np.zeros(1))
        for array in (spacings, speeds, *([held] if isinstance(one, Instant) else [])):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 1.0
    s[0] = 99.0  # what was handed in stays its owner's
    assert states[0].s[0] != 99.0 and changed.now.s[0] != 100.0


@given(st.integers(0, 200), st.integers(1, 12), st.sampled_from([0.004, 0.01, 0.05]), st.sampled_from([2, 3]))
@settings(max_examples=30)
def test_the_shell_repeats_the_steps_and_adds_nothing(seed, n, T, policy) -> None:
    start = PlatoonState(*paper_start(seed, n), x_leader=-2.0)
    platoon = SampledPlatoon.begin(start, V_OLD, WEIGHTS, Sampling(T, policy))
    loop = loop_with(T, policy, V_OLD)
    now, _ = begin(loop, start.x_leader, start.s, start.v)
    for _ in range(40):
        assert plain(platoon.now) == plain(now)
        now, _ = step(loop, now)
        platoon.advance_to(now.period, now.fraction)


@given(st.integers(0, 200), st.integers(2, 9), st.sampled_from([0.01, 0.02]))
@settings(max_examples=15)
def test_verdicts_are_the_oracle_s_lemma_1(seed, n, T) -> None:
    s, v = paper_start(seed, n)
    run = reference.reference_run(s, v, alpha=1.0, r=0.0, p=0.0, hill=False, T=T, duration=30 * T)
    now, verdict = begin(loop_with(T, 2, V_OLD), 0.0, s, v)
    for k, bound in enumerate(run.T_max):
        assert now.T_max == pytest.approx(bound, rel=1e-9)
        assert verdict is (Verdict.CERTIFIED if now.T_max > T else Verdict.NOT_CERTIFIED)
        assert now.violations == sum(one <= T for one in run.T_max[: k + 1]) and (now.period, now.span) == (k, 1.0)
        now, verdict = step(loop_with(T, 2, V_OLD), now)


@pytest.mark.parametrize("policy", [1, 2, 3])
def test_an_instant_at_which_T_is_T_max_is_not_certified(policy: int) -> None:
    s, v = paper_start(8, 5)
    bound = begin(loop_with(), 0.0, s, v)[0].T_max
    for T, verdict in ((bound, Verdict.NOT_CERTIFIED), (float(np.nextafter(bound, 0.0)), Verdict.CERTIFIED)):
        now, found = begin(loop_with(T, policy), 0.0, s, v)
        assert found is verdict and now.violations == (verdict is Verdict.NOT_CERTIFIED)
        assert now.span == (0.5 if policy == 3 and verdict is Verdict.NOT_CERTIFIED else 1.0)


def colliding(policy: int, plant: Any = IDEAL) -> tuple[Loop, Instant, Verdict]:
    """Two vehicles that run into each other within one period of 2 s, and the instant at its end."""
    loop = loop_with(2.0, policy, plant=plant)
    now, _ = begin(loop, 7.0, np.array([9.0]), np.array([20.0, 34.0]))
    return loop, *step(loop, now)


def test_a_spacing_at_L_ends_the_law_and_decides_nothing_anew() -> None:
    loop, now, verdict = colliding(2)
    before, _ = begin(loop, 7.0, np.array([9.0]), np.array([20.0, 34.0]))
    assert verdict is Verdict.OUTSIDE and now.s[0] < CONSTANTS.L and (now.period, now.fraction) == (1, 0.0)
    assert np.array_equal(now.a, before.a) and (now.T_max, now.violations) == (before.T_max, before.violations)
    assert now.cost[0] > 0.0 < now.cost[1]
    error = refusal(loop, now, verdict)
    assert error.key == "left_spacing" and error.values == (2, now.s[0], CONSTANTS.L, 2.0)
    for array in (now.s, now.v):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_a_change_that_puts_a_spacing_at_L_is_outside_and_names_the_vehicle() -> None:
    loop, s, v = loop_with(2.0, 2), np.array([90.0, 95.0]), np.full(3, 30.0)
    now, _ = begin(loop, 7.0, s, v)
    found, verdict = resample(loop, now, (0, 0.5), (1.0, np.array([30.0, CONSTANTS.L]), v))
    assert verdict is Verdict.OUTSIDE and (found.period, found.fraction) == (0, 0.5) and found.x == 1.0
    assert found.cost == after(loop, now, 1.0)[1] and found.cost[1] > 0.0
    assert refusal(loop, found, verdict).values == (3, CONSTANTS.L, CONSTANTS.L, 1.0)
    apart, verdict = resample(loop, now, (0, 0.5), (1.0, s, v))
    assert verdict is not Verdict.OUTSIDE and apart.cost == found.cost


@dataclass(frozen=True)
class Towed:
    """Vehicles that somebody pulls together faster than any could drive."""

    def begin(self, x: Any, s: Any, v: Any) -> Motion:
        return Motion(x, s, v)

    def advance(self, vehicles: Motion, a: Any, tau: Any) -> tuple[Motion, Any]:
        return vehicles._replace(s=vehicles.s - 400.0 * tau), 0.0 * a


@pytest.mark.parametrize("policy", list(Lemma1Policy))
def test_other_vehicles_are_looked_after_even_where_every_period_was_certified(policy: Lemma1Policy) -> None:
    """Lemma 1 speaks of vehicles that do what they are told, shortened periods or not."""
    platoon = SampledPlatoon.begin(
        PlatoonState([12.0], [20.0, 20.0]), BEST_FIXED, sampling=Sampling(0.02, policy), plant=Towed()
    )
    with pytest.raises(ModelError) as caught:
        platoon.advance_to(1, 0.0)
    assert caught.value.key == "left_spacing" and platoon.now.s[0] == 4.0 and platoon.now.violations == 0


def test_the_sentence_of_an_instant_that_is_not_certified_is_its_own() -> None:
    loop = loop_with(0.5, 2)
    now, verdict = begin(loop, 0.0, np.array([9.0, 30.0]), np.array([30.0, 30.0, 30.0]))
    later = now._replace(period=3, fraction=0.5)
    error = refusal(loop, later, verdict)
    assert error.key == "lemma1_spacing" and error.values[:4] == (0.5, now.T_max, 1.75, 2)


def test_periods_are_cut_in_halves_down_to_the_shortest_and_end_at_nominal_instants() -> None:
    near = np.array([np.nextafter(CONSTANTS.L, 9.0)])
    now, verdict = begin(loop_with(1.0, 3), 0.0, near, np.array([30.0, 30.0]))
    assert verdict is Verdict.NOT_CERTIFIED and now.span == SHORTEST and now.ends == (0, SHORTEST)
    cut = now._replace(fraction=0.75, span=0.25)
    assert cut.ends == (1, 0.0) and cut._replace(span=0.125).ends == (0, 0.875)
    calm = begin(loop_with(0.01, 3), 0.0, np.array([12.0]), np.array([30.0, 30.0]))[0]
    late, _ = resample(loop_with(0.01, 3), calm, (0, 0.625), (0.0, calm.s, calm.v))
    assert late.span == 0.375 and late.ends == (1, 0.0)
    later, _ = resample(loop_with(0.01, 3), late, (0, 0.875), (0.0, calm.s, calm.v))
    assert later.span == 0.125 and later.cost == after(loop_with(0.01, 3), late, 0.25 * 0.01)[1]


def test_a_state_is_what_the_loop_says_it_is() -> None:
    s, v = paper_start(1, 3)
    now, _ = begin(loop_with(), 4.0, s, v)
    assert now.x == 4.0 and isinstance(now.x, float) and np.array_equal(now.s, s) and np.array_equal(now.v, v)
    assert (now.period, now.fraction, now.cost, now.memory) == (0, 0.0, (0.0, 0.0), None)
    vehicles, cost = after(loop_with(), now, 0.0)
    assert plain(vehicles) == plain(Motion(4.0 + 0.0 * v[0], s, v)) and cost == (0.0, 0.0)


def test_the_terms_of_J_add_up_over_steps_and_changes() -> None:
    loop, (s, v) = loop_with(0.01, 2), paper_start(2, 5)
    run = reference.reference_run(
        s, v, alpha=1e-3, r=11.0, p=5.5, duration=0.3, constants=reference.Constants(w1=0.3, s_ref=7.0)
    )
    now, _ = begin(loop, 0.0, s, v)
    for acceleration, spacing in zip(run.J_acceleration, run.J_gap, strict=True):
        assert now.cost == pytest.approx((acceleration, spacing), rel=1e-12, abs=1e-15)
        vehicles, cost = after(loop, now, 0.004)
        split, _ = resample(loop, now, (now.period, 0.4), (0.0, vehicles.s, vehicles.v))
        assert split.cost == cost and split.cost[1] > now.cost[1]
        now, _ = step(loop, now)


@pytest.mark.parametrize("policy", list(Lemma1Policy))
def test_the_loop_cuts_periods_under_policy_3_only(policy: Lemma1Policy) -> None:
    assert loop_with(policy=policy).shorten == (policy is Lemma1Policy.SHORTEN)
