"""The exact period against a fine-grained truth, and against Lemma 1, which it must never undercut."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from psp_model import largest_period
from psp_model.sampling.exact import exact_period, first_contact
from psp_model.sampling.hold import advance
from strategies import CONSTANTS

EDGE = 1e-9  # relative


def states(seed: int, n: int, count: int):
    """Random states of Omega, many of them near its borders, with accelerations of all sizes."""
    rng = np.random.default_rng(seed)
    L, v_max = CONSTANTS.L, CONSTANTS.v_max
    s = L + np.where(
        rng.random((n - 1, count)) < 0.5, rng.uniform(0.01, 40, (n - 1, count)), rng.exponential(1.0, (n - 1, count))
    )
    v = np.clip(rng.uniform(-0.1 * v_max, 1.1 * v_max, (n, count)), 0, v_max)
    a = rng.normal(0, 1, (n, count)) * 10 ** rng.uniform(-3, 2, count)
    inward = np.where(v == 0, np.abs(a), np.where(v == v_max, -np.abs(a), a))
    return s, v, inward


def left(s, v, a, t):
    """Whether a spacing has fallen to L or a speed has left its bounds at a time after the instant."""
    s, v = advance(s, v, a, t)
    return (s <= CONSTANTS.L).any(axis=0) | (v <= 0).any(axis=0) | (v >= CONSTANTS.v_max).any(axis=0)


@pytest.mark.parametrize("n", [2, 5])
def test_nothing_is_left_before_it_and_something_at_it(n: int) -> None:
    s, v, a = states(n, n, 20_000)
    exact = exact_period(s, v, a, CONSTANTS)
    finite = np.isfinite(exact) & (exact > 1e-6) & (exact < 1e4) & ((v > 0) & (v < CONSTANTS.v_max)).all(axis=0)
    s, v, a, exact = s[:, finite], v[:, finite], a[:, finite], exact[finite]
    assert finite.mean() > 0.3
    for part in np.linspace(0.0, 1.0 - 1e-7, 400):
        assert not left(s, v, a, part * exact).any(), part
    touched = left(s, v, a, exact * (1 + 1e-6)) | left(s, v, a, exact)
    grazing = ~touched  # a spacing that only touches L turns back at once: rounding decides
    assert grazing.mean() < 1e-3


@given(st.integers(0, 10**6), st.integers(2, 12))
def test_it_is_never_below_lemma_1(seed: int, n: int) -> None:
    s, v, a = states(seed, n, 20)
    assert (exact_period(s, v, a, CONSTANTS) >= largest_period(s, v, a, CONSTANTS) * (1 - EDGE)).all()


@pytest.mark.parametrize(
    ("c", "b", "a", "time"),
    [
        (1.0, -1.0, 0.0, 1.0),
        (1.0, 0.0, -2.0, 1.0),
        (1.0, 1.0, -4.0, 1.0),
        (1.0, -3.0, 4.0, 0.5),
        (1.0, -1.0, 1.0, np.inf),
        (1.0, -2.0, 2.0, 1.0),
        (0.5, -1.0, 1.0, 1.0),
        (1.0, 1.0, 1.0, np.inf),
        (1.0, 0.0, 0.0, np.inf),
        (1e-12, -1.0, 1e-9, 1e-12),
        (1.0, -1e8, -1.0, 1e-8),
    ],
)
def test_first_contact_by_hand(c: float, b: float, a: float, time: float) -> None:
    with np.errstate(all="raise"):  # the branch that is not taken is harmless, too
        assert first_contact(np.array(c), np.array(b), np.array(a)) == pytest.approx(time, rel=1e-12)
