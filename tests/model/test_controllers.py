"""Controllers and plants of one's own: those that remember run in simulations and in rollouts alike."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import reference
from psp_model import (
    BEST_FIXED,
    V_OLD,
    Actuation,
    Controller,
    DelayedVehicles,
    ObjectiveWeights,
    PaperLaw,
    Plant,
    PlatoonParameters,
    PlatoonState,
    Potential,
    PotentialParameters,
    SampledPlatoon,
    Sampling,
    feedback,
    largest_period,
    rollout_costs,
    simulate,
)
from psp_model.sampling.hold import IDEAL, Motion
from psp_model.sampling.loop import with_potential
from psp_model.sampling.period import decide, hold
from psp_model.vehicles.ideal import STOPPING
from strategies import CONSTANTS, feasible_triple, paper_start

T, WEIGHTS = 0.01, ObjectiveWeights(w1=0.7, a_ref=2.0)
SOFT = replace(V_OLD, alpha=0.02)  # V_old itself is too strong for commands that come late


class Last(NamedTuple):
    """The command that has been decided and not yet given, and how often one has been decided."""

    command: Any
    count: int


@dataclass(frozen=True)
class OnePeriodLate:
    """The paper's law, its commands given one period late: at first those of standing still relative to v*."""

    potential: Potential
    constants: PlatoonParameters
    first: float = 0.0

    def decide(self, memory: Last | None, s: Any, v: Any) -> tuple[Last, Any]:
        decided = feedback(s, v, self.potential, self.constants)
        given = self.first + 0.0 * decided if memory is None else memory.command
        return Last(decided, 1 if memory is None else memory.count + 1), given


def late_run(s: Any, v: Any, shape: PotentialParameters, periods: int, first: float = 0.0) -> tuple[list[Any], float]:
    """Commands and J of the same, one vehicle at a time from the oracle."""
    c = reference.Constants(w1=WEIGHTS.w1, w2=WEIGHTS.w2, a_ref=WEIGHTS.a_ref, s_ref=WEIGHTS.s_ref)
    s, v, given, rows, J = list(s), list(v), [first] * len(v), [], 0.0
    for _ in range(periods):
        hill = bool(shape.hill)
        decided = reference.accelerations(s, v, shape.alpha, shape.r, shape.p, hill, c)
        rows.append(given)
        for i, a in enumerate(given):
            J += c.w1 * T * (a / c.a_ref) ** 2
            if i:
                dv, da = v[i - 1] - v[i], given[i - 1] - a
                J += c.w2 * (T * s[i - 1] + T**2 / 2 * dv + T**3 / 6 * da) / c.s_ref
                s[i - 1] += T * dv + T**2 / 2 * da
        v = [one + T * a for one, a in zip(v, given, strict=True)]
        given = decided
    return rows, J


@given(st.integers(0, 100), st.integers(2, 7), st.sampled_from(["old", "new"]))
@settings(max_examples=12)
def test_a_controller_that_remembers_runs_in_simulate_and_in_rollouts(seed: int, n: int, which: str) -> None:
    shape = SOFT if which == "old" else feasible_triple(seed % 20)
    s, v = paper_start(seed, n)
    start, rows = PlatoonState(s, v), 60
    commands, J = late_run(s, v, shape, rows)
    run = simulate(start, shape, weights=WEIGHTS, duration=rows * T, controller=OnePeriodLate)
    np.testing.assert_allclose(run.a[:rows], commands, rtol=1e-9, atol=1e-12)
    assert pytest.approx(J, rel=1e-10) == run.J
    costs, certified = rollout_costs(start, [shape] * 2, WEIGHTS, Sampling(), rows * T, controller=OnePeriodLate)
    assert costs == pytest.approx([J, J], rel=1e-10) and certified.all()
    undelayed = simulate(start, shape, weights=WEIGHTS, duration=rows * T)
    assert np.allclose(run.a[1], undelayed.a[0], rtol=1e-12) and run.J != undelayed.J


def test_what_a_controller_is_made_with_stays_when_the_potential_changes() -> None:
    """`with_potential` makes the same controller for another potential, whatever else it holds."""

    def made(potential: Potential, constants: PlatoonParameters) -> OnePeriodLate:
        return OnePeriodLate(potential, constants, first=0.25)

    s, v = paper_start(4, 3)
    platoon = SampledPlatoon.begin(PlatoonState(s, v), SOFT, controller=made)
    assert platoon.now.a.tolist() == [0.25] * 3
    platoon.advance_to(2, 0.0)
    now = platoon.now
    assert isinstance(now.memory, Last) and now.memory.count == 3
    changed = platoon.take_over(2, 0.0, now.x, now.s, now.v, BEST_FIXED)
    assert changed.loop.controller == OnePeriodLate(BEST_FIXED, CONSTANTS, 0.25)
    assert changed.now.a.tolist() == [0.25] * 3  # whoever is new has nothing remembered of it
    assert with_potential(platoon.loop, SOFT).controller == platoon.loop.controller


