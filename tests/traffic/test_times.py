"""Controller, plant and leader under masters whose time drifts, is negative or is a Unix clock's."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from harness import ERROR, OK, random_start, starts
from masters import MASTERS, ROUNDERS, counts, steps_of
from psp_model import BEST_FIXED, PlatoonParameters, feedback
from psp_model.vehicles.leader import Wave

T, N = Fraction(1, 100), 7
STARTS = (0.0, 1e6, 1.7e9, -1.7e9)
FIXED = {"parameter_source": 2}
PATTERNS = {"T": "1", "T/4": "1/4", "T/3": "1/3", "5 T": "5", "3.7 T": "37/10", "uneven": "1/2 1/3 1/6"}
MEASURED = [random_start(k) for k in range(5)]
COMMANDS = [feedback(np.array(s), np.array(v), BEST_FIXED, PlatoonParameters()) for s, v in MEASURED]


def told_by(name: str, start: float, pattern: str, count: int):
    return steps_of((MASTERS | ROUNDERS)[name], start, [Fraction(part) * T for part in pattern.split()], count)


def inputs(k: int) -> dict[str, float]:
    s, v = MEASURED[k % len(MEASURED)]
    spacings = {f"s[{i}]": spacing for i, spacing in enumerate(s, start=2)}
    return spacings | {f"v[{i}]": speed for i, speed in enumerate(v, start=1)}


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("pattern", PATTERNS)
def test_the_command_follows_the_inputs_of_its_sampling_instant(instances, controller_fmu, pattern, start):
    """New inputs at every communication point; those at an instant count there and until the next one."""
    for name in MASTERS:
        controller, held, before = instances(controller_fmu), 0, Fraction(0)
        assert controller.initialise(FIXED | inputs(0), start) == OK
        np.testing.assert_allclose(controller.group("a"), COMMANDS[0], atol=1e-12)
        for k, (begin, size, end) in enumerate(told_by(name, start, PATTERNS[pattern], 40), start=1):
            assert controller.step(begin, size) == OK, controller.messages
            if -(-end // T) - 1 > before // T:
                held = (k - 1) % len(COMMANDS)  # instants inside the step had the inputs from its beginning
            assert controller.set(inputs(k)) == OK
            if (end / T).denominator == 1:
                held = k % len(COMMANDS)
            before = end
            np.testing.assert_allclose(controller.group("a"), COMMANDS[held], atol=1e-12, err_msg=f"{name} {k}")


@pytest.mark.parametrize("name", ROUNDERS)
def test_masters_that_round_more_are_understood_too(instances, controller_fmu, name):
    controller = instances(controller_fmu)
    assert controller.initialise(FIXED | inputs(0)) == OK
    for k, (begin, size, _) in enumerate(told_by(name, 0.0, "1", 600), start=1):
        assert controller.step(begin, size) == OK, controller.messages
        assert controller.set(inputs(k)) == OK
        np.testing.assert_allclose(controller.group("a"), COMMANDS[k % len(COMMANDS)], atol=1e-12)


@pytest.mark.parametrize("start", STARTS)
def test_a_phase_and_a_saved_state_keep_the_clock(instances, controller_fmu, start):
    """Instants at T/2, 3 T/2 ...; the state goes through bytes into another instance at every tenth step."""
    for name in MASTERS:
        controller, other = instances(controller_fmu), instances(controller_fmu)
        for one in (controller, other):
            assert one.initialise(FIXED | {"phase": 0.005} | inputs(0), start) == OK
        held = None
        for k, (begin, size, end) in enumerate(told_by(name, start, "1/4", 60), start=1):
            assert controller.step(begin, size) == OK
            assert controller.set(inputs(k)) == OK
            if (end / T - Fraction(1, 2)).denominator == 1:
                held = k % len(COMMANDS)
            np.testing.assert_allclose(controller.group("a"), 0.0 if held is None else COMMANDS[held], atol=1e-12)
            if k % 10 == 0:
                state = controller.slave.getFMUState()
                data = controller.slave.serializeFMUstate(state)
                controller.slave.freeFMUState(state)
                state = other.slave.deSerializeFMUstate(data)
                other.slave.setFMUState(state)
                other.slave.freeFMUState(state)
                controller, other = other, controller


@pytest.mark.parametrize(  # a negative t_measured stands for none
    ("start", "stamped"),
    [(start, stamped) for start in STARTS for stamped in (False, True) if start >= 0 or not stamped],
)
def test_inputs_of_exactly_max_age_are_not_stale_and_older_ones_are(instances, controller_fmu, start, stamped):
    """Measured at every third instant, by the time of setting or by the master's own."""
    for name in MASTERS:
        for max_age, fresh in ((0.02, True), (0.0199, False)):
            controller = instances(controller_fmu)
            told = told_by(name, start, "1", 91)
            settings = FIXED | {"bad_input": 2, "max_age": max_age} | inputs(0)
            assert controller.initialise(settings | ({"t_measured": start} if stamped else {}), start) == OK
            for k, (begin, size, _) in enumerate(told, start=1):
                assert controller.step(begin, size) == OK
                if k % 3 == 0:
                    assert controller.set(inputs(0) | ({"t_measured": begin + size} if stamped else {})) == OK
            assert controller.get("input_faults") == [0.0 if fresh else 30.0], controller.messages


