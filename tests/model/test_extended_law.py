"""The extended law in the closed loop: the paper's with the defaults; lengths, leaders and the exact period."""

from __future__ import annotations

from collections.abc import Callable
from math import exp
from typing import Any

import numpy as np
import pytest

from psp_model import (
    BEST_FIXED,
    V_OLD,
    Certificate,
    Cooperation,
    DrivenLeader,
    ExtendedLaw,
    Lemma1Policy,
    ModelError,
    OpenPlatoon,
    PlatoonParameters,
    PlatoonState,
    SampledPlatoon,
    Sampling,
    StartDomain,
    brake_margin,
    exact_period,
    simulate,
)
from psp_model.law.cooperation import clearances
from psp_model.law.extended import behind_leader, driven
from psp_model.membership import JoinMargin
from psp_model.sampling.hold import Motion, advance
from psp_model.sampling.lemma1 import of_commanded
from psp_model.sampling.loop import Verdict, redecide, refusal
from psp_model.vehicles.braking import Braking

C = PlatoonParameters()
EXACT = {"certificate": Certificate.EXACT}


def law(**fields: Any) -> Callable[..., ExtendedLaw]:
    return lambda potential, constants: ExtendedLaw(potential, constants, **fields)


def drawn(seed: int, n: int = 7) -> PlatoonState:
    s, v = StartDomain().draw(np.random.default_rng(seed), n, 1)
    return PlatoonState(s[:, 0], v[:, 0])


