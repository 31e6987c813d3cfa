"""Saving, restoring and serialising the whole state; reset."""

from __future__ import annotations

import pytest
from fmpy.fmi2 import fmi2FMUstate

from harness import ERROR, OK, run


@pytest.mark.parametrize("values", [{}, {"potential": 1}, {"parameter_source": 2, "lemma1_policy": 3}], ids=str)
def test_a_restored_state_has_the_identical_future(instance, values):
    assert instance.initialise(values) == OK
    run(instance, 0, 37, 0.0033)  # between two sampling instants
    state = instance.slave.getFMUstate()
    first = run(instance, 37, 50, 0.0033)
    instance.slave.setFMUstate(state)
    assert run(instance, 37, 50, 0.0033) == first
    instance.slave.freeFMUstate(state)


def test_a_serialised_state_moves_to_another_instance_bit_for_bit(instances):
    source, target = instances(), instances()
    assert source.initialise({"x_start": 1 / 3, "potential": 1}) == OK
    run(source, 0, 25)
    state = source.slave.getFMUstate()
    data = source.slave.serializeFMUstate(state)
    expected = run(source, 25, 60)
    target.slave.setFMUstate(target.slave.deSerializeFMUstate(data))
    assert run(target, 25, 60) == expected


def test_states_of_one_instance_do_not_disturb_each_other(instance):
    assert instance.initialise() == OK
    run(instance, 0, 5)
    early, at_early = instance.slave.getFMUstate(), instance.outputs()
    run(instance, 5, 5)
    late, at_late = instance.slave.getFMUstate(), instance.outputs()
    for state, outputs in ((early, at_early), (late, at_late), (early, at_early)):
        instance.slave.setFMUstate(state)
        assert instance.outputs() == outputs


def flipped(data: bytes) -> bytes:
    """One bit of the data changed."""
    return data[:99] + bytes([data[99] ^ 1]) + data[100:]


@pytest.mark.parametrize(
    "damage", [lambda data: data[:-1], lambda data: data[:40], flipped], ids=["cut", "head", "bit"]
)
def test_a_damaged_state_is_refused_and_the_instance_goes_on(instances, damage):
    instance, other = instances(), instances()
    assert instance.initialise() == OK
    data = instance.slave.serializeFMUstate(instance.slave.getFMUstate())
    bad = damage(data)
    state = fmi2FMUstate()
    statuses = [other.call("fmi2DeSerializeFMUstate", bad, len(bad), state)]
    if statuses[0] == OK:
        statuses.append(other.call("fmi2SetFMUstate", state))
    assert max(statuses) == ERROR
    assert "state" in other.messages[-1][1] and len(other.messages) == 1
    assert other.call("fmi2Reset") == OK
    assert other.initialise() == OK


def test_a_state_of_another_fmu_is_refused(instances, fmu_of_three):
    three, seven = instances(fmu_of_three), instances()
    assert three.initialise() == OK
    data = three.slave.serializeFMUstate(three.slave.getFMUstate())
    state = fmi2FMUstate()
    statuses = [seven.call("fmi2DeSerializeFMUstate", data, len(data), state)]
    if statuses[0] == OK:
        statuses.append(seven.call("fmi2SetFMUstate", state))
    assert max(statuses) == ERROR
    assert "another" in seven.messages[-1][1]


def test_reset_gives_back_the_start_values(instances):
    used, fresh = instances(), instances()
    assert used.initialise({"mu": 0.9, "x_start": 100.0, "potential": 1}) == OK
    run(used, 0, 30)
    assert used.call("fmi2Reset") == OK
    for instance in (used, fresh):
        assert instance.initialise() == OK
    assert run(used, 0, 30) == run(fresh, 0, 30)