@pytest.mark.parametrize("start", STARTS)
def test_the_plant_moves_at_its_instants(instances, plant_fmu, start):
    s, v = random_start(3)

    def run(told, begin_at):
        plant, seen = instances(plant_fmu), {}
        assert plant.initialise(starts(s, v), begin_at) == OK
        for begin, size, end in told:
            number = -(-end // T)  # of the period whose command this is
            assert plant.set({f"a[{i}]": ((number * i) % 7 - 3) / 2 for i in range(1, N + 1)}) == OK
            assert plant.step(begin, size) == OK
            if (end / T).denominator == 1:
                seen[end / T] = plant.group("x")
        return seen

    expected = run(steps_of(counts, 0.0, [T], 40), 0.0)
    for name in MASTERS:
        for pattern in ("1", "1/4", "1/2 1/3 1/6"):
            seen = run([step for step in told_by(name, start, pattern, 120) if step.end <= 40 * T], start)
            assert len(seen) >= 30
            for k, x in seen.items():
                np.testing.assert_allclose(x, expected[k], rtol=0, atol=1e-9)


@pytest.mark.parametrize("start", STARTS)
def test_the_leader_counts_from_the_start(instances, leader_fmu, start):
    wave = Wave(30.0, 14.0, 0.1, 3.0)
    for name in MASTERS:
        leader = instances(leader_fmu)
        assert leader.initialise({"v_high": 30.0, "v_low": 14.0, "begin": 0.1, "period": 3.0}, start) == OK
        for begin, size, end in told_by(name, start, "1", 400):
            assert leader.step(begin, size) == OK
            tolerance = 1e-12 if start == 0.0 else 1e-7 if abs(start) < 1e7 else 1e-3
            assert leader.get("v")[0] == pytest.approx(wave.speed(float(end)), rel=0, abs=tolerance)


@pytest.mark.parametrize("start", [0.0, 1.7e9])
def test_the_time_in_a_sentence_is_the_masters(instances, controller_fmu, start):
    controller = instances(controller_fmu)
    assert controller.initialise(FIXED | {"bad_input": 2} | inputs(0), start) == OK
    assert controller.step(start, 0.02) == OK
    assert controller.set({"v[1]": 99.0}) == OK
    assert controller.step(start + 0.02, 0.01) == OK
    assert f"t = {start + 0.02:.10g} s" in controller.messages[-1][1]
    assert controller.step(start + 0.05, 0.01) == ERROR
