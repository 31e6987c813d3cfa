"""Saved states of the native controller with commands on their way, and outputs computed where they are read."""

from __future__ import annotations

import numpy as np
import pytest

from harness import OK, Instance, random_start
from traffic.controller_lives import N, T, inputs, read

PREDICTED = {"actuation_delay": 0.2, "max_age": 0.1, "lemma1_policy": 2, "parameter_source": 2}
PREDICTED |= {f"actuator_lag[{i}]": 0.1 * (i % 3) for i in range(1, N + 1)}


def drive(instance: Instance, rng: np.random.Generator, begin: int, end: int) -> list[list[float]]:
    """Outputs over periods with inputs drawn at random, some with another number of vehicles and others that drive."""
    rows = []
    for k in range(begin, end):
        named = inputs(rng, k * T, int(rng.choice([7, 7, 7, 6])))
        instance.set({name: value for name, value in named.items() if name != "n_active" or k % 5 == 0})
        instance.set({"automated[1]": float(k % 20 > 9), "t_measured": -1.0})
        instance.step(k * T, T)
        rows.append(read(instance)[1])
    return rows


def test_a_state_with_commands_on_their_way_goes_on_bit_for_bit_in_another_instance(instances, native_controller_fmu):
    one, other, told = instances(native_controller_fmu), instances(native_controller_fmu), PREDICTED | {"bad_input": 2}
    assert one.initialise(told) == OK
    drive(one, np.random.default_rng(0), 0, 40)
    data = one.slave.serializeFMUState(one.slave.getFMUState())
    expected = drive(one, np.random.default_rng(1), 40, 80)
    assert other.initialise(told) == OK
    drive(other, np.random.default_rng(2), 0, 23)
    other.slave.setFMUState(other.slave.deSerializeFMUstate(data))
    assert drive(other, np.random.default_rng(1), 40, 80) == expected


def test_a_state_holds_the_commands_that_can_be_on_their_way_and_no_more(instances, native_controller_fmu):
    def size(told: dict[str, float]) -> int:
        instance = instances(native_controller_fmu)
        assert instance.initialise(told) == OK
        return len(instance.slave.serializeFMUState(instance.slave.getFMUState()))

    row = 8 * (1 + N)
    nothing = size({"lemma1_policy": 2, "parameter_source": 2})
    assert size(PREDICTED) - nothing == (30 + 2) * row
    assert size(PREDICTED | {"actuation_delay": 4.0}) - nothing == (410 + 2) * row
    assert size(PREDICTED | {"actuation_delay": 5.0}) - nothing == 512 * row
    assert size(PREDICTED | {"actuation_delay": 0.0}) - nothing == (10 + 2) * row


@pytest.mark.parametrize("cut", [8, 64, 8 * (1 + N)])
def test_a_state_without_all_its_commands_is_refused(instances, native_controller_fmu, cut):
    instance = instances(native_controller_fmu)
    assert instance.initialise(PREDICTED) == OK and instance.step(0.0, T) == OK
    data = instance.slave.serializeFMUState(instance.slave.getFMUState())
    with pytest.raises(Exception, match="status 3"):
        instance.slave.deSerializeFMUstate(data[:-cut])


def test_what_is_computed_where_it_is_read_is_the_same_in_any_way_of_reading(instances, native_controller_fmu):
    instance, rng = instances(native_controller_fmu), np.random.default_rng(3)
    assert instance.initialise(PREDICTED | {f"a_min[{i}]": -8.0 for i in range(1, N + 1)}) == OK
    margins = set()
    for k in range(30):
        s, v = random_start(k, N)
        named = {f"s[{i}]": float(spacing) + 10.0 for i, spacing in enumerate(s, start=2)}
        named |= {f"v[{i}]": float(speed) for i, speed in enumerate(v, start=1)}
        assert instance.set(named | {"automated[1]": float(rng.integers(2))}) == OK
        margin, period = instance.get("brake_margin"), instance.get("T_exact")
        assert instance.get("T_exact", "a[1]", "brake_margin")[::2] == [*period, *margin]
        together = instance.outputs()
        assert margin[0] in together and period[0] in together and np.isfinite(together).all()
        assert instance.step(k * T, T) == OK
        assert instance.get("brake_margin") == margin and instance.get("T_exact") == period
        margins.add(margin[0])
    assert len(margins) > 10
