"""The extended law: Theorem 1's signs, who follows whom, closing up, lengths and time gap."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from psp_model import BEST_FIXED, V_OLD, ModelError, feedback, largest_period, validate
from psp_model.law.cooperation import (
    ALL_AUTOMATED,
    Cooperation,
    Traffic,
    clearances,
    closing_speeds,
    contact_spacing,
    cooperative_command,
    desired,
    model_spacing,
)
from psp_model.law.following import followed_by
from psp_model.law.watching import accelerations, watch
from strategies import CONSTANTS, omega, paper_start, shapes

EVERYTHING = Cooperation(1.5, 40.0, 0.7, 0.8, 1, 0.6)


def flags(seed: int, n: int) -> Any:
    return (np.random.default_rng(seed).random(n) < 0.6).astype(float)


@given(omega(1e-3), shapes())
def test_start_values_are_the_paper_bit_for_bit(start: Any, shape: Any) -> None:
    s, v = start
    with np.errstate(over="ignore", invalid="ignore"):
        found = cooperative_command(s, v, shape, CONSTANTS, Cooperation(), ALL_AUTOMATED)
        paper = feedback(s, v, shape, CONSTANTS)
        told = cooperative_command(s, v, shape, CONSTANTS, Cooperation(), Traffic(v_desired=CONSTANTS.v_star))
        lengths = Cooperation(length=np.full(v.size, CONSTANTS.L))
        of_equal_length = cooperative_command(s, v, shape, CONSTANTS, lengths, ALL_AUTOMATED)
    assert np.array_equal(found, paper, equal_nan=True)
    assert np.array_equal(told, paper, equal_nan=True)
    assert np.array_equal(of_equal_length, paper, equal_nan=True)


@given(omega(1e-3), st.integers(0, 10**6), st.sampled_from([1, 2]), st.floats(0, 35), st.floats(-9, 9), st.floats(0, 3))
def test_signs_of_theorem_1_hold(
    start: Any, seed: int, following: int, v_desired: float, a_desired: float, time_gap: float
) -> None:
    """Whatever is on: no command points backwards at v = 0, nor forwards at v_max."""
    s, v = start
    n = v.size
    rng = np.random.default_rng(seed)
    cooperation = replace(EVERYTHING, following=following, time_gap=time_gap, length=rng.uniform(3, 5, n))
    closing = closing_speeds(model_spacing(s, v, cooperation, CONSTANTS), cooperation, flags(seed, n))
    traffic = Traffic(flags(seed, n), rng.normal(0, 5, n), v_desired, a_desired, closing)
    for bound, sign in ((0.0, 1.0), (CONSTANTS.v_max, -1.0)):
        for i in range(n):
            there = v.copy()
            there[i] = bound
            F = cooperative_command(s, there, BEST_FIXED, CONSTANTS, cooperation, traffic)
            assert sign * F[i] >= 0.0, (i, bound, F[i])


def test_who_is_followed() -> None:
    automated = np.array([0.0, 1, 1, 0, 1, 1])
    assert followed_by(automated).tolist() == [0, 1, 1, 0, 4, 4]
    assert followed_by(automated, 2).tolist() == [0, 1, 2, 0, 4, 5]
    assert followed_by(np.ones(4)).tolist() == [0, 0, 0, 0]
    assert followed_by(np.ones(1)).tolist() == [0]


def test_speeds_and_accelerations_are_those_of_the_one_followed() -> None:
    v, a = np.array([20.0, 21, 22, 23, 24]), np.array([1.0, 9, 9, -2, 9])
    traffic = Traffic(np.array([1.0, 1, 1, 0, 1]), a, 28.0, 0.5)
    speed, rate = desired(v, traffic, Cooperation(), CONSTANTS)
    assert speed.tolist() == [28, 28, 28, 28, 23] and rate.tolist() == [0.5, 0.5, 0.5, 0.5, -2]
    speed, rate = desired(v, traffic, Cooperation(following=2), CONSTANTS)
    assert speed.tolist() == [28, 20, 21, 22, 23] and rate.tolist() == [0.5, 0, 0, 0, 0]
    assert desired(v, Traffic(), Cooperation(), CONSTANTS)[0].tolist() == [30.0] * 5


def test_closing_up_adds_up_from_the_one_followed() -> None:
    s = np.array([40.0, 40, 10, 40, 40])
    cooperation = Cooperation(closing_speed=0.6)
    assert closing_speeds(s, cooperation) == pytest.approx([0, 0.6, 1.2, 1.2, 1.8, 2.4])
    human = np.array([1.0, 1, 1, 0, 1, 1])
    assert closing_speeds(s, cooperation, human) == pytest.approx([0, 0.6, 1.2, 1.2, 0.6, 1.2])
    assert closing_speeds(s, replace(cooperation, following=2)) == pytest.approx([0, 0.6, 0.6, 0, 0.6, 0.6])
    assert closing_speeds(np.array([15.0, 100.0, 200.0]), cooperation).tolist() == [0, 0, 0, 0]
    v = np.full(6, 30.0)
    fast = Traffic(v_desired=34.0, closing=closing_speeds(s, cooperation))
    assert desired(v, fast, cooperation, CONSTANTS)[0] == pytest.approx([34, 34.5, 34.5, 34.5, 34.5, 34.5])
    fast = replace(fast, v_desired=34.8)
    assert desired(v, fast, cooperation, CONSTANTS)[0] == pytest.approx([34.8] * 6)


def test_lengths_are_those_of_the_vehicle_ahead() -> None:
    s, truck = np.array([21.5, 10.0]), Cooperation(length=np.array([16.5, 5.0, 16.5]))
    assert contact_spacing(s, truck, CONSTANTS).tolist() == [10.0, 10.0]
    assert clearances(s, truck, CONSTANTS).tolist() == [5.0, 5.0]
    assert clearances(s, Cooperation(), CONSTANTS).tolist() == [16.5, 5.0]
    v = np.full(3, 30.0)
    cars = cooperative_command(np.array([10.0, 10.0]), v, BEST_FIXED, CONSTANTS, Cooperation(), ALL_AUTOMATED)
    assert (cooperative_command(s, v, BEST_FIXED, CONSTANTS, truck, ALL_AUTOMATED) == cars).all()


@given(omega(1e-6), st.floats(0, 5))
def test_the_model_spacing_is_above_L_exactly_where_nobody_touches(start: Any, time_gap: float) -> None:
    s, v = start
    spacing = model_spacing(s, v, Cooperation(time_gap=time_gap), CONSTANTS)
    assert (spacing > CONSTANTS.L).all() and (spacing <= s).all()
    assert largest_period(spacing, v, 0.0 * v, CONSTANTS) <= largest_period(s, v, 0.0 * v, CONSTANTS)


def test_a_platoon_told_to_stand_stands_and_nobody_creeps() -> None:
    v = np.zeros(4)
    s = np.array([12.5, 9.0, 14.0])
    for cooperation in (Cooperation(), EVERYTHING):
        F = cooperative_command(s, v, BEST_FIXED, CONSTANTS, cooperation, Traffic(v_desired=0.0))
        assert (F == 0.0).all()


def test_accelerations_are_communicated_or_estimated() -> None:
    watched = watch(None, np.array([20.0, 20.0]), np.zeros(2), 0.1)
    for k in range(1, 30):
        watched = watch(watched, np.array([20.0 - 0.3 * k, 20.0]), np.array([0.0, 0.6]), 0.1)
    assert watched.a == pytest.approx([-3.0, 0.0], abs=1e-4)
    assert 0.4 < watched.closing[1] < 0.6
    assert accelerations(watched, np.array([-2.0, 1.0]), np.array([0.0, 1.0]))[1] == 1.0
    assert accelerations(watched, None, None)[0] == watched.a[0]


def test_a_batch_equals_its_members_and_casadi_gives_the_same() -> None:
    casadi = pytest.importorskip("casadi")
    n, count = 5, 6
    s = np.stack([paper_start(seed, n)[0] for seed in range(count)], axis=1) + np.arange(count) * 6.0
    v = np.stack([paper_start(seed, n)[1] for seed in range(count)], axis=1)
    automated, a = np.array([0.0, 1, 0, 1, 1]), np.array([-2.0, 0, 1.5, 0, 0])
    lengths = np.array([16.5, 5, 5, 8, 5])

    def evaluate(s: Any, v: Any, automated: Any, a: Any, lengths: Any, following: int) -> Any:
        cooperation = replace(EVERYTHING, length=lengths, following=following)
        closing = closing_speeds(model_spacing(s, v, cooperation, CONSTANTS), cooperation, automated)
        traffic = Traffic(automated, a, 29.0, 0.3, closing)
        return cooperative_command(s, v, V_OLD, CONSTANTS, cooperation, traffic)

    for following in (1, 2):
        s = s + 12.0
        batch = evaluate(s, v, automated[:, None], a[:, None], lengths[:, None], following)
        symbols = [casadi.SX.sym(name, size) for name, size in (("s", n - 1), ("v", n), ("m", n), ("a", n), ("l", n))]
        function = casadi.Function("F", symbols, [evaluate(*symbols, following)])
        for j in range(count):
            one = evaluate(s[:, j], v[:, j], automated, a, lengths, following)
            np.testing.assert_allclose(batch[:, j], one, rtol=1e-12, atol=1e-12)
            symbolic = function(s[:, j], v[:, j], automated, a, lengths).full()[:, 0]
            np.testing.assert_allclose(symbolic, one, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"kappa": -1.0}, "kappa = -1 1/s must not be negative"),
        ({"kappa": float("nan")}, "kappa must be a finite number"),
        ({"time_gap": -0.1}, "time_gap = -0.1 s must not be negative"),
        ({"feedforward": 1.2}, r"feedforward = 1.2 must lie in \[0, 1\]"),
        ({"following": 3}, "following = 3 must be 1"),
        ({"closing_reach": 10.0}, "closing_reach = 10 m must exceed closing_spacing = 15 m"),
        ({"length": np.array([5.0, 0.0])}, r"length\[2\] = 0 m must be positive"),
    ],
)
def test_what_makes_no_sense_is_refused(wrong: dict[str, Any], said: str) -> None:
    with pytest.raises(ModelError, match=said):
        validate(Cooperation(**wrong))


def test_what_makes_sense_is_not() -> None:
    validate(Cooperation())
    validate(replace(EVERYTHING, length=np.array([16.5, 5.0])))
