"""The native controller against the Python one: the same numbers, statuses and sentences whatever happens."""

from __future__ import annotations

from ctypes import c_double, c_uint
from math import inf, nan

import numpy as np
import pytest

from harness import ERROR, OK, WARNING, Instance, Unpacked, random_start

T, N = 0.01, 7
BAD_VALUES = (nan, inf, -inf, -1.0, -0.01, 0.0, 4.9, 5.0, 35.001, 1e300)
LAW = {
    "kappa": (0.0, 1.0),
    "kappa_reach": (30.0, 12.0),
    "time_gap": (0.0, 0.6),
    "feedforward": (1.0, 0.8),
    "closing_speed": (0.0, 0.6),
    "closing_spacing": (15.0, 9.0),
    "closing_reach": (100.0, 40.0),
    "error_s": (0.0, 0.1),
    "error_v": (0.0, 0.2),
}
BAD_LAW = [
    *({name: value} for name in LAW for value in (nan, inf)),
    *({name: -0.1} for name in ("kappa", "time_gap", "feedforward", "closing_speed", "error_s", "error_v")),
    *({"feedforward": 1.1}, {"closing_reach": 15.0}, {"kappa": 1.0, "kappa_reach": 5.0}, {"following": 3}),
    *({"length[2]": value} for value in (nan, -1.0, inf)),
    *({"actuator_lag[7]": value} for value in (nan, -0.1, inf)),
    *({"actuation_delay": value} for value in (nan, inf, -0.1, 5.2, 1e4)),
    {"actuation_delay": 0.5, "T": 1e-4},
    *({"certificate": value} for value in (0, 3)),
]
BAD_PARAMETERS = [
    *({name: value} for name in ("a_max[3]", "T", "L") for value in (nan, 0.0, inf)),
    *({name: nan} for name in ("a_min[1]", "a_safe", "max_age", "phase", "p_fixed")),
    *({name: value} for name in ("lemma1_policy", "bad_input", "potential", "parameter_source") for value in (0, 4)),
    *({"a_min[7]": 0.0}, {"a_min[2]": -inf}, {"a_safe": 0.5}, {"a_safe": -2000.0}, {"max_age": 0.0}),
    *({"a_min[4]": -1.0, "a_safe": -2.0}, {"a_min[4]": 1.0, "a_min[5]": -1.0}, {"a_safe": 0.5, "a_min[1]": 1.0}),
    *({"phase": T}, {"phase": -T}, {"rollout_count": 0}, {"rollout_horizon": 0.0}),
    *({"p_fixed": 9.0}, {"alpha_fixed": 1.0}, {"r_fixed": 4.0}, {"w1": -1.0}, {"lambda": 7.0}),
    *BAD_LAW,
]


def settings(rng: np.random.Generator) -> dict[str, float]:
    """Parameters drawn at random, all of them good."""
    chosen = {
        "potential": int(rng.integers(1, 3)),
        "parameter_source": int(rng.integers(1, 4)),
        "rollout_horizon": 0.3,
        "lemma1_policy": int(rng.integers(1, 3)),
        "bad_input": int(rng.integers(1, 3)),
        "certificate": int(rng.integers(1, 3)),
        "a_safe": float(rng.uniform(-3.0, 0.0)),
        "max_age": float(rng.choice([1e9, 0.035])),
        "phase": float(rng.choice([0.0, 0.5 * T, 0.3 * T])),
    }
    for i in range(1, N + 1):
        chosen[f"a_min[{i}]"] = float(rng.choice([-1000.0, -8.0, -3.0]))
        chosen[f"a_max[{i}]"] = float(rng.choice([1000.0, 4.0, 1.5]))
    return chosen


def road_settings(rng: np.random.Generator) -> dict[str, float]:
    """Parameters of real vehicles drawn at random, all of them good, most of them off."""
    chosen = {name: float(rng.choice([off, off, value])) for name, (off, value) in LAW.items()}
    chosen |= {"following": int(rng.choice([1, 1, 2])), "lemma1_policy": 2, "max_age": float(rng.choice([1e9, 0.05]))}
    chosen["actuation_delay"] = float(rng.choice([0.0, 0.5, 1.0, 3.7, 20.0])) * T
    lags = (np.zeros(N), np.full(N, 0.2), rng.choice([0.0, 0.1, 0.3], N))[rng.integers(3)]
    lengths = (np.zeros(N), rng.choice([0.0, 4.0, 5.0, 8.0], N))[rng.integers(2)]
    for i in range(1, N + 1):
        chosen |= {f"actuator_lag[{i}]": float(lags[i - 1]), f"length[{i}]": float(lengths[i - 1])}
    return chosen


