"""`brake_margin` against a search with fine steps of time and of deceleration."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from psp_model.vehicles import braking
from psp_model.vehicles.braking import MOST, Braking, brake_margin, hardest

NEAR = 0.05  # [m/s2]


def touches(b: Any, clearance: Any, vehicles: Braking, automated: Any, dt: float = 0.002) -> Any:
    """Whether an automated vehicle behind one that brakes touches the one ahead, by small steps; arrays of platoons."""
    v, a, dead_time, lag, a_min = vehicles
    brakes = automated < 0.5
    brakes[0] |= ~brakes.any(axis=0)
    behind = np.cumsum(brakes[:-1], axis=0) > 0
    keeps = np.where(lag > 0, np.exp(-dt / np.where(lag > 0, lag, 1.0)), 0.0)
    apart, touched = clearance.copy(), np.zeros(v.shape[1], dtype=bool)
    acceleration = a
    for k in range(int(60.0 / dt)):
        following = a if k * dt < dead_time - 1e-09 else a_min + (acceleration - a_min) * keeps
        mean = np.where(brakes, -b, 0.5 * (acceleration + following))
        if k * dt >= dead_time - 1e-9:
            mean = np.where((lag == 0) & ~brakes, a_min, mean)
        then = np.maximum(v + dt * mean, 0.0)
        if k * dt < dead_time - 1e-9:  # a vehicle that stops in the dead time stands
            a = following = np.where(then > 0.0, following, np.maximum(following, 0.0))
        moved = 0.5 * dt * (v + then)
        apart, v, acceleration = apart + moved[:-1] - moved[1:], then, following
        touched |= ((apart <= 0.0) & behind & ~brakes[1:]).any(axis=0)
        if k * dt > dead_time and not v[1:][behind & ~brakes[1:]].any():
            break
    return touched


def states(seed: int, n: int, count: int) -> tuple[Any, Braking, Any]:
    rng = np.random.default_rng(seed)
    v = np.clip(rng.uniform(0, 35, count) + rng.normal(0, 3, (n, count)), 0, 35)
    clearance = rng.uniform(0.2, 1.0, (n - 1, count)) * rng.choice([2.0, 10.0, 40.0], count)
    a = rng.uniform(-4, 2, (n, count))
    automated = (rng.random((n, count)) < 0.75).astype(float)
    automated[:, : count // 3] = 1.0
    automated[0, count // 3 : count // 2] = 0.0
    lag = rng.choice([0.0, 0.1, 0.4], (n, count))
    return clearance, Braking(v, a, 0.002 * rng.integers(0, 300), lag, rng.uniform(-9, -6, (n, count))), automated


@pytest.mark.parametrize("n", [2, 3, 4])
def test_it_is_what_a_fine_search_finds(n: int) -> None:
    clearance, vehicles, automated = states(n, n, 1500)
    found = brake_margin(clearance, vehicles, automated)
    assert ((found >= 0) & (found <= MOST)).all()
    less, more = np.maximum(found - NEAR, 0.0), found + NEAR
    harmless = ~touches(less, clearance, vehicles, automated)
    assert (harmless | (found == 0.0)).all()
    harmful = touches(more, clearance, vehicles, automated)
    assert (harmful | (found == MOST)).all()
    assert ((found > 0) & (found < MOST)).mean() > 0.2


def test_by_hand() -> None:
    """20 m/s, half a second of dead time, all brake with 8 m/s2; the leader stands at last, or they meet on the way."""
    vehicles = Braking(np.array([20.0, 20.0]), np.zeros(2), 0.5, 0.0, -8.0)
    at_last = 400.0 / (2.0 * (10.0 + 400.0 / 16.0 - 12.0))
    for clearance, b in ((4.0, 6.4), (12.0, at_last), (20.0, MOST)):
        found = brake_margin(np.array([clearance]), vehicles, np.array([0.0, 1.0]))
        assert found == pytest.approx(b, abs=1e-3)
        assert brake_margin(np.array([clearance]), vehicles) == found  # the leader, where all are automated


def test_standing_and_lone_vehicles_have_every_margin() -> None:
    assert brake_margin(np.array([1.0]), Braking(np.zeros(2), np.zeros(2), 0.2, 0.1, -8.0)) == MOST
    assert brake_margin(np.zeros(0), Braking(np.array([20.0]), np.zeros(1), 0.2, 0.1, -8.0)) == MOST


def test_vehicles_ahead_of_all_that_brake_do_not_matter() -> None:
    v = np.full(4, 20.0)
    apart, close = np.array([0.1, 0.1, 25.0]), np.array([0.1, 25.0, 0.1])
    vehicles = Braking(v, np.zeros(4), 0.3, 0.0, np.array([-3.0, -8.0, -8.0, -8.0]))
    human = np.array([1.0, 1.0, 0.0, 1.0])
    assert brake_margin(apart, vehicles, human) > 6.0
    assert brake_margin(close, vehicles, human) < 6.0


def test_a_weaker_brake_behind_a_stronger_one_leaves_no_margin() -> None:
    vehicles = Braking(np.full(3, 30.0), np.zeros(3), 0.0, 0.0, np.array([-8.0, -8.0, -4.0]))
    assert brake_margin(np.array([60.0, 10.0]), vehicles) == 0.0
    assert brake_margin(np.array([60.0, 60.0]), vehicles) > 8.0


def test_hardest_is_the_inverse_of_braking() -> None:
    rng = np.random.default_rng(3)
    v, t, b = rng.uniform(1, 30, 500), rng.uniform(0.1, 9, 500), rng.uniform(0.05, 11, 500)
    moved = np.where(b * t < v, v * t - 0.5 * b * t * t, v * v / (2 * b))
    np.testing.assert_allclose(hardest(moved, v, t), b, rtol=1e-9)


def test_platoons_one_by_one_and_with_casadi(monkeypatch: pytest.MonkeyPatch) -> None:
    casadi = pytest.importorskip("casadi")
    monkeypatch.setattr(braking, "INSTANTS", 12)
    clearance, vehicles, automated = states(9, 3, 12)
    batch = brake_margin(clearance, vehicles, automated)
    symbols = [casadi.SX.sym(name, size) for name, size in zip("cvalm", (2, 3, 3, 3, 3), strict=True)]
    flags = casadi.SX.sym("f", 3)
    c, v, a, lag, a_min = symbols
    margin = brake_margin(c, Braking(v, a, vehicles.dead_time, lag, a_min), flags)
    function = casadi.Function("margin", [*symbols, flags], [margin])
    for j in range(12):
        own = [part[:, j] for part in (vehicles.v, vehicles.a, vehicles.lag, vehicles.a_min)]
        one = brake_margin(
            clearance[:, j], Braking(own[0], own[1], vehicles.dead_time, own[2], own[3]), automated[:, j]
        )
        assert one == pytest.approx(batch[j], abs=1e-12)
        assert float(function(clearance[:, j], *own, automated[:, j])) == pytest.approx(batch[j], abs=1e-9)
