"""The predictor: with a pure dead time the loop is the delay-free one, begun later."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from measured_late import T, changed, measured_before
from psp_model import BEST_FIXED, Lemma1Policy, ModelError, PaperLaw, PlatoonState, Sampling, simulate
from psp_model.law.cooperation import Cooperation
from psp_model.parameters import Actuation
from psp_model.sampling.hold import IDEAL, Motion
from psp_model.vehicles.actuation import Foreign
from psp_model.vehicles.delayed import Delayed, DelayedVehicles
from psp_model.vehicles.membership import rearranged
from psp_model.vehicles.prediction import nothing_issued, predict
from psp_model.vehicles.road_law import RoadLaw, Seen
from strategies import CONSTANTS, paper_start

AFTER = 60  # sampling periods
VISCOUS = Cooperation(kappa=1.0)


def driven(law: RoadLaw, plant: DelayedVehicles, s: Any, v: Any, periods: int, age: float) -> list[tuple[Delayed, Any]]:
    """The plant at every sampling instant with the command given there."""
    memory, vehicles, past = None, plant.begin(0.0, s, v), []
    for _ in range(periods):
        past.append((vehicles, None))
        seen = measured_before(plant, past, age)
        memory, a = law.sample(memory, Seen(seen.s, seen.v, age))
        past[-1] = (vehicles, a)
        vehicles = plant.advance(vehicles, a, T)[0]
    return past


def ideal(s: Any, v: Any, cooperation: Cooperation, periods: int) -> list[Motion]:
    """The delay-free closed loop at its sampling instants."""
    law = RoadLaw(BEST_FIXED, CONSTANTS, cooperation)
    now, states = Motion(0.0, s, v), []
    for _ in range(periods):
        states.append(now)
        _, a = law.decide(None, now.s, now.v)
        now = IDEAL.advance(now, a, T)[0]
    return states


@settings(max_examples=15, deadline=None)
@given(
    st.integers(0, 10**6),
    st.integers(2, 9),
    st.floats(0.0, 0.3),
    st.floats(0.0, 0.15),
    st.sampled_from([Cooperation(), VISCOUS]),
)
def test_a_pure_dead_time_only_begins_later(
    seed: int, n: int, delay: float, age: float, cooperation: Cooperation
) -> None:
    s, v = paper_start(seed, n)
    s = s + delay * np.maximum(v[1:] - v[:-1], 0.0)  # so that nobody touches before the first command acts
    actuation = Actuation(delay)
    plant = DelayedVehicles(actuation)
    past = driven(RoadLaw(BEST_FIXED, CONSTANTS, cooperation, actuation, T, age), plant, s, v, AFTER, age)
    begins = plant.advance(past[0][0], 0.0 * v, delay)[0]
    expected = ideal(begins.s, begins.v, cooperation, AFTER)
    at = int(delay // T) + 1  # the first sampling instant after the first command acts
    for k in range(AFTER - at):
        since = (k + at) * T - delay
        number = int((since + 1e-12) // T)
        _, a = RoadLaw(BEST_FIXED, CONSTANTS, cooperation).decide(None, expected[number].s, expected[number].v)
        truth = IDEAL.advance(expected[number], a, since - number * T)[0]
        np.testing.assert_allclose(past[k + at][0].s, truth.s, atol=1e-9)
        np.testing.assert_allclose(past[k + at][0].v, truth.v, atol=1e-9)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6), st.integers(3, 7), st.floats(0.0, 0.2), st.floats(0.0, 0.1), st.booleans())
def test_joins_and_leaves_only_begin_later_too(seed: int, n: int, delay: float, age: float, joins: bool) -> None:
    """From a dead time after the change on, the motion is the delay-free loop of the new platoon."""
    s, v = paper_start(seed, n)
    actuation = Actuation(delay)
    plant, law = DelayedVehicles(actuation), RoadLaw(BEST_FIXED, CONSTANTS, VISCOUS, actuation, T, age)
    memory, vehicles, past = None, plant.begin(0.0, s + 3.0, v), []
    place = 1 + seed % (n - 1)
    for k in range(AFTER):
        past.append((vehicles, None))
        if k == AFTER // 2:
            members: list[int | None] = [one for one in range(n) if joins or one != place]
            if joins:
                members.insert(place, None)
            past = changed(past, members, 6.0, 30.0)
            if joins:  # room for the one that joins
                past = [(b._replace(s=b.s + 6.0 * (np.arange(n) == place)), a) for b, a in past]
            vehicles = past[-1][0]
            memory = rearranged(memory, members, vehicles.v)
            begins = plant.advance(vehicles, 0.0 * vehicles.v, 0.0)[0]
        seen = measured_before(plant, past, age)
        memory, a = law.sample(memory, Seen(seen.s, seen.v, age))
        past[-1] = (vehicles, a)
        if k == AFTER // 2:
            begins = plant.advance(vehicles, a, delay)[0]
        vehicles = plant.advance(vehicles, a, T)[0]
    expected = ideal(begins.s, begins.v, VISCOUS, AFTER)
    for k in range(AFTER // 2 + int(delay // T) + 1, AFTER):
        since = (k - AFTER // 2) * T - delay
        number = int((since + 1e-12) // T)
        _, a = RoadLaw(BEST_FIXED, CONSTANTS, VISCOUS).decide(None, expected[number].s, expected[number].v)
        truth = IDEAL.advance(expected[number], a, since - number * T)[0]
        np.testing.assert_allclose(past[k][0].s, truth.s, atol=1e-9)
        np.testing.assert_allclose(past[k][0].v, truth.v, atol=1e-9)


def test_the_predictor_runs_in_simulate() -> None:
    """And is worth it: nobody comes as close, and J is smaller."""
    start = PlatoonState(*paper_start(5, 7))
    actuation = Actuation(0.3, 0.0, -8.0, 4.0)
    sampling, plant = Sampling(policy=Lemma1Policy.WARN), DelayedVehicles(actuation)
    blind = simulate(start, BEST_FIXED, sampling=sampling, plant=plant)
    told = simulate(
        start,
        BEST_FIXED,
        sampling=sampling,
        plant=plant,
        controller=lambda potential, constants: RoadLaw(potential, constants, actuation=actuation),
    )
    assert told.s.min() > blind.s.min() + 0.5
    assert told.J < blind.J


@pytest.mark.parametrize("n", [2, 7])
def test_start_values_are_the_paper_bit_for_bit(n: int) -> None:
    start = PlatoonState(*paper_start(n, n))
    paper = simulate(start, BEST_FIXED)
    for controller, plant in ((RoadLaw, IDEAL), (PaperLaw, DelayedVehicles()), (RoadLaw, DelayedVehicles())):
        run = simulate(start, BEST_FIXED, controller=controller, plant=plant)
        for name in ("x", "s", "v", "a", "T_max"):
            assert (getattr(run, name) == getattr(paper, name)).all(), (controller, name)
        np.testing.assert_allclose(run.cost, paper.cost, rtol=1e-9)


def test_a_vehicle_that_drives_itself_is_extrapolated() -> None:
    """Exactly, while it holds its acceleration, down to standstill."""
    v = np.array([2.0, 10.0, 0.0])
    foreign = Foreign(np.array([0.0, 1.0, 0.0]), np.array([-4.0, 9.0, -3.0]))
    found = predict(nothing_issued(v, 0.4), np.array([30.0, 20.0]), v, 0.4, Actuation(0.6), foreign)
    np.testing.assert_allclose(found.v, [0.0, 10.0, 0.0])
    np.testing.assert_allclose(found.s, [30.0 + 0.5 - 10.0, 20.0 + 10.0])
    assert (found.a == 0.0).all()


def test_what_is_older_than_the_commands_remembered_is_refused() -> None:
    law = RoadLaw(BEST_FIXED, CONSTANTS, oldest=0.1)
    with pytest.raises(ModelError, match=r"is 0.2 s old, more than oldest = 0.1 s"):
        law.sample(None, Seen(*paper_start(1, 3), 0.2))
