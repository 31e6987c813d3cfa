"""Lemma 1 along a run, against a scalar account written here from the paper."""

from __future__ import annotations

import numpy as np
import pytest

from psp_model import BEST_FIXED, V_OLD, Lemma1Policy, ModelError, PlatoonState, Sampling, StartDomain, simulate
from psp_model.analysis.certificate import KINDS, certify, holds_throughout, largest_certified_period


def start(seed: int) -> PlatoonState:
    s, v = StartDomain().draw(np.random.default_rng(seed), 7, 1)
    return PlatoonState(s[:, 0], v[:, 0])


def limits(s, v, a, c):
    """Every bound of Lemma 1 with who sets it, one by one."""
    for i, spacing in enumerate(s, start=2):
        yield (spacing - c.L) / c.v_max, i, 0
    for i, (speed, push) in enumerate(zip(v, a, strict=True), start=1):
        if push > 0:
            yield (c.v_max - speed) / push, i, 1
        if push < 0:
            yield speed / -push, i, 2


@pytest.mark.parametrize("shape", [V_OLD, BEST_FIXED], ids=["V_old", "V_new"])
def test_bound_vehicle_and_reason_at_every_instant(shape):
    one = start(4)
    run = simulate(one, shape, duration=3.0)
    found = certify(run, one.constants, 0.01)
    for k in range(0, run.time.size, 7):
        bound, vehicle, kind = min(limits(run.s[k], run.v[k], run.a[k], one.constants))
        assert found.T_max[k] == pytest.approx(bound, rel=1e-12)
        assert (found.vehicle[k], found.kind[k]) == (vehicle, kind)
        assert found.who(k) == f"vehicle {vehicle}, {KINDS[kind]}"
    np.testing.assert_array_equal(found.T_max, run.T_max)


def test_stretches_that_are_refused_are_those_with_t_at_or_above_the_bound():
    one, sampling = start(1), Sampling(0.05, Lemma1Policy.WARN)
    run = simulate(one, V_OLD, sampling=sampling, duration=2.0)
    found = certify(run, one.constants, sampling.T)
    listed = np.zeros(run.time.size, dtype=bool)
    for begin, end in found.refused():
        listed |= (run.time >= begin) & (run.time <= end)
    np.testing.assert_array_equal(listed, run.T_max <= sampling.T)
    assert listed.sum() == run.violations > 0


def test_the_largest_period_holds_and_a_little_more_does_not():
    one = start(2)
    for shape in (V_OLD, BEST_FIXED):
        T = largest_certified_period(one, shape, duration=5.0)
        simulate(one, shape, sampling=Sampling(T), duration=5.0)
        assert not holds_throughout(one, shape, 1.001 * T, 5.0)
        with pytest.raises(ModelError, match="Lemma 1"):
            simulate(one, shape, sampling=Sampling(1.001 * T), duration=5.0)


@pytest.mark.parametrize("T", [0.05, 0.07])
def test_the_last_instant_of_a_run_counts_although_duration_over_T_is_rounded(T):
    """In doubles 0.35 / 0.07 is below 5, yet a run of 0.35 s ends at its fifth instant, as that of `simulate` does."""
    rounded_down = 0
    for seed in range(40):
        run = simulate(start(seed), BEST_FIXED, sampling=Sampling(T, Lemma1Policy.WARN), duration=40 * T)
        refused = np.flatnonzero(run.T_max <= T)
        if not refused.size or refused[0] == 0:
            continue
        k = int(refused[0])
        rounded_down += int(round(k * T, 2) / T) < k
        assert not holds_throughout(start(seed), BEST_FIXED, T, round(k * T, 2))
        assert holds_throughout(start(seed), BEST_FIXED, T, (k - 0.5) * T)
    assert rounded_down > 0
