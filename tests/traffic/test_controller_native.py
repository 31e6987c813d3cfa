"""The native controller against the Python one: the same numbers, statuses and sentences whatever happens."""

from __future__ import annotations

from math import inf, nan

import numpy as np
import pytest

from harness import ERROR, OK, WARNING, Instance, random_start
from traffic.controller_lives import LAW, N, T, life

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


def test_lives_without_exp_and_pow_are_the_same_bit_for_bit(python_controller_fmu, native_controller_fmu):
    """V_old needs no power; exp is in lags, and in estimates of accelerations and closing up over time."""
    fixed = {f"actuator_lag[{i}]": 0.0 for i in range(1, N + 1)} | {f"a_known[{i}]": 1.0 for i in range(1, N + 1)}
    fixed |= {"potential": 1, "closing_speed": 0.0}
    for seed in range(30, 40):
        statuses, rows, messages = life(python_controller_fmu, seed, 0.0, True, fixed)
        of_native = life(native_controller_fmu, seed, 0.0, True, fixed)
        assert (of_native[0], of_native[2]) == (statuses, messages)
        np.testing.assert_array_equal(of_native[1], rows)


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
