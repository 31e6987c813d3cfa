"""The plant that is driven period by period: a value, ideal with the defaults, and refused where it cannot remember."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from psp_model import Actuation, IdealPlant, ModelError, PlatoonState, RoadPlant
from psp_model.vehicles.road_plant import LONGEST_DEAD_TIME


def drawn(rng: np.random.Generator, n: int) -> PlatoonState:
    return PlatoonState(rng.uniform(6.0, 20.0, n - 1), rng.uniform(0.0, 3.0, n), x_leader=float(rng.normal()))


def plain(plant: RoadPlant) -> list[object]:
    now = plant.now
    queue = [(due, command.tolist()) for due, command in now.actuators.queue]
    told = [now.actuators.a.tolist(), now.actuators.command.tolist(), queue]
    return [float(now.x), now.s.tolist(), now.v.tolist(), *told, plant.period]


@given(st.integers(0, 300), st.integers(1, 5), st.lists(st.integers(0, 4), min_size=1, max_size=8), st.booleans())
@settings(max_examples=40)
def test_it_is_a_value_and_periods_passed_at_once_or_one_by_one_are_the_same(seed, n, jumps, delayed) -> None:
    rng = np.random.default_rng(seed)
    actuation = Actuation(0.12, rng.choice([0.0, 0.2], n), -5.0, rng.uniform(1.0, 4.0, n)) if delayed else Actuation()
    start = RoadPlant.begin(drawn(rng, n), 0.05, actuation)
    kept, walked, once, a = plain(start), start, start, rng.normal(0.0, 6.0, n)
    automated = rng.random(n) > 0.3
    for period in np.cumsum(jumps).tolist():
        for one in range(walked.period + 1, period + 1):
            walked = walked.advanced_to(one, a.copy(), automated)
        once = once.advanced_to(period, a, automated)
        assert plain(walked) == plain(once)
    assert plain(once.advanced_to(0, a)) == plain(once) and plain(start) == kept
    for array in (once.now.v, once.now.s):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 1.0


@pytest.mark.parametrize("lag", [0.0, np.zeros(4)])
def test_without_dead_time_lag_and_limits_it_is_the_ideal_plant_bit_for_bit(lag) -> None:
    rng = np.random.default_rng(1)
    start = drawn(rng, 4)
    road = RoadPlant.begin(start, 0.05, Actuation(0.0, lag, np.full(4, -inf), inf))
    ideal = IdealPlant.begin(start, 0.05)
    for k in range(1, 200):
        a = rng.normal(0.0, 5.0, 4)
        road, ideal = road.advanced_to(k, a, [0, 1, 1, 1]), ideal.advanced_to(k, a)
        assert road.now.v.tolist() == ideal.now.v.tolist() and road.now.s.tolist() == ideal.now.s.tolist()
        assert road.positions().tolist() == ideal.now.positions().tolist()
    assert road.is_ideal


def test_limits_alone_hold_for_those_who_are_told() -> None:
    start = PlatoonState([20.0, 20.0], [10.0, 10.0, 10.0])
    plant = RoadPlant.begin(start, 0.5, Actuation(a_min=-2.0, a_max=1.0)).advanced_to(2, [-9.0, -9.0, 9.0], [0, 1, 1])
    assert plant.now.v.tolist() == [1.0, 8.0, 11.0] and plant.accelerations().tolist() == [-9.0, -2.0, 1.0]
    plant = plant.advanced_to(3, [-9.0, -9.0, 9.0], [0, 1, 1])
    assert plant.now.v[0] == 0.0 and plant.accelerations()[0] == 0.0


def test_clearances_are_spacings_less_the_length_ahead() -> None:
    start = PlatoonState([20.0, 22.0], [10.0, 10.0, 10.0])
    assert RoadPlant.begin(start, 0.1).clearances().tolist() == [15.0, 17.0]
    assert RoadPlant.begin(start, 0.1, length=[12.0, 4.0, 5.0]).clearances().tolist() == [8.0, 18.0]


def test_as_many_commands_are_on_their_way_as_are_remembered_and_no_more() -> None:
    start, T = PlatoonState([20.0], [10.0, 10.0]), 0.01
    plant = RoadPlant.begin(start, T, Actuation(LONGEST_DEAD_TIME * T))
    for k in range(1, 1100):
        plant = plant.advanced_to(k, [float(k % 2), 0.0])
        assert len(plant.now.actuators.queue) <= LONGEST_DEAD_TIME + 1
    with pytest.raises(ModelError, match=r"must not exceed 510 periods of T = 0\.01 s"):
        RoadPlant.begin(start, T, Actuation(5.2))


def test_a_command_that_is_repeated_takes_no_room() -> None:
    plant = RoadPlant.begin(PlatoonState([20.0], [10.0, 10.0]), 0.01, Actuation(1.0, 0.2))
    for k in range(1, 90):
        plant = plant.advanced_to(k, [1.0 if k < 50 else -1.0, 0.0])
    assert len(plant.now.actuators.queue) == 2