def test_a_copy_or_a_look_in_between_does_not_make_a_controller_remember_twice() -> None:
    s, v = paper_start(4, 3)
    walked, leapt = (SampledPlatoon.begin(PlatoonState(s, v), SOFT, controller=OnePeriodLate) for _ in range(2))
    for k in range(1, 90):
        walked.advance_to(k // 3, (k % 3) / 3.0)
        walked.observe(k // 3, (k % 3) / 3.0)
    walked.advance_to(30, 0.0)
    leapt.advance_to(30, 0.0)
    assert walked.now.a.tolist() == leapt.now.a.tolist() and walked.now.memory.count == leapt.now.memory.count == 31


@given(st.integers(0, 100), st.integers(2, 7))
@settings(max_examples=10)
def test_a_batch_is_so_many_runs(seed: int, n: int) -> None:
    """decide and hold take vehicles along the first axis and runs along the last, like everything below them."""
    shapes = [V_OLD, BEST_FIXED, feasible_triple(seed % 20)]
    s, v = paper_start(seed, n)
    together = PotentialParameters(
        *(np.array([getattr(one, f) for one in shapes]) for f in ("alpha", "r", "p", "hill"))
    )
    many = Motion(np.zeros(3), np.repeat(s[:, None], 3, axis=1), np.repeat(v[:, None], 3, axis=1))
    memory, a, T_max = decide(OnePeriodLate(together, CONSTANTS), None, many)
    memory, a, T_max = decide(OnePeriodLate(together, CONSTANTS), memory, many)
    after, terms = hold(IDEAL, many, a, T, WEIGHTS)
    for k, shape in enumerate(shapes):
        one = Motion(0.0, s, v)
        expected = feedback(s, v, shape, CONSTANTS)
        np.testing.assert_allclose(a[:, k], expected, rtol=1e-12, atol=1e-13)
        assert T_max[k] == pytest.approx(float(largest_period(s, v, expected, CONSTANTS)), rel=1e-12)
        alone, added = hold(IDEAL, one, expected, T, WEIGHTS)
        np.testing.assert_allclose(after.s[:, k], alone.s, rtol=1e-14)
        assert [term[k] for term in terms] == pytest.approx(list(added), rel=1e-12)


def test_the_paper_s_law_remembers_nothing_and_takes_its_own_constants() -> None:
    s, v = paper_start(3, 4)
    memory, a, T_max = decide(PaperLaw(BEST_FIXED, CONSTANTS), None, Motion(0.0, s, v))
    assert memory is None and np.array_equal(a, feedback(s, v, BEST_FIXED, CONSTANTS))
    assert T_max == largest_period(s, v, a, CONSTANTS)
    law: Controller[None] = PaperLaw(V_OLD, replace(CONSTANTS, mu=0.9))
    assert np.array_equal(law.decide(None, s, v)[1], feedback(s, v, V_OLD, replace(CONSTANTS, mu=0.9)))


@dataclass(frozen=True)
class HalfAsStrong:
    """Vehicles that give half of what they are told, and remember nothing."""

    share: float = 0.5

    def begin(self, x: Any, s: Any, v: Any) -> Motion:
        return Motion(x, s, v)

    def advance(self, vehicles: Motion, a: Any, tau: Any) -> tuple[Motion, Any]:
        after, _ = IDEAL.advance(vehicles, self.share * a, tau)
        return after, self.share * a


PLANTS: dict[str, Plant[Any]] = {
    "ideal": IDEAL,
    "stopping": STOPPING,
    "late": DelayedVehicles(Actuation(0.013, 0.1)),
    "one's own": HalfAsStrong(),
}


@pytest.mark.parametrize("name", PLANTS)
def test_every_plant_costs_the_same_in_rollouts_and_in_runs(name: str) -> None:
    start, candidates = PlatoonState(*paper_start(3, 4)), [BEST_FIXED, feasible_triple(2), SOFT]
    costs, _ = rollout_costs(start, candidates, WEIGHTS, Sampling(), 0.7, plant=PLANTS[name])
    runs = [simulate(start, one, weights=WEIGHTS, duration=0.7, plant=PLANTS[name]).J for one in candidates]
    assert costs == pytest.approx(runs, rel=1e-12) and len(set(runs)) == 3


@pytest.mark.parametrize("name", PLANTS)
def test_a_plant_that_is_held_for_no_time_is_where_it_was(name: str) -> None:
    (s, v), a = paper_start(3, 4), np.array([-3.0, 0.0, 2.0, 1.0])
    vehicles = PLANTS[name].begin(2.0, s, v)
    with np.errstate(all="raise"):
        after, mean = PLANTS[name].advance(vehicles, a, 0.0)
    assert after.x == 2.0 and np.array_equal(after.s, s) and np.array_equal(after.v, v) and np.isfinite(mean).all()


MAKERS: dict[str, Callable[..., Any]] = {"law": PaperLaw, "late": OnePeriodLate}


@pytest.mark.parametrize("maker", MAKERS)
@pytest.mark.parametrize("n", [1, 2, 6])
def test_J_counts_what_the_vehicles_did_and_not_what_they_were_told(maker: str, n: int) -> None:
    start, rows = PlatoonState(*paper_start(9, n)), 50
    told = {"controller": MAKERS[maker], "plant": HalfAsStrong()}
    run = simulate(start, BEST_FIXED, weights=WEIGHTS, duration=rows * T, **told)
    did = 0.5 * run.a[:rows]
    np.testing.assert_allclose(np.diff(run.v, axis=0), T * did, rtol=1e-9, atol=1e-12)
    assert run.cost[-1, 0] == pytest.approx(WEIGHTS.w1 * T * (did**2).sum() / WEIGHTS.a_ref**2, rel=1e-12)
    area = T * run.s[:-1] + T**2 / 2 * -np.diff(run.v[:-1], axis=1) + T**3 / 6 * -np.diff(did, axis=1)
    assert run.cost[-1, 1] == pytest.approx(WEIGHTS.w2 * area.sum() / WEIGHTS.s_ref, rel=1e-12)
    costs, _ = rollout_costs(start, [BEST_FIXED], WEIGHTS, Sampling(), rows * T, **told)
    assert costs[0] == pytest.approx(run.J, rel=1e-12)