def inputs(rng: np.random.Generator, time: float, n: int | None = None) -> dict[str, float]:
    """Gaps, speeds and the other inputs: from the training domain, from all of the state space, or bad ones."""
    n = int(rng.choice([1, 2, 4, 6, 7, 7, 7])) if n is None else n
    if rng.random() < 0.5:
        s, v = random_start(int(rng.integers(1000)), n) if n > 1 else ([], [30.0])
    else:
        s, v = rng.uniform(5.01, 25.0, n - 1), rng.uniform(0.0, 35.0, n)
    named = {f"s[{i}]": float(gap) for i, gap in enumerate(s, start=2)}
    named |= {f"v[{i}]": float(speed) for i, speed in enumerate(v, start=1)}
    named |= {"n_active": float(n), "resolve": float(rng.integers(2)), "t_measured": float(rng.choice([-1.0, time]))}
    named["v_desired"] = float(rng.choice([-1.0, rng.uniform(0.0, 35.0), 0.0, 35.0, -1e-9, 35.0 + 1e-9, 1e-300]))
    for name, bound in (("s[2]", 5.0), ("s[3]", 5.0), ("v[1]", 0.0), ("v[2]", 35.0)):
        if name in named and rng.random() < 0.1:
            named[name] = bound + float(rng.choice([0.0, -1e-15, 1e-12, -1e-9, 1e-7, -1e-7]))
    if rng.random() < 0.1:
        named[str(rng.choice(list(named)))] = float(rng.choice(BAD_VALUES))
    return named


def road_inputs(rng: np.random.Generator, time: float) -> dict[str, float]:
    """Inputs on a road: older ones, few of them bad, a vehicle more or less now and then, and who drives himself."""
    named = inputs(rng, time, int(rng.choice([1, 5, 6, 6, 7, 7, 7, 7])))
    named["t_measured"] = float(rng.choice([-1.0, time, time - 0.013, time - 0.05]))
    named["a_desired"] = float(rng.choice([0.0, 0.0, rng.normal()]))
    driving = (np.ones(N), np.array([0.0] + [1.0] * (N - 1)), rng.choice([0.0, 1.0, 0.5, 0.7], N))[rng.integers(3)]
    for i in range(1, N + 1):
        named[f"automated[{i}]"] = float(driving[i - 1])
        named[f"a_measured[{i}]"] = float(rng.normal(0.0, 2.0))
        named[f"a_known[{i}]"] = float(rng.choice([1.0, 1.0, 0.0]))
    if rng.random() < 0.05:
        named[str(rng.choice(list(named)))] = float(rng.choice(BAD_VALUES))
    return named


def read(instance: Instance) -> tuple[int, list[float]]:
    """Status and values of all outputs."""
    names = [v.name for v in instance.fmu.description.modelVariables if v.causality == "output"]
    references = (c_uint * len(names))(*(instance.fmu.reference[name] for name in names))
    values = (c_double * len(names))()
    return instance.call("fmi2GetReal", references, len(names), values), list(values)


def life(
    fmu: Unpacked, seed: int, start_time: float = 0.0, road: bool = False
) -> tuple[list[int], np.ndarray, list[tuple[int, str]]]:
    """Statuses, outputs and messages of an instance that is driven at random and reset after errors."""
    rng, instance = np.random.default_rng(seed), Instance(fmu)
    told = road_inputs if road else inputs
    statuses, rows, time = [], [], None
    for _ in range(60):
        if time is None:
            time = start_time
            chosen = settings(rng) | (road_settings(rng) if road else {})
            statuses.append(instance.initialise(chosen | told(rng, time), start_time))
        if rng.random() < 0.7:
            statuses.append(instance.set(told(rng, time)))
        if rng.random() < 0.6 and statuses[-1] <= WARNING:
            status, values = read(instance)
            statuses.append(status)
            if status <= WARNING:
                rows.append(values)
        size = T * float(rng.choice([1.0, 1.0, 1.0, 0.25, 0.4, 2.5, 0.0]))
        statuses.append(instance.step(time, size) if statuses[-1] <= WARNING else ERROR)
        time += size
        if statuses[-1] > WARNING:
            assert instance.call("fmi2Reset") == OK
            time = None
    messages = instance.messages
    instance.close()
    return statuses, np.array(rows), messages


