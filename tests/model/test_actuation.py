"""Vehicles with dead time, lag, limits and a standstill: exact between commands."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from psp_model import ModelError, validate
from psp_model.parameters import Actuation
from psp_model.vehicles.actuation import Actuators, at_rest, commanded, drive, settle
from psp_model.vehicles.delayed import DelayedVehicles
from psp_model.vehicles.ride import ride


def fine(v: Any, a: Any, command: Any, lag: Any, span: float, steps: int = 20_000) -> tuple[Any, Any]:
    """The same by the trapezoidal rule."""
    dt, moved = span / steps, 0.0 * v
    a = np.where(lag > 0, a, command)
    kept = np.where(lag > 0, np.exp(-dt / np.where(lag > 0, lag, 1.0)), 0.0)
    for _ in range(steps):
        following = command + (a - command) * kept
        then = np.maximum(v + 0.5 * dt * (a + following), 0.0)
        v, moved, a = then, moved + 0.5 * dt * (v + then), following
    return v, moved


@pytest.mark.parametrize("span", [0.01, 0.4, 2.0])
def test_a_ride_is_what_small_steps_give(span: float) -> None:
    rng = np.random.default_rng(0)
    v, a, command = rng.uniform(0, 3, 400), rng.normal(0, 3, 400), rng.normal(0, 3, 400)
    v[80:160] *= 0.01
    v[:80], lag = 0.0, rng.choice([0.0, 0.05, 0.3, 1.0], 400)
    found, moved, after = ride(v, a, command, lag, span)
    expected = fine(v, a, command, lag, span)
    np.testing.assert_allclose(found, expected[0], atol=2e-7 * span)
    np.testing.assert_allclose(moved, expected[1], atol=2e-7 * span)
    decayed = np.where(lag > 0, np.exp(-span / np.where(lag > 0, lag, 1.0)), 0.0)
    np.testing.assert_allclose(after, command + (a - command) * decayed, atol=1e-12)
    assert (found >= 0.0).all() and (moved >= 0.0).all()
    assert ((v > 0.0) & (found == 0.0)).any() and (found > v).any()


def test_a_vehicle_that_brakes_stands_and_drives_off_again() -> None:
    """lag 0.5 s, from 0.3 m/s with -4 m/s2, told 4 m/s2: stops, and drives once the actuator turns at 0.347 s."""
    v, a, command = np.array([0.3]), np.array([-4.0]), np.array([4.0])
    assert ride(v, a, command, 0.5, 0.34)[0] == 0.0
    after, _, _ = ride(v, a, command, 0.5, 0.5 * np.log(2.0) + 0.2)
    assert after[0] == pytest.approx(4.0 * (0.2 - 0.5 * (1.0 - np.exp(-0.4))), rel=1e-12)


@given(st.integers(0, 10**6), st.floats(0, 0.3), st.floats(0, 1), st.sampled_from([0.0, 0.2]))
def test_a_ride_in_pieces_is_the_same_ride(seed: int, delay: float, share: float, lag: float) -> None:
    rng = np.random.default_rng(seed)
    plant, T = DelayedVehicles(Actuation(delay, lag, -5.0, 3.0)), 0.07
    once = plant.begin(1.0, rng.uniform(6, 20, 3), rng.uniform(0, 2, 4))
    pieces = once
    for _ in range(8):
        a = rng.normal(0, 6, 4)
        once, _ = plant.advance(once, a, T)
        pieces, _ = plant.advance(pieces, a, share * T)
        pieces, _ = plant.advance(pieces, a, (1 - share) * T)
    for name in ("x", "s", "v"):
        np.testing.assert_allclose(getattr(pieces, name), getattr(once, name), atol=1e-11)


def test_commands_take_effect_after_the_dead_time_and_within_limits() -> None:
    plant = DelayedVehicles(Actuation(0.25, 0.0, np.array([-8.0, -4.0]), np.array([2.0, 2.0])))
    now = plant.begin(0.0, np.array([20.0]), np.array([30.0, 30.0]))
    a = np.array([9.0, -9.0])
    now, mean = plant.advance(now, a, 0.25)
    assert now.v.tolist() == [30.0, 30.0] and mean.tolist() == [0.0, 0.0]
    now, mean = plant.advance(now, a, 0.5)
    assert now.v == pytest.approx([31.0, 28.0]) and mean == pytest.approx([2.0, -4.0])
    assert len(now.actuators.queue) == 0


def test_only_the_actuators() -> None:
    """`settle` is `drive` without a road."""
    actuation = Actuation(0.2, np.array([0.0, 0.1, 0.5]), -3.0, 3.0)
    actuators = at_rest(np.zeros(3))
    for k in range(4):
        actuators = commanded(actuators, np.array([1.0, -9.0, 2.0]) * (k + 1), actuation, -0.1 * k)
    _, _, driven = drive(np.full(3, 40.0), actuators, actuation, 0.45)
    settled = settle(actuators, actuation, 0.45)
    assert isinstance(settled, Actuators)
    np.testing.assert_allclose(settled.a, driven.a)
    np.testing.assert_allclose(settled.command, driven.command)
    assert [due for due, _ in settled.queue] == [due for due, _ in driven.queue]


def test_casadi_gives_the_same() -> None:
    casadi = pytest.importorskip("casadi")
    rng = np.random.default_rng(1)
    numbers = [rng.uniform(0, 2, 30), rng.normal(0, 3, 30), rng.normal(0, 3, 30), rng.choice([0.0, 0.2, 0.7], 30)]
    symbols = [casadi.SX.sym(name, 30) for name in "vacl"]
    function = casadi.Function("ride", symbols, [*ride(*symbols, 0.8)])
    for found, expected in zip(function(*numbers), ride(*numbers, 0.8), strict=True):
        np.testing.assert_allclose(found.full()[:, 0], expected, atol=1e-9)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"actuation_delay": -0.1}, "actuation_delay = -0.1 s must not be negative"),
        ({"actuation_delay": float("inf")}, "actuation_delay must be a finite number"),
        ({"actuator_lag": np.array([0.1, -0.2])}, r"actuator_lag\[2\] = -0.2 s must not be negative"),
        ({"a_min": 1.0}, r"a_min\[1\] = 1 m/s2 must be negative"),
        ({"a_max": np.array([1.0, 0.0])}, r"a_max\[2\] = 0 m/s2 positive"),
    ],
)
def test_what_makes_no_sense_is_refused(wrong: dict[str, Any], said: str) -> None:
    with pytest.raises(ModelError, match=said):
        validate(Actuation(**wrong))


def test_what_makes_sense_is_not() -> None:
    validate(Actuation())
    validate(Actuation(0.2, np.array([0.1, 0.0]), -8.0, np.array([2.0, 4.0])))
