"""The closed loop under masters whose time drifts, is negative or is a Unix clock's; and long runs in a C host."""

from __future__ import annotations

import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from fmu_src.toolchain.compile import FMI_HEADERS
from harness import ERROR, OK, Instance, Unpacked, random_start, starts
from masters import MASTERS, counts, steps_of, sums
from native.hosting import host_arguments

T = Fraction(1, 100)
PATTERNS = {"T": "1", "T/4": "1/4", "T/3": "1/3", "5 T": "5", "3.7 T": "37/10", "uneven": "1/2 1/3 1/6"}


def instants(fmu: Unpacked, told, start: float, values) -> dict[int, list[float]]:
    """Outputs at the sampling instants, by their number."""
    instance = Instance(fmu)
    assert instance.initialise(values, start) == OK
    seen = {}
    for begin, size, end in told:
        assert instance.step(begin, size) == OK, instance.messages
        if (end / T).denominator == 1:
            seen[int(end / T)] = instance.outputs()
    instance.close()
    return seen


@pytest.mark.parametrize("start", [0.0, 1e6, 1.7e9, -1.7e9])
def test_every_master_at_any_time_sees_the_same_at_the_sampling_instants(either_fmu, start):
    values = starts(*random_start(9)) | {"parameter_source": 2}
    expected = instants(either_fmu, steps_of(counts, 0.0, [T], 60), 0.0, values)
    for master in MASTERS.values():
        for pattern in PATTERNS.values():
            parts = [Fraction(part) * T for part in pattern.split()]
            told = [step for step in steps_of(master, start, parts, 150) if step.end <= 60 * T]
            seen = instants(either_fmu, told, start, values)
            assert len(seen) >= 1
            for k, outputs in seen.items():
                np.testing.assert_allclose(outputs, expected[k], rtol=0, atol=1e-9)


@pytest.mark.parametrize("start", [1.7e9, -1.7e9])
def test_a_saved_state_keeps_the_clock(either_fmu, start):
    told = steps_of(MASTERS["t += h, differences"], start, [T / 4], 200)
    instance, other = Instance(either_fmu), Instance(either_fmu)
    for one in (instance, other):
        assert one.initialise({"parameter_source": 2}, start) == OK

    def drive(one, steps):
        rows = []
        for begin, size, _ in steps:
            assert one.step(begin, size) == OK
            rows.append(one.outputs())
        return rows

    drive(instance, told[:102])
    state = instance.slave.getFMUState()
    data = instance.slave.serializeFMUstate(state)
    rows = drive(instance, told[102:])
    instance.slave.setFMUState(state)
    assert drive(instance, told[102:]) == rows
    other.slave.setFMUState(other.slave.deSerializeFMUstate(data))
    assert drive(other, told[102:]) == rows
    instance.close()
    other.close()


@pytest.mark.parametrize("start", [0.0, 1e6, 1.7e9])
@pytest.mark.parametrize("h", [0.0025, 0.01, 0.001])
def test_drift_is_no_jump_and_does_not_pass_stop_time(either_fmu, start, h):
    """At 1.7e9 s, sums of 0.0025 s run ahead by 5.7e-8 s in every step."""
    count = 1500
    instance = Instance(either_fmu)
    assert instance.call("fmi2SetupExperiment", 0, 0.0, start, 1, start + count * h) == OK
    assert instance.set({"parameter_source": 2}) == OK
    assert instance.call("fmi2EnterInitializationMode") == OK
    assert instance.call("fmi2ExitInitializationMode") == OK
    for begin, size, _ in steps_of(sums, start, [Fraction(str(h))], count):
        assert instance.step(begin, size) == OK, instance.messages
    assert instance.step(begin + size, h) == ERROR
    assert "stopTime" in instance.messages[-1][1]
    instance.close()


@pytest.mark.parametrize("start", [0.0, 1e6, 1.7e9, -1.7e9])
@pytest.mark.parametrize("h", [0.01, 0.001])
@pytest.mark.parametrize("jump", [1.0, -1.0, 0.3])
def test_a_jump_of_time_is_refused_at_any_time(either_fmu, start, h, jump):
    instance = Instance(either_fmu)
    assert instance.initialise({"parameter_source": 2}, start) == OK
    assert instance.step(start, h) == OK
    assert instance.step(start + h + jump * h, h) == ERROR
    assert "but the FMU is at" in instance.messages[-1][1]
    instance.close()


@pytest.fixture(scope="module")
def day_host(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """day_host.c, compiled."""
    host = tmp_path_factory.mktemp("day") / "day_host"
    source = Path(__file__).parent / "day_host.c"
    command = [sys.executable, "-m", "ziglang", "cc", "-O2", "-std=gnu11", "-Wall", "-Wextra", "-Werror"]
    subprocess.run([*command, "-I", str(FMI_HEADERS), "-o", str(host), str(source), "-ldl"], check=True)
    return host


# T is nowhere certified, and every sampling instant is counted; or the inputs never are in order
PLATOON = {"parameter_source": 2, "lemma1_policy": 2, "v_max": 1e6, "n_start": 2}
CONTROLLER = {"parameter_source": 2, "bad_input": 2, "n_active": 0}


@pytest.mark.parametrize(
    ("fmu", "values", "counter", "given", "start", "kind", "steps"),
    [
        ("native_fmu", PLATOON, "lemma1_violations", None, 0.0, 0, 8_640_000),
        ("native_fmu", PLATOON, "lemma1_violations", None, 1.7e9, 0, 1_000_000),
        ("native_fmu", PLATOON, "lemma1_violations", None, 1.7e9, 1, 1_000_000),
        ("native_controller_fmu", CONTROLLER, "input_faults", "n_active", 0.0, 0, 1_000_000),
        ("native_controller_fmu", CONTROLLER, "input_faults", "n_active", 1.7e9, 0, 300_000),
        ("native_controller_fmu", CONTROLLER, "input_faults", "n_active", 1.7e9, 1, 300_000),
    ],
)
def test_long_runs_meet_every_instant(request, day_host, fmu, values, counter, given, start, kind, steps):
    unpacked = request.getfixturevalue(fmu)
    library, resources, guid, *_ = host_arguments(unpacked, 0.01, steps)
    given_reference = -1 if given is None else unpacked.reference[given]
    words = [library, resources, guid, repr(start), "0.01", str(steps), str(kind), str(unpacked.reference[counter])]
    words.append(str(given_reference))
    for name, value in values.items():
        words += ["i" if name in unpacked.integer else "r", str(unpacked.reference[name]), repr(value)]
    ran = subprocess.run([str(day_host), *words], capture_output=True, text=True, timeout=300, check=False)
    assert (ran.returncode, ran.stderr, ran.stdout.strip()) == (0, "", "0")
