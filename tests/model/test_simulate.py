"""A whole run of psp_model against the scalar oracle, to 1e-9 absolute over 20 s."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from psp_model import (
    BEST_FIXED,
    V_OLD,
    Lemma1Policy,
    ObjectiveWeights,
    PlatoonParameters,
    PlatoonState,
    PotentialParameters,
    Run,
    Sampling,
    simulate,
)
from reference import Constants, ReferenceRun, reference_run
from strategies import feasible_triple, paper_start

TOLERANCE = 1e-9  # [m], [m/s], [m/s2], [s], [1]


def largest_difference(run: Run, oracle: ReferenceRun) -> float:
    """Over all outputs, sampling instants and vehicles."""
    pairs = [(getattr(run, name), np.array(getattr(oracle, name))) for name in ("time", "x", "s", "v", "a", "T_max")]
    pairs += [(run.cost[:, 0], np.array(oracle.J_acceleration)), (run.cost[:, 1], np.array(oracle.J_gap))]
    pairs += [(np.array(run.J), np.array(oracle.J))]
    assert all(ours.shape == theirs.shape for ours, theirs in pairs)
    return max(float(np.abs(ours - theirs).max()) for ours, theirs in pairs)


@pytest.mark.parametrize("vehicles", range(2, 13))
@pytest.mark.parametrize("new", [False, True], ids=["V_old", "V_new"])
def test_run_equals_the_oracle(vehicles: int, new: bool) -> None:
    shape = feasible_triple(100 + vehicles) if new else V_OLD
    s, v = paper_start(vehicles, vehicles)
    run = simulate(PlatoonState(s, v, x_leader=12.5), shape)
    oracle = reference_run(s.tolist(), v.tolist(), 12.5, alpha=shape.alpha, r=shape.r, p=shape.p, hill=new)
    assert largest_difference(run, oracle) < TOLERANCE


@pytest.mark.parametrize("seed", range(8))
def test_run_equals_the_oracle_for_more_triples(seed: int) -> None:
    shape = feasible_triple(seed)
    s, v = paper_start(50 + seed, 7)
    oracle = reference_run(s.tolist(), v.tolist(), alpha=shape.alpha, r=shape.r, p=shape.p)
    assert largest_difference(simulate(PlatoonState(s, v), shape), oracle) < TOLERANCE


def test_run_equals_the_oracle_for_other_constants_weights_and_period() -> None:
    constants = PlatoonParameters(L=4.0, lam=18.0, v_star=20.0, v_max=28.0, epsilon=0.5, mu=0.8, z=3.0)
    weights = ObjectiveWeights(w1=0.25, w2=2.0, a_ref=2.5, s_ref=7.0)
    shape = PotentialParameters(0.02, 9.0, 4.0)
    s, v = [6.0, 30.0, 8.5], [19.0, 28.0, 0.0, 12.0]
    run = simulate(
        PlatoonState(np.array(s), np.array(v), constants),
        shape,
        weights=weights,
        sampling=Sampling(0.02, Lemma1Policy.WARN),
        duration=10.0,
    )
    oracle_constants = Constants(4.0, 18.0, 20.0, 28.0, 0.5, 0.8, 0.25, 2.0, 2.5, 7.0)
    oracle = reference_run(s, v, alpha=0.02, r=9.0, p=4.0, T=0.02, duration=10.0, constants=oracle_constants)
    assert largest_difference(run, oracle) < TOLERANCE


def test_output_step_thins_the_output_only() -> None:
    s, v = paper_start(3, 4)
    fine = simulate(PlatoonState(s, v), BEST_FIXED, duration=2.0)
    coarse = simulate(PlatoonState(s, v), BEST_FIXED, duration=2.0, output_step=0.05)
    assert coarse.time.size == 41
    for name in ("x", "s", "v", "a", "T_max", "cost"):
        assert np.array_equal(getattr(coarse, name), getattr(fine, name)[::5])


def test_the_oracle_sees_a_change_of_the_model() -> None:
    """The comparison above can fail: a thousandth of a percent in p is far outside the tolerance."""
    s, v = paper_start(3, 4)
    run = simulate(PlatoonState(s, v), replace(BEST_FIXED, p=BEST_FIXED.p * (1 + 1e-5)))
    oracle = reference_run(s.tolist(), v.tolist(), alpha=1e-3, r=11.0, p=5.5)
    assert largest_difference(run, oracle) > 100 * TOLERANCE
