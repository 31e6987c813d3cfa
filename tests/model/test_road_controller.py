"""The controller of measured vehicles on a road: prediction, others who drive, lengths, limits, bounds."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from measured_late import T, changed, measured_before
from psp_model import (
    BEST_FIXED,
    BadMeasurement,
    Certificate,
    ControllerSettings,
    Lemma1Policy,
    Measurement,
    ModelError,
    Sampling,
    feedback,
)
from psp_model.controller import SampledController, followed_of, is_certified, margin_of
from psp_model.controller.members import members_of, odd_one_out
from psp_model.controller.settings import MOST_COMMANDS
from psp_model.law.cooperation import ALL_AUTOMATED, Cooperation, cooperative_command
from psp_model.law.feedback import gain
from psp_model.parameters import Actuation
from psp_model.sampling.hold import IDEAL, Motion
from psp_model.sampling.uncertain import Errors
from psp_model.selection.selectors import ParameterSource, Request
from psp_model.vehicles.actuation import Foreign
from psp_model.vehicles.braking import MOST, Braking, brake_margin
from psp_model.vehicles.delayed import DelayedVehicles
from strategies import CONSTANTS, paper_start

N = 8
FIXED = Request(source=ParameterSource.FIXED, fixed=BEST_FIXED)
NO_LIMITS = {"a_min": -1000.0, "a_max": 1000.0}
VISCOUS = Cooperation(kappa=1.0)


def made(**others: Any) -> SampledController:
    sampling = others.pop("sampling", Sampling(T, Lemma1Policy.WARN))
    return SampledController.begin(ControllerSettings(N, sampling=sampling, request=FIXED, **others))


def padded(s: Any, v: Any, **others: Any) -> Measurement:
    """Measured vehicles, and places of the controller behind them that hold nothing."""
    n = len(v)
    return Measurement(np.pad(s, (0, N - n)), np.pad(v, (0, N - n)), n, **others)


@settings(max_examples=25, deadline=None)
@given(
    st.integers(0, 10**6),
    st.integers(3, 7),
    st.floats(0.0, 0.25),
    st.floats(0.0, 0.15),
    st.sampled_from(["joins", "leaves", "stays"]),
)
def test_a_pure_dead_time_only_begins_later(seed: int, n: int, delay: float, age: float, change: str) -> None:
    """From a dead time after the start, or after a change on the way, the motion is the delay-free closed loop."""
    s, v = paper_start(seed, n)
    s = s + 3.0 + delay * np.maximum(v[1:] - v[:-1], 0.0)
    place = max(seed % n, change == "joins")
    if change == "joins":  # room for the one that joins
        s[place - 1] += 6.0
    controller = made(cooperation=VISCOUS, actuation=Actuation(delay, **NO_LIMITS), max_age=0.5)
    plant, past, periods, at = DelayedVehicles(Actuation(delay)), [], 60, 30 if change != "stays" else 0
    vehicles = plant.begin(0.0, s, v)
    for k in range(periods):
        past.append((vehicles, None))
        if k == at and change != "stays":
            members: list[int | None] = [one for one in range(n) if change == "joins" or one != place]
            if change == "joins":
                members.insert(place, None)
            past = changed(past, members, 7.0, 30.0)
            vehicles = past[-1][0]
        seen = measured_before(plant, past, age)
        controller.sample(k * T, padded(seen.s, seen.v, age=age))
        a = controller.now.a[: vehicles.v.size]
        past[-1] = (vehicles, a)
        if k == at:
            begins = plant.advance(vehicles, a, delay)[0]
        vehicles = plant.advance(vehicles, a, T)[0]
    expected, now = [], Motion(0.0, begins.s, begins.v)
    for _ in range(periods):
        expected.append(now)
        now = IDEAL.advance(now, viscous(now), T)[0]
    for k in range(at + int(delay // T) + 1, periods):
        since = (k - at) * T - delay
        number = int((since + 1e-12) // T)
        truth = IDEAL.advance(expected[number], viscous(expected[number]), since - number * T)[0]
        np.testing.assert_allclose(past[k][0].s, truth.s, atol=1e-9)
        np.testing.assert_allclose(past[k][0].v, truth.v, atol=1e-9)


def viscous(now: Motion) -> Any:
    return cooperative_command(now.s, now.v, BEST_FIXED, CONSTANTS, VISCOUS, ALL_AUTOMATED)


def test_what_is_measured_without_delay_is_the_paper_s_law_bit_for_bit_where_it_is_predicted_too() -> None:
    s, v = paper_start(3, N)
    plain, predicting = made(), made(max_age=0.4)
    assert predicting.settings.predicts and not plain.settings.predicts
    for k in range(5):
        for controller in (plain, predicting):
            controller.sample(k * T, Measurement(s, v, N))
            np.testing.assert_array_equal(controller.now.a, feedback(s, v, BEST_FIXED, CONSTANTS))


def test_the_predicted_state_is_that_at_which_the_command_takes_effect() -> None:
    s, v = paper_start(4, N)
    delay, age = 0.123, 0.045
    controller = made(actuation=Actuation(delay, 0.0, -8.0, 4.0), max_age=0.2)
    plant, past = DelayedVehicles(Actuation(delay, 0.0, -8.0, 4.0)), []
    vehicles = plant.begin(0.0, s + 2.0, v)
    for k in range(40):
        past.append((vehicles, None))
        seen = measured_before(plant, past, age)
        controller.sample(k * T, padded(seen.s, seen.v, age=age))
        basis, a = controller.now.basis, controller.now.a
        assert basis is not None
        past[-1] = (vehicles, a)
        then = plant.advance(vehicles, a, delay)[0]
        np.testing.assert_allclose(basis.s_predicted, then.s, atol=1e-9)
        np.testing.assert_allclose(basis.v_predicted, then.v, atol=1e-9)
        vehicles = plant.advance(vehicles, a, T)[0]


@pytest.mark.parametrize("following", [1, 2])
def test_who_is_followed(following: int) -> None:
    s, v = paper_start(5, N)
    automated = np.array([0, 1, 1, 0, 1, 1, 1, 1.0])
    controller = made(cooperation=Cooperation(following=following))
    controller.sample(0.0, Measurement(s, v, N, automated=automated, a_measured=np.zeros(N)))
    expected = [0, 1, 1, 0, 4, 4, 4, 4] if following == 1 else [0, 1, 2, 0, 4, 5, 6, 7]
    np.testing.assert_array_equal(followed_of(controller.settings, controller.now), expected)
    assert controller.now.a[0] == controller.now.a[3] == 0.0
    for i in np.flatnonzero(automated):  # moving the desired speed by the vehicle's own makes the friction vanish
        alone = v.copy()
        alone[i] = v[expected[i] - 1]
        controller.sample(0.0, Measurement(s, alone, N, automated=automated, a_measured=np.zeros(N)))
        same = controller.now.a[i]
        controller.sample(0.0, Measurement(s, alone, N, v_desired=float(v[expected[i] - 1])))
        assert same == pytest.approx(controller.now.a[i], abs=1e-12)


def test_feed_forward_takes_what_is_communicated_or_else_an_estimate() -> None:
    s, v = np.full(N - 1, 12.0), np.full(N, 20.0)
    automated, known = np.r_[0.0, np.ones(N - 1)], np.ones(N)
    told, estimating = made(), made()
    b = -1.5  # [m/s2]
    for k in range(300):
        v[0] = 20.0 + b * k * T
        told.sample(k * T, Measurement(s, v, N, automated=automated, a_measured=np.full(N, b), a_known=known))
        estimating.sample(
            k * T, Measurement(s, v, N, automated=automated, a_measured=np.full(N, 7.0), a_known=0 * known)
        )
    np.testing.assert_allclose(estimating.now.a, told.now.a, atol=1e-5)
    without = made(cooperation=Cooperation(feedforward=0.0))
    without.sample(0.0, Measurement(s, v, N, automated=automated, a_measured=np.full(N, b)))
    np.testing.assert_allclose(told.now.a[1:] - without.now.a[1:], b, atol=1e-9)


def test_only_the_clearance_counts_whatever_the_lengths() -> None:
    s, v = paper_start(6, N)
    length = np.array([16.5, 5.0, 4.2, 12.0, 5.0, 3.0, 5.0, 16.5])
    cars, mixed = made(), made(cooperation=Cooperation(length=length))
    cars.sample(0.0, Measurement(s, v, N))
    mixed.sample(0.0, Measurement(s + length[:-1] - CONSTANTS.L, v, N))
    np.testing.assert_allclose(mixed.now.a, cars.now.a, atol=1e-9)
    assert mixed.now.T_max == pytest.approx(cars.now.T_max, rel=1e-9)
    assert mixed.now.T_exact == pytest.approx(cars.now.T_exact, rel=1e-9)
    assert margin_of(mixed.settings, mixed.now) == pytest.approx(margin_of(cars.settings, cars.now), abs=1e-9)
    with pytest.raises(ModelError, match=r"s\[2\] = 16 m does not exceed the length of vehicle 1, 16.5 m"):
        mixed.sample(0.0, Measurement(np.r_[16.0, s[1:] + 12], v, N))


def test_limits_are_those_of_each_vehicle() -> None:
    s, v = paper_start(7, N)
    free = made()
    free.sample(0.0, Measurement(s, v, N))
    least, most = -np.linspace(0.1, 3.0, N), np.linspace(3.0, 0.1, N)
    controller = made(actuation=Actuation(0.0, 0.0, least, most), a_safe=-0.05)
    controller.sample(0.0, Measurement(s, v, N))
    np.testing.assert_array_equal(controller.now.a, np.clip(free.now.a, least, most))
    np.testing.assert_array_equal(controller.now.saturated, controller.now.a != free.now.a)


def fine_period(s: Any, v: Any, a: Any, longest: float) -> float:
    """The exact period by looking: the first time on a fine grid at which the state space is left."""
    t = np.arange(0.0, longest, 1e-4)[:, None]
    moved, then = v * t + 0.5 * a * t * t, v + a * t
    touch = (s + moved[:, :-1] - moved[:, 1:] <= CONSTANTS.L).any(axis=1)
    left = touch | (then < 0).any(axis=1) | (then > CONSTANTS.v_max).any(axis=1)
    return float(t[np.argmax(left), 0]) if left.any() else longest


@pytest.mark.parametrize("seed", range(6))
def test_the_exact_period_is_the_time_until_the_state_space_is_left(seed: int) -> None:
    rng = np.random.default_rng(seed)
    s, v = rng.uniform(5.2, 9.0, N - 1), rng.uniform(1.0, 34.5, N)
    controller = made(actuation=Actuation(0.0, 0.0, -6.0, 3.0))
    controller.sample(0.0, Measurement(s, v, N))
    now = controller.now
    assert (now.T_exact >= now.T_max and now.T_exact == pytest.approx(fine_period(s, v, now.a, 3.0), abs=2e-4)) or (
        now.T_exact > 3.0
    )


def test_the_certificate_decides_what_counts_as_certified() -> None:
    s, v = np.full(N - 1, 6.0), np.full(N, 30.0)  # T_max = 1 / 35 s
    for certificate, certified in ((Certificate.LEMMA1, False), (Certificate.EXACT, True)):
        controller = made(sampling=Sampling(0.1, Lemma1Policy.WARN, certificate=certificate))
        controller.sample(0.0, Measurement(s, v, N))
        assert controller.now.T_max == pytest.approx(1 / 35) and controller.now.T_exact > 0.1
        assert is_certified(controller.settings, controller.now) is certified
        assert controller.now.violations == (not certified)
    closing = Measurement(np.full(N - 1, 5.2), np.r_[1.0, np.full(N - 1, 30.0)], N)
    controller = made(sampling=Sampling(0.1, Lemma1Policy.ERROR, certificate=Certificate.EXACT))
    with pytest.raises(ModelError, match=r"T = 0.1 s is not below T_exact = 0.00\d+ s at t = 2 s, after which"):
        controller.sample(2.0, closing)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.0, 0.5), st.floats(0.0, 0.5))
def test_bounds_on_errors_lower_both_periods_to_those_of_the_worst_case(seed: int, e_s: float, e_v: float) -> None:
    s, v = paper_start(seed, N)
    exact, uncertain = made(), made(errors=Errors(e_s, e_v))
    for controller in (exact, uncertain):
        controller.sample(0.0, Measurement(s, v, N))
    a, rng = exact.now.a, np.random.default_rng(seed)
    np.testing.assert_array_equal(uncertain.now.a, a)
    looked = min(uncertain.now.T_exact + 0.01, 3.0)
    for _ in range(20):  # nothing inside the bounds is worse than what is said
        s_true, v_true = s + rng.uniform(-e_s, e_s, s.shape), v + rng.uniform(-e_v, e_v, v.shape)
        if (v_true < 0).any() or (v_true > CONSTANTS.v_max).any() or (s_true <= CONSTANTS.L).any():
            continue
        found = fine_period(s_true, v_true, a, looked)
        assert found == looked or uncertain.now.T_exact <= found + 2e-4
    assert uncertain.now.T_max <= exact.now.T_max and uncertain.now.T_exact <= exact.now.T_exact


def test_the_brake_margin_is_that_of_who_drives_himself_or_of_the_leader() -> None:
    s, v = np.array([14.0, 11.0, 12.0]), np.array([25.0, 26.0, 24.5, 25.0])
    controller = made(actuation=Actuation(0.0, 0.0, -6.0, 3.0))
    assert margin_of(controller.settings, controller.now) == MOST  # nothing is known yet
    automated = np.array([1.0, 1.0, 0.0, 1.0])
    for flags in (None, automated):
        told = None if flags is None else np.pad(flags, (0, N - 4), constant_values=1.0)
        controller.sample(0.0, padded(s, v, automated=told))
        expected = brake_margin(s - CONSTANTS.L, Braking(v, controller.now.a[:4], 0.0, 0.0, -6.0), flags)
        assert margin_of(controller.settings, controller.now) == pytest.approx(float(expected), abs=1e-9)
    controller.sample(0.0, padded([], [20.0]))
    assert margin_of(controller.settings, controller.now) == MOST


def test_with_the_fail_safe_command_nothing_is_certified_and_it_is_on_its_way_too() -> None:
    s, v = paper_start(8, N)
    actuation = Actuation(0.05, 0.0, -8.0, 4.0)
    controller = made(actuation=actuation, bad_input=BadMeasurement.SAFE_ACTION, a_safe=-3.0, max_age=1.0)
    plant = DelayedVehicles(actuation)
    automated = np.r_[0.0, np.ones(N - 1)]
    vehicles = plant.begin(0.0, s + 5.0, v)
    for k in range(30):
        bad = 10 <= k < 14
        measured = np.where(bad, np.nan, vehicles.s)
        controller.sample(k * T, Measurement(measured, vehicles.v, N, automated=automated, a_measured=np.zeros(N)))
        now = controller.now
        assert now.in_order is not bad
        if bad:
            assert now.T_max == now.T_exact == margin_of(controller.settings, now) == 0.0
            np.testing.assert_array_equal(now.a, np.r_[0.0, np.full(N - 1, -3.0)])
        vehicles = plant.advance(vehicles, now.a, T, Foreign(automated, np.zeros(N)))[0]
        if not bad:
            assert now.basis is not None
            then = plant.advance(vehicles, now.a, 0.04, Foreign(automated, np.zeros(N)))[0]
            np.testing.assert_allclose(now.basis.v_predicted, then.v, atol=1e-9)
    assert controller.now.faults == 4


def test_closing_up_sets_in_smoothly_and_ends() -> None:
    s, v = np.full(N - 1, 30.0), np.full(N, 25.0)
    controller = made(cooperation=Cooperation(closing_speed=0.6))
    speeds = []
    for k in range(1500):
        controller.sample(k * T, Measurement(s, v, N, v_desired=25.0))
        speeds.append(controller.now.a[-1])
    assert abs(speeds[0]) < 1e-9 and 0 < speeds[100] < speeds[1499] and np.abs(np.diff(speeds)).max() < 0.02
    faster = 0.6 * (N - 1)  # the last vehicle closes all spacings
    k = gain(np.zeros(1), replace(CONSTANTS, v_star=25.0 + faster))[0]
    assert speeds[1499] == pytest.approx(k * faster, rel=1e-3)


@settings(max_examples=200, deadline=None)
@given(st.integers(0, 10**6), st.integers(2, N), st.booleans())
def test_who_has_joined_or_left_is_told_from_spacings_and_speeds(seed: int, n: int, joins: bool) -> None:
    rng = np.random.default_rng(seed)
    x, v, place = -np.cumsum(rng.uniform(8.0, 12.0, n)), rng.uniform(27.0, 33.0, n), int(rng.integers(0, n))
    x_left, v_left = np.delete(x, place), np.delete(v, place)
    s, s_left = x[:-1] - x[1:], x_left[:-1] - x_left[1:]
    x_left, v_left = x_left + v_left * T, v_left + rng.uniform(-0.05, 0.05, n - 1)  # a period later
    assert odd_one_out(s, v, s_left, v_left) == place
    basis = made().now.basis
    assert basis is None and members_of(None, n, s_left, v_left) == list(range(n - 1))
    controller = made()
    first, then = ((s_left, v_left), (s, v)) if joins else ((s, v), (s_left, v_left))
    controller.sample(0.0, padded(*first))
    found = members_of(controller.now.basis, len(first[1]), *then)
    others = [one for one in range(n) if one != place]
    assert found == ([None if i == place else others.index(i) for i in range(n)] if joins else others)


WRONG = [
    ({"automated": np.r_[np.nan, np.ones(N - 1)]}, r"automated\[1\] must be a finite number"),
    ({"automated": np.zeros(N), "a_measured": np.full(N, np.inf)}, r"a_measured\[1\] must be a finite number"),
    ({"automated": np.zeros(N), "a_measured": np.zeros(N), "a_known": np.full(N, np.nan)}, r"a_known\[1\] must be"),
    ({"a_desired": np.nan}, "a_desired must be a finite number"),
    ({"age": 0.3}, "the inputs are 0.3 s old, more than max_age"),
]


@pytest.mark.parametrize(("change", "sentence"), WRONG)
def test_what_is_not_in_order_is_named(change: dict[str, Any], sentence: str) -> None:
    s, v = paper_start(9, N)
    with pytest.raises(ModelError, match=sentence):
        made(max_age=0.2).sample(0.0, Measurement(s, v, N, **change))


def test_inputs_that_nobody_looks_at_may_be_anything() -> None:
    s, v = paper_start(10, N)
    controller, nothing = made(), np.full(N, np.nan)
    controller.sample(0.0, Measurement(s, v, N, automated=np.ones(N), a_measured=nothing, a_known=nothing))
    first = np.r_[0.0, np.ones(N - 1)]
    told = np.r_[0.5, nothing[1:]]
    controller.sample(0.0, Measurement(s, v, N, automated=first, a_measured=told, a_known=np.ones(N)))
    assert np.isfinite(controller.now.a).all()


UNFIT = [
    (
        {"actuation": Actuation(20.0, 0.0, **NO_LIMITS)},
        f"actuation_delay = 20 s must not exceed {MOST_COMMANDS - 2} periods of T = 0.01 s",
    ),
    ({"actuation": Actuation(0.0, -0.1, **NO_LIMITS)}, r"actuator_lag\[1\] = -0.1 s must not be negative"),
    (
        {"actuation": Actuation(0.0, 0.0, np.array([-1.0] * 7 + [0.5]), 4.0), "a_safe": -1.0},
        r"a_min\[8\] = 0.5 m/s2 must be",
    ),
    ({"actuation": Actuation(0.0, 0.0, -1.0, 4.0)}, r"a_safe = -2 m/s2 must not be below a_min\[1\] = -1 m/s2"),
    ({"actuation": Actuation(0.0, 0.0, -np.inf, 4.0)}, r"a_min\[1\] must be a finite number"),
    ({"errors": Errors(-0.1, 0.0)}, "error_s = -0.1 m must not be negative"),
    ({"cooperation": Cooperation(kappa=1.0, kappa_reach=4.0)}, "kappa_reach = 4 m must exceed L = 5 m"),
    ({"cooperation": Cooperation(length=np.r_[-1.0, np.ones(7)])}, r"length\[1\] = -1 m must be positive"),
]


@pytest.mark.parametrize(("change", "sentence"), UNFIT)
def test_settings_that_make_no_sense_are_named(change: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ModelError, match=sentence):
        made(**change)
