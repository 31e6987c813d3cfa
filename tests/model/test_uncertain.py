"""Lemma 1 with errors and dead time: what it is without them, and that more of them never certifies more."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from psp_model import BEST_FIXED, feedback, largest_period
from psp_model.sampling.exact import exact_period, first_contact
from psp_model.sampling.uncertain import Errors, uncertain_exact_period, uncertain_period
from strategies import CONSTANTS, omega


@given(omega(1e-3))
def test_without_errors_they_are_lemma_1_and_the_exact_period_bit_for_bit(start: Any) -> None:
    s, v = start
    a = feedback(s, v, BEST_FIXED, CONSTANTS)
    assert uncertain_period(s, v, a, Errors(), CONSTANTS) == largest_period(s, v, a, CONSTANTS)
    assert uncertain_exact_period(s, v, a, Errors(), CONSTANTS) == exact_period(s, v, a, CONSTANTS)


@given(omega(1e-3), st.floats(0, 2), st.floats(0, 2), st.integers(0, 10**6))
def test_it_is_lemma_1_of_the_worst_state_inside_the_bounds(
    start: Any, error_s: float, error_v: float, seed: int
) -> None:
    """No state within the bounds, and no acceleration between the one before and the command, has a smaller T_max."""
    s, v = start
    rng = np.random.default_rng(seed)
    a, before = rng.normal(0, 4, (2, v.size))
    found = uncertain_period(s, v, a, Errors(error_s, error_v), CONSTANTS, before)
    exact = uncertain_exact_period(s, v, a, Errors(error_s, error_v), CONSTANTS, before)
    assert exact >= found >= 0.0
    for _ in range(20):
        true_s = s + error_s * rng.choice([-1.0, 1.0, rng.uniform(-1, 1)], s.size)
        true_v = np.clip(v + error_v * rng.choice([-1.0, 1.0, rng.uniform(-1, 1)], v.size), 0, CONSTANTS.v_max)
        if (true_s > CONSTANTS.L).all():
            held = before + rng.uniform(0, 1, v.size) * (a - before)
            assert found <= largest_period(true_s, true_v, held, CONSTANTS) * (1 + 1e-12)
            assert exact <= exact_period(true_s, true_v, held, CONSTANTS) * (1 + 1e-9)


@given(omega(1e-3), st.integers(0, 10**6))
def test_whoever_drives_himself_counts_by_his_acceleration_and_not_by_his_speed(start: Any, seed: int) -> None:
    s, v = start
    rng = np.random.default_rng(seed)
    a, drives = rng.normal(0, 4, v.size), rng.random(v.size) < 0.5
    ours, theirs = np.where(drives, 0.0, a), np.where(drives, a, 0.0)
    found = uncertain_exact_period(s, v, ours, Errors(), CONSTANTS, a_foreign=theirs)
    of_speeds = exact_period(np.full(s.shape, 1e9), v, ours, CONSTANTS)
    contacts = [first_contact(s[i] - CONSTANTS.L, v[i] - v[i + 1], a[i] - a[i + 1]) for i in range(s.size)]
    assert found == min([of_speeds, *contacts])


def test_errors_are_carried_through_the_prediction() -> None:
    """Both speeds may be wrong, each its own way."""
    assert Errors(0.1, 0.2).carried(0.5) == Errors(0.1 + 2 * 0.5 * 0.2, 0.2)


def test_a_spacing_that_may_have_closed_certifies_nothing() -> None:
    s, v, a = np.array([5.4]), np.array([20.0, 20.0]), np.zeros(2)
    assert uncertain_period(s, v, a, Errors(0.5), CONSTANTS) == 0.0
    assert uncertain_period(s, v, a, Errors(0.1), CONSTANTS) > 0.0
