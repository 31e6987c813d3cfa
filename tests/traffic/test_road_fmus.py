"""Controller and plant FMUs of real vehicles, from outside: dead time, states with commands on their way."""

from __future__ import annotations

from collections import deque

import numpy as np
import pytest

from harness import OK, random_start

T, N = 0.01, 7
FIXED = {"parameter_source": 2, "lemma1_policy": 2, "kappa": 1.0}


def given(name: str, values, first: int) -> dict[str, float]:
    return {f"{name}[{i}]": float(value) for i, value in enumerate(values, start=first)}


def loop(instances, controller_fmu, plant_fmu, start, delay: float, late: int, steps: int):
    """Spacings and speeds at every instant; the controller sees what was `late` periods ago."""
    controller, plant = instances(controller_fmu), instances(plant_fmu)
    s, v = start
    times = {"actuation_delay": delay, "T": T}
    assert plant.initialise(times | given("s_start", s, 2) | given("v_start", v, 1)) == OK
    measured = given("s", s, 2) | given("v", v, 1)
    assert controller.initialise(times | FIXED | {"max_age": 0.5} | measured) == OK
    past, seen = deque(maxlen=late + 1), []
    for k in range(steps):
        past.append((plant.group("s"), plant.group("v"), k * T))
        seen.append(np.array(past[-1][0] + past[-1][1]))
        s, v, then = past[0]
        assert controller.set(given("s", s, 2) | given("v", v, 1) | {"t_measured": then}) == OK
        assert controller.step(k * T, T) == OK
        assert plant.set(given("a", controller.group("a"), 1)) == OK and plant.step(k * T, T) == OK
    return np.array(seen)


@pytest.mark.parametrize(("delay", "late"), [(0.0, 3), (0.07, 0), (0.12, 5)])
def test_a_pure_dead_time_only_begins_later(instances, controller_fmu, plant_fmu, delay, late):
    """From the dead time on, the FMUs' motion is that of the delay-free loop, begun from the state at that time."""
    s, v = random_start(11)
    s = [one + 3.0 for one in s]
    behind = round(delay / T)
    found = loop(instances, controller_fmu, plant_fmu, (s, v), delay, late, 60 + behind)
    begins = found[behind]
    np.testing.assert_allclose(begins[N - 1 :], v, atol=1e-12)  # nothing has been asked of them before
    expected = loop(instances, controller_fmu, plant_fmu, (begins[: N - 1], begins[N - 1 :]), 0.0, 0, 60)
    np.testing.assert_allclose(found[behind:], expected, atol=1e-9)


ROAD = {
    "bad_input": 2,
    "actuation_delay": 0.034,
    "kappa": 1.0,
    "closing_speed": 0.5,
    "closing_spacing": 6.0,
    "time_gap": 0.1,
    "error_s": 0.1,
    "error_v": 0.1,
    "certificate": 2,
    "lemma1_policy": 2,
    "max_age": 0.1,
}
ROAD |= given("actuator_lag", [0.0, 0.2, 0.2, 0.1, 0.2, 0.3, 0.2], 1) | given("length", [8.0, 0.0, 4, 5, 5, 5, 5], 1)
ROAD |= given("a_min", [-8.0] * N, 1) | given("a_max", [4.0] * N, 1)


@pytest.mark.parametrize("at", [0, 4, 9, 12])
def test_a_saved_state_has_the_identical_future_with_commands_on_their_way(instances, controller_fmu, at):
    one, other = instances(controller_fmu), instances(controller_fmu)
    rng = np.random.default_rng(5)
    rows = []
    for k in range(30):
        s, v = random_start(k)
        row = given("s", np.array(s) + 4.0, 2) | given("v", v, 1) | {"n_active": 7.0 if k % 7 else 6.0}
        row |= given("automated", [0.0, 1, 1, float(k % 3 > 0), 1, 1, 1], 1) | given(
            "a_measured", rng.normal(0, 1, N), 1
        )
        row |= given("a_known", [float(k % 2)] * N, 1) | {"t_measured": k * T - 0.03 if k > 5 else -1.0}
        rows.append(row | ({"v[3]": float("nan")} if k == 8 else {}))

    def drive(instance, first: int, last: int) -> list[list[float]]:
        seen = []
        for k in range(first, last):
            assert instance.set(rows[k]) == OK
            assert instance.step(k * T, T) == OK
            seen.append(instance.outputs())
        return seen

    assert one.initialise(ROAD | rows[0]) == OK
    drive(one, 0, at)
    state = one.slave.getFMUstate()
    data = one.slave.serializeFMUstate(state)
    expected = drive(one, at, 30)
    one.slave.setFMUstate(state)
    assert drive(one, at, 30) == expected
    other.slave.setFMUstate(other.slave.deSerializeFMUstate(data))
    assert drive(other, at, 30) == expected
    assert one.call("fmi2Reset") == OK and one.initialise(ROAD | rows[0]) == OK
    assert drive(one, 0, 30)[at:] == expected


def test_the_brake_margin_is_the_same_read_alone_and_with_all_others(instances, controller_fmu):
    names = [v.name for v in controller_fmu.description.modelVariables if v.causality == "output"]
    alone, together = instances(controller_fmu), instances(controller_fmu)
    for k in range(6):
        s, v = random_start(k)
        row = given("s", np.array(s) + 4.0, 2) | given("v", v, 1) | {"automated[1]": 0.0, "a_measured[1]": -0.5}
        for instance in (alone, together):
            status = instance.initialise(ROAD | row) if k == 0 else instance.set(row)
            assert status == OK and instance.step(k * T, T) == OK
        (margin,) = alone.get("brake_margin")
        assert margin == together.outputs()[names.index("brake_margin")] and 0.0 <= margin <= 12.0
