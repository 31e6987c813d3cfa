"""The paper's two scenarios: seven vehicles, the same starts, V_old against V_new with the best fixed triple."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from psp_model import BEST_FIXED, V_OLD, PlatoonState, PotentialParameters, Run, StartDomain, potential, simulate
from strategies import CONSTANTS, Vector, paper_start

SEEDS = range(4)
each_start = pytest.mark.parametrize("seed", SEEDS)


def close_start(seed: int) -> tuple[Vector, Vector]:
    """A start at the near edge of the paper's domain, where V_old pushes hardest."""
    rng = np.random.default_rng(seed)
    s, v = rng.uniform(8.02, 8.3, 6), rng.uniform(27, 30, 7)
    assert StartDomain().contains(s, v)
    return s, v


@cache
def scenario(shape: PotentialParameters, seed: int, close: bool = False) -> Run:
    s, v = close_start(seed) if close else paper_start(seed, 7)
    return simulate(PlatoonState(s, v), shape)


def peak(run: Run) -> float:
    return float(np.abs(run.a).max())


def minimum_before_the_hill() -> float:
    grid = np.linspace(BEST_FIXED.r - 1.0, BEST_FIXED.r + 1.0, 20_001)
    return float(grid[np.argmin(potential(grid, BEST_FIXED, CONSTANTS))])


@each_start
def test_scenario_1_spacings_end_at_or_above_lambda(seed: int) -> None:
    final = scenario(V_OLD, seed).s[-1]
    assert (final >= CONSTANTS.lam).all() and (final < 1.25 * CONSTANTS.lam).all()


@each_start
def test_accelerations_reach_hundreds_in_scenario_1_and_two_orders_less_in_scenario_2(seed: int) -> None:
    """Paper: 'extremely large' for short spacings with V_old, 'more realistic' with V_new."""
    old, new = peak(scenario(V_OLD, seed, close=True)), peak(scenario(BEST_FIXED, seed, close=True))
    assert old > 300.0
    assert new < old / 100.0


@each_start
def test_accelerations_anywhere_in_the_domain(seed: int) -> None:
    """For starts anywhere in the domain the ratio is smaller, because speeds far from v* alone ask for 1 to 4 m/s2."""
    old, new = peak(scenario(V_OLD, seed)), peak(scenario(BEST_FIXED, seed))
    assert old > 100.0 and new < 5.0
    assert new < old / 30.0


@each_start
def test_scenario_2_spacings_are_near_the_minimum_after_20_s(seed: int) -> None:
    """V_new is so flat before the hill that they are still closing in; those that got over the hill's crest are not."""
    final = scenario(BEST_FIXED, seed).s[-1]
    before = final[final < 13.0]
    assert before.size >= 5
    assert (np.abs(before - minimum_before_the_hill()) < 2.0).all()


@each_start
def test_scenario_2_takes_less_road(seed: int) -> None:
    assert scenario(BEST_FIXED, seed).s[-1].mean() < 0.6 * scenario(V_OLD, seed).s[-1].mean()


def test_scenario_2_spacings_converge_to_the_minimum() -> None:
    s, v = paper_start(0, 7)
    late = simulate(PlatoonState(s, v), BEST_FIXED, duration=100.0, output_step=50.0).s[-1]
    assert late == pytest.approx(np.full(6, minimum_before_the_hill()), abs=2e-3)


@each_start
def test_scenario_2_is_better_in_both_terms_of_the_objective(seed: int) -> None:
    assert (scenario(BEST_FIXED, seed).cost[-1] < scenario(V_OLD, seed).cost[-1]).all()


@pytest.mark.parametrize("shape", [V_OLD, BEST_FIXED], ids=["V_old", "V_new"])
@pytest.mark.parametrize("close", [False, True], ids=["anywhere", "close"])
@each_start
def test_both_scenarios_are_certified_throughout(shape: PotentialParameters, close: bool, seed: int) -> None:
    run = scenario(shape, seed, close)
    assert run.violations == 0 and (run.T_max > 0.01).all()
    assert run.s.min() > CONSTANTS.L and run.v.min() > 0 and run.v.max() < CONSTANTS.v_max


@each_start
def test_speeds_are_more_uniform_in_scenario_2(seed: int) -> None:
    """Paper, scenario 2: harmonisation of speeds."""
    old, new = (np.ptp(scenario(shape, seed).v, axis=1).max() for shape in (V_OLD, BEST_FIXED))
    assert new < old