@pytest.mark.parametrize("policy", list(Lemma1Policy))
@pytest.mark.parametrize("shape", [V_OLD, BEST_FIXED], ids=["V_old", "V_new"])
def test_with_the_defaults_a_run_is_the_paper_s_bit_for_bit(policy: Lemma1Policy, shape: Any) -> None:
    sampling = Sampling(0.01 if policy is Lemma1Policy.ERROR else 0.04, policy)
    for cooperation in (Cooperation(), Cooperation(length=np.full(7, 5.0))):
        one = simulate(drawn(1), shape, sampling=sampling, duration=3.0)
        other = simulate(drawn(1), shape, sampling=sampling, duration=3.0, controller=law(cooperation=cooperation))
        for name in ("x", "s", "v", "a", "T_max", "cost"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
        assert one.violations == other.violations and one.warnings == other.warnings


@pytest.mark.parametrize("seed", range(6))
def test_a_period_that_the_exact_one_certifies_keeps_vehicles_apart(seed: int) -> None:
    """Against a fine grid inside every period held, with lengths, a leader that drives itself, policy 3."""
    rng = np.random.default_rng(seed)
    length = rng.uniform(4, 12, 7)
    start = PlatoonState(length[:-1] + rng.uniform(0.5, 9, 6), rng.uniform(22, 33, 7))
    sampling = Sampling(0.5, Lemma1Policy.SHORTEN, **EXACT)
    leader = DrivenLeader(float(rng.uniform(15, 34)), float(rng.normal(0, 2))) if seed % 2 else None
    cooperation = Cooperation(kappa=0.5, length=length)
    make = law(cooperation=cooperation, leader=leader, T=sampling.T)
    platoon = SampledPlatoon.begin(start, BEST_FIXED, sampling=sampling, controller=make)
    for _ in range(60):
        now = platoon.now
        assert now.T_exact is not None and now.span * sampling.T < now.T_exact
        for tau in np.linspace(0.0, now.span * sampling.T, 21):
            s, v = advance(now.s, now.v, now.a, tau)
            assert (clearances(s, cooperation, C) > 0.0).all()
            assert (v[leader is not None :] >= 0.0).all() and (v <= C.v_max + 1e-12).all()
        platoon.advance_to(*now.ends)


def test_the_exact_period_decides_where_it_is_chosen() -> None:
    start = drawn(3)
    with pytest.raises(ModelError, match="Lemma 1"):
        SampledPlatoon.begin(start, BEST_FIXED, sampling=Sampling(0.3))
    platoon = SampledPlatoon.begin(start, BEST_FIXED, sampling=Sampling(0.3, **EXACT))
    now = platoon.now
    assert now.T_exact == float(exact_period(now.s, now.v, now.a)) == now.bound
    assert now.T_max < 0.3 < now.T_exact and now.violations == 0
    T = float(np.nextafter(now.T_exact, 0.0))
    SampledPlatoon.begin(start, BEST_FIXED, sampling=Sampling(T, **EXACT))
    with pytest.raises(ModelError) as caught:
        SampledPlatoon.begin(start, BEST_FIXED, sampling=Sampling(now.T_exact, **EXACT))
    assert caught.value.key.startswith("exact_")
    counted = SampledPlatoon.begin(start, BEST_FIXED, sampling=Sampling(now.T_exact, Lemma1Policy.WARN, **EXACT))
    assert counted.now.violations == 1


@pytest.mark.parametrize(
    ("s", "v", "length", "certificate", "key", "words"),
    [
        ([5.2, 20.0], [0.0, 30.0, 30.0], None, 2, "exact_spacing", "vehicle 2 would close its spacing s[2] = 5.2 m to"),
        ([8.2, 20.0], [0.0, 30.0, 30.0], [8.0, 5.0, 5.0], 2, "exact_spacing", "s[2] = 8.2 m to 8 m within T"),
        ([8.2, 20.0], [0.0, 30.0, 30.0], [8.0, 5.0, 5.0], 1, "lemma1_length", "the length of the vehicle ahead, 8 m"),
    ],
)
def test_a_violation_names_who_and_what(
    s: list[float], v: list[float], length: Any, certificate: int, key: str, words: str
) -> None:
    cooperation = Cooperation(length=None if length is None else np.array(length))
    make, sampling = law(cooperation=cooperation, T=0.1), Sampling(0.1, certificate=certificate)
    with pytest.raises(ModelError) as caught:
        SampledPlatoon.begin(PlatoonState(s, v), BEST_FIXED, sampling=sampling, controller=make)
    assert caught.value.key == key and words in str(caught.value)


def test_vehicles_that_touch_under_policy_2_are_told_with_their_length() -> None:
    cooperation = Cooperation(length=np.array([9.0, 5.0]))
    sampling = Sampling(0.05, Lemma1Policy.WARN)
    make = law(cooperation=cooperation, leader=DrivenLeader(10.0, -10.0), T=0.05)
    platoon = SampledPlatoon.begin(PlatoonState([9.5], [10.0, 34.0]), BEST_FIXED, sampling=sampling, controller=make)
    with pytest.raises(ModelError, match="has fallen to the length of the vehicle ahead, 9 m"):
        platoon.advance_to(3, 0.0)


def test_closing_up_sets_in_with_its_time_constant() -> None:
    cooperation = Cooperation(closing_speed=0.5)
    start = PlatoonState([60.0, 60.0], [20.0, 20.0, 20.0])
    platoon = SampledPlatoon.begin(start, BEST_FIXED, controller=law(cooperation=cooperation))
    memory: Any = platoon.now.memory
    np.testing.assert_array_equal(memory.closing, 0.0)
    platoon.advance_to(100, 0.0)
    memory = platoon.now.memory
    expected = 0.5 * np.arange(3) * (1.0 - exp(-1.0 / 2.0))
    np.testing.assert_allclose(memory.closing, expected, rtol=1e-9)


def test_closing_up_does_not_depend_on_how_often_it_is_sampled() -> None:
    """Cut periods engage it by the time that passes, not by their number."""
    found = []
    for T in (0.5, 0.005):
        make = law(cooperation=Cooperation(closing_speed=0.5), T=T)
        start = PlatoonState([60.0, 60.0], [20.0, 20.0, 20.0])
        platoon = SampledPlatoon.begin(start, BEST_FIXED, sampling=Sampling(T, 2), controller=make)
        platoon.advance_to(round(2.0 / T), 0.0)
        memory: Any = platoon.now.memory
        found.append(memory.closing)
    np.testing.assert_allclose(found[0], found[1], rtol=1e-12)


def test_to_decide_once_more_changes_nothing() -> None:
    make = law(cooperation=Cooperation(kappa=0.3, closing_speed=0.5), leader=DrivenLeader(29.0, -0.3))
    platoon = SampledPlatoon.begin(drawn(2), BEST_FIXED, sampling=Sampling(0.01, 2), controller=make)
    platoon.advance_to(37, 0.0)
    again, _ = redecide(platoon.loop, platoon.now)
    was: Any = platoon.now
    for left, right in ((again.a, was.a), (again.memory, was.memory)):  # type: ignore[attr-defined]
        np.testing.assert_array_equal(np.hstack(left), np.hstack(right))
    assert (again.T_max, again.span, again.violations) == (was.T_max, was.span, was.violations)


@pytest.mark.parametrize(
    ("v", "speed", "rate"), [(30.0, 30.0, 1.0), (30.0, 29.0, -0.5), (0.0, 0.0, -1.0), (35.0, 35.0, 2.0)]
)
def test_a_driven_leader_goes_where_it_says_within_its_bounds(v: float, speed: float, rate: float) -> None:
    a = float(driven(v, DrivenLeader(speed, rate), 0.1, C))
    np.testing.assert_allclose(v + 0.1 * a, min(max(speed + 0.1 * rate, 0.0), C.v_max), atol=1e-12)


def test_followers_take_on_what_the_leader_does() -> None:
    """At spacings beyond the repulsion all follow exactly, with feed-forward."""
    make = law(leader=DrivenLeader(30.0, -1.0))
    platoon = SampledPlatoon.begin(PlatoonState([40.0, 40.0], [30.0] * 3), BEST_FIXED, controller=make)
    np.testing.assert_allclose(platoon.now.a, -1.0, rtol=1e-12)
    np.testing.assert_array_equal(behind_leader(platoon.now.v), [0.0, 1.0, 1.0])


def test_lengths_on_joining_and_leaving() -> None:
    cooperation = Cooperation(length=np.array([6.0, 7.0, 8.0]))
    start = PlatoonState([40.0, 40.0], [30.0] * 3)
    platoon = SampledPlatoon.begin(start, BEST_FIXED, controller=law(cooperation=cooperation))
    road = OpenPlatoon.begin(platoon, 7, lambda s, v: BEST_FIXED)
    road, refused = road.insert(1, 15.0, 30.0, 0, 0.0, 12.0)
    assert refused is None

    def lengths(of: OpenPlatoon) -> list[float]:
        made: Any = of.platoon.loop.controller
        found: list[float] = np.array(made.cooperation.length).tolist()
        return found

    assert lengths(road) == [6.0, 12.0, 7.0, 8.0]
    np.testing.assert_allclose(road.platoon.now.s, [15.0, 25.0, 40.0])
    road, _ = road.insert(0, 20.0, 30.0, 0, 0.0)
    assert lengths(road) == [5.0, 6.0, 12.0, 7.0, 8.0]
    for gone in (5, 4, 3, 2):
        road, refused = road.remove(gone, 0, 0.0)
        assert refused is None
    made: Any = road.platoon.loop.controller
    assert made.cooperation.length is None  # the one that is left has length L
    _, refused = road.insert(1, 15.0, 30.0, 0, 0.0, -2.0)
    assert refused is not None and "length -2 m" in refused.sentence


@pytest.mark.parametrize("seed", range(4))
def test_the_spacing_offered_has_the_brake_margin(seed: int) -> None:
    rng = np.random.default_rng(seed)
    start = PlatoonState(rng.uniform(20, 40, 3), rng.uniform(25, 32, 4))
    platoon = SampledPlatoon.begin(start, BEST_FIXED, controller=law(), sampling=Sampling(0.05, 2, **EXACT))
    asked = JoinMargin(float(rng.uniform(2, 6)), -6.0)
    road = OpenPlatoon(platoon, 7, lambda s, v: BEST_FIXED, (1, 2, 3, 4), 4, asked)
    place, speed, length = int(rng.integers(0, 5)), float(rng.uniform(25, 33)), float(rng.uniform(4, 8))
    with_it, refused = road.insert(place, 7.0 + length, speed, 0, 0.0, length)
    if refused is not None and np.isfinite(refused.spacing):
        with_it, refused = road.insert(place, refused.spacing, speed, 0, 0.0, length)
        assert refused is None
    if refused is None:
        now, made = with_it.platoon.now, with_it.platoon.loop.controller
        room = clearances(now.s, made.cooperation, C)  # type: ignore[attr-defined]
        assert brake_margin(room, Braking(now.v, now.a, 0.0, 0.0, -6.0)) >= asked.brake_margin


def with_leader(start: PlatoonState, leader: DrivenLeader | None, T: float, **fields: Any) -> SampledPlatoon:
    """A platoon that is not certified, or is, by the exact period."""
    make = law(leader=leader, T=T, **fields)
    return SampledPlatoon.begin(
        start, BEST_FIXED, sampling=Sampling(T, Lemma1Policy.WARN, **EXACT), controller=make, warn=WARNED.append
    )


WARNED: list[str] = []


def test_a_leader_who_drives_himself_may_leave_the_speed_limits_but_not_touch() -> None:
    """His speed's bound does not count for the exact period, his acceleration does for the spacing behind him."""
    start = PlatoonState([20.0, 20.0], [34.0, 30.0, 30.0])
    now = with_leader(start, DrivenLeader(34.0, 20.0), 0.01).now
    assert now.a[0] == pytest.approx(20.0) and (34.0 - C.v_max) / -20.0 < 0.1 < now.T_exact
    alone = float(exact_period([1e9], start.v[1:], now.a[1:]))
    braking = with_leader(PlatoonState([6.0, 20.0], [20.0, 30.0, 30.0]), DrivenLeader(20.0, -5.0), 0.01).now
    a = braking.a
    assert now.T_exact == now.T_max == alone
    relative = np.roots([0.5 * (a[0] - a[1]), -10.0, 1.0])
    assert braking.T_exact == pytest.approx(float(relative[relative > 0].real.min()), rel=1e-9)


def test_a_leader_who_reaches_v_max_at_the_end_of_the_period_costs_no_certificate() -> None:
    now = with_leader(PlatoonState([40.0, 40.0], [34.9, 30.0, 30.0]), DrivenLeader(34.9, 10.0), 0.2).now
    assert (C.v_max - 34.9) / now.a[0] <= 0.2 + 1e-9 and now.violations == 0 and now.T_exact > 0.2


@pytest.mark.parametrize("certificate", list(Certificate))
def test_the_nearest_vehicle_is_the_one_with_the_least_clearance(certificate: Certificate) -> None:
    """Not the one with the least spacing."""
    length = np.array([12.0, 5.0, 5.0])
    make, start = law(cooperation=Cooperation(length=length), T=0.2), PlatoonState([12.3, 9.0], [20.0, 30.0, 30.0])
    warned: list[str] = []
    sampling = Sampling(0.2, Lemma1Policy.WARN, certificate=certificate)
    now = SampledPlatoon.begin(start, BEST_FIXED, sampling=sampling, controller=make, warn=warned.append).now
    with pytest.raises(ModelError) as caught:
        sampling = Sampling(0.2, Lemma1Policy.ERROR, certificate=certificate)
        SampledPlatoon.begin(start, BEST_FIXED, sampling=sampling, controller=make)
    assert str(caught.value) == warned[0] and "s[2] = 12.3 m" in warned[0] and "12 m" in warned[0]
    assert 0.0 < now.bound < 0.2 and caught.value.values[1] == now.bound


def test_a_decision_taken_once_more_counts_once_and_forgets_nothing() -> None:
    start = PlatoonState([30.0, 30.0], [25.0, 25.0, 25.0])
    fields = {"cooperation": Cooperation(closing_speed=0.6)}
    platoon = with_leader(start, DrivenLeader(25.0, 0.0), 0.05, **fields)
    platoon.advance_to(40, 0.0)
    before = platoon.now
    again, _ = redecide(platoon.loop, before)
    assert again.memory.closing[1] == before.memory.closing[1] > 0.0  # type: ignore[attr-defined]
    assert again.cost == before.cost and again.violations == before.violations
    np.testing.assert_array_equal(again.a, before.a)
    tight = with_leader(PlatoonState([5.1, 30.0], [20.0, 30.0, 25.0]), DrivenLeader(20.0, 0.0), 0.1)
    assert tight.now.violations == 1
    assert redecide(tight.loop, tight.now)[0].violations == 1  # taken back, and counted anew
    exactly = tight.now._replace(T_exact=0.1)
    assert redecide(tight.loop, exactly)[0].violations == 1  # T is certified only below the bound


def test_a_change_between_instants_goes_on_with_what_was_remembered() -> None:
    """Closing up has been engaged for the time passed since, no more and no less."""
    start = PlatoonState([40.0, 40.0], [25.0, 25.0, 25.0])
    platoon = with_leader(start, None, 0.05, cooperation=Cooperation(closing_speed=0.6))
    platoon.advance_to(40, 0.0)
    before, seen = platoon.now, platoon.observe(40, 0.5)
    changed = platoon.take_over(40, 0.5, float(seen.x[0]), seen.s, seen.v, BEST_FIXED, memory=before.memory).now
    full = 0.6 * np.array([0.0, 1.0, 2.0])
    closing = before.memory.closing  # type: ignore[attr-defined]
    expected = closing + (1.0 - exp(-0.025 / 2.0)) * (full - closing)
    np.testing.assert_allclose(changed.memory.closing, expected, rtol=1e-9)  # type: ignore[attr-defined]


def test_who_has_touched_is_told_by_clearance() -> None:
    """Not by spacing: those behind a truck have the larger one."""
    make = law(cooperation=Cooperation(length=np.array([12.0, 5.0, 5.0])), T=0.01)
    platoon = SampledPlatoon.begin(PlatoonState([20.0, 7.0], [20.0, 20.0, 20.0]), BEST_FIXED, controller=make)
    touching = platoon.now._replace(vehicles=Motion(0.0, np.array([11.5, 7.0]), platoon.now.v))
    error = refusal(platoon.loop, touching, Verdict.OUTSIDE)
    assert error.key == "left_length" and error.values[:3] == (2, 11.5, 12.0)


def test_between_nominal_instants_a_driven_leader_holds_his_acceleration() -> None:
    """Periods are cut for the others' sake; at the next nominal instant he is where his profile says."""
    leader = DrivenLeader(30.0, 1.0)
    start = PlatoonState([5.3, 30.0], [29.0, 20.0, 20.0])
    platoon = SampledPlatoon.begin(
        start, BEST_FIXED, sampling=Sampling(0.1, Lemma1Policy.SHORTEN), controller=law(leader=leader, T=0.1)
    )
    first = platoon.now
    platoon.advance_to(0, 0.9)
    cut = platoon.now
    assert cut.fraction > 0.0 and cut.a[0] == first.a[0] == pytest.approx(11.0)
    platoon.advance_to(1, 0.0)
    assert platoon.now.v[0] == pytest.approx(30.1) and platoon.now.a[0] == pytest.approx(0.0)


def test_bounds_of_speeds_count_for_those_who_are_commanded() -> None:
    of_speeds = np.array([1.0, 2.0, 3.0])
    np.testing.assert_array_equal(of_commanded(of_speeds, np.array([0.0, 0.5, 1.0])), [np.inf, np.inf, 3.0])
    assert of_commanded(of_speeds, None) is of_speeds
    casadi = pytest.importorskip("casadi")
    bounds, flags = casadi.SX.sym("b", 2), casadi.SX.sym("f", 2)
    found = casadi.Function("f", [bounds, flags], [of_commanded(bounds, flags)])([1.0, 2.0], [0.0, 1.0])
    assert found.full().ravel().tolist() == [np.inf, 2.0]
    jax = pytest.importorskip("jax")
    np.testing.assert_array_equal(jax.jit(of_commanded)(of_speeds, np.array([0.0, 0.5, 1.0])), [np.inf, np.inf, 3.0])