@pytest.mark.parametrize("start_time", [0.0, -7.25])
def test_random_lives_are_the_same(python_controller_fmu, native_controller_fmu, start_time):
    seen, warned, by_network = list[int](), 0, 0.0
    for seed in range(12):
        statuses, rows, messages = life(python_controller_fmu, seed, start_time)
        statuses_of_native, rows_of_native, messages_of_native = life(native_controller_fmu, seed, start_time)
        assert statuses_of_native == statuses
        assert messages_of_native == messages
        np.testing.assert_allclose(rows_of_native, rows, rtol=0, atol=1e-12)
        seen += statuses
        warned += sum(status == WARNING for status, _ in messages)
        by_network += rows[:, 2 * N + 3].sum()
    assert min(seen.count(status) for status in (OK, ERROR)) > 10 and warned > 10 and by_network > 20


@pytest.mark.parametrize("seed", range(24))
def test_random_lives_of_real_vehicles_are_the_same(python_controller_fmu, native_controller_fmu, seed):
    statuses, rows, messages = life(python_controller_fmu, seed, 0.0, road=True)
    statuses_of_native, rows_of_native, messages_of_native = life(native_controller_fmu, seed, 0.0, road=True)
    assert statuses_of_native == statuses
    assert messages_of_native == messages
    np.testing.assert_allclose(rows_of_native, rows, rtol=0, atol=1e-9)


def test_every_bad_parameter_is_refused_in_the_same_words(python_controller_fmu, native_controller_fmu):
    said = []
    for fmu in (python_controller_fmu, native_controller_fmu):
        instance = Instance(fmu)
        for values in BAD_PARAMETERS:
            assert instance.initialise(values) == ERROR, values
            assert instance.call("fmi2Reset") == OK
        said.append(instance.messages)
        instance.close()
    assert said[1] == said[0] and len(said[0]) == len(BAD_PARAMETERS)


def test_after_an_error_and_a_reset_it_is_as_new(instances, native_controller_fmu):
    values = {f"v[{i}]": speed for i, speed in enumerate(random_start(3)[1], start=1)}
    fresh, used = instances(native_controller_fmu), instances(native_controller_fmu)
    assert used.initialise({"potential": 1, "phase": 0.5 * T} | values) == OK
    assert used.step(0.0, T) == OK and used.set({"v[3]": nan}) == OK and used.step(T, T) == ERROR
    assert used.call("fmi2Reset") == OK
    for instance in (fresh, used):
        assert instance.initialise() == OK and instance.step(0.0, 2 * T) == OK
    assert used.outputs() == fresh.outputs()


def test_the_variables_are_the_same(python_controller_fmu, native_controller_fmu):
    def rows(fmu):
        return [
            (v.name, v.valueReference, v.type, v.causality, v.variability, v.initial, v.start, v.unit, v.min, v.max)
            for v in fmu.description.modelVariables
        ]

    assert rows(native_controller_fmu) == rows(python_controller_fmu)


def test_a_state_of_another_instance_that_was_cut_or_changed_is_refused(instances, native_controller_fmu):
    one, other = instances(native_controller_fmu), instances(native_controller_fmu)
    assert one.initialise() == OK and one.step(0.0, 3 * T) == OK
    data = one.slave.serializeFMUstate(one.slave.getFMUstate())
    for damaged in (data[:-1], data[: len(data) // 2], data[:200] + bytes([data[200] ^ 4]) + data[201:]):
        with pytest.raises(Exception, match="status 3"):
            other.slave.deSerializeFMUstate(damaged)
        assert other.call("fmi2Reset") == OK
    other.slave.setFMUstate(other.slave.deSerializeFMUstate(data))
    assert other.outputs() == one.outputs()
