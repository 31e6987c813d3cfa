"""Corners of both FMUs that branch coverage found untouched: policies far into a run, odd arguments, reused states."""

from __future__ import annotations

from ctypes import byref, c_double, c_int, c_uint, c_void_p
from math import inf, nan

import numpy as np
import pytest

from harness import ERROR, OK, WARNING, Instance, Unpacked, random_start, starts

CLOSING = starts([30.0] * 6, [0.0, *[35.0] * 6]) | {"potential": 1}  # V_old, far apart, all towards a standing leader
CLOSE = starts([5.5, *[9.0] * 5], [0.0, *[35.0] * 6]) | {"potential": 1}


def life(fmu: Unpacked, values: dict[str, float], step: float, count: int) -> tuple[list[list[float]], list]:
    """Outputs after each step up to the first error, and all messages."""
    instance = Instance(fmu)
    rows = []
    if instance.initialise(values) <= WARNING:
        rows.append(instance.outputs())
        for k in range(count):
            status = instance.step(k * step, step)
            rows.append(instance.outputs())
            if status > WARNING:
                break
    messages = instance.messages
    instance.close()
    return rows, messages


@pytest.mark.parametrize(
    ("values", "step", "count", "sentence"),
    [
        (CLOSING | {"T": 0.3}, 0.3, 20, "would reach v_max = 35 m/s"),
        (starts([5.5, *[9.0] * 5], [35.0] * 7) | {"potential": 1}, 0.01, 1, "would come to a stop"),
        ({"n_start": 1, "v_start[1]": 0.0, "T": 3.0}, 3.0, 1, "would reach v_max = 35 m/s"),
        (CLOSE | {"T": 0.1, "lemma1_policy": 2}, 0.1, 10, "where the model ends"),
        (CLOSING | {"T": 0.3, "lemma1_policy": 2}, 0.3, 12, "is not below T_max"),
        (CLOSING | {"T": 0.3, "lemma1_policy": 3}, 0.3, 12, None),
        (starts(*random_start(3)) | {"parameter_source": 3, "rollout_count": 1, "rollout_horizon": 0.5}, 0.1, 5, None),
        (starts(*random_start(3)) | {"parameter_source": 3, "rollout_count": 40, "rollout_horizon": 0.5}, 0.1, 5, None),
        (starts(*random_start(3)) | {"T": 1e-18}, 0.1, 1, "more sampling periods"),
        ({"w1": nan}, 0.1, 1, "w1 must be a finite number"),
        ({"alpha_fixed": nan, "parameter_source": 2}, 0.1, 1, "alpha must be a finite number"),
        ({"r_fixed": inf, "parameter_source": 2}, 0.1, 1, "r must be a finite number"),
        ({"z": 5.0}, 0.1, 1, "are used instead of the network's"),
    ],
    ids=[
        "policy 1",
        "too slow",
        "alone",
        "policy 2 to L",
        "policy 2",
        "policy 3",
        "1 rollout",
        "40 rollouts",
        "tiny T",
        "no w1",
        "no alpha",
        "no r",
        "another z",
    ],
)
def test_both_runtimes_do_and_say_the_same(python_fmu, native_fmu, values, step, count, sentence):
    rows, said = life(native_fmu, values, step, count)
    expected, sentences = life(python_fmu, values, step, count)
    assert said == sentences
    assert (sentence is None) == (not said) and (sentence is None or sentence in said[-1][1])
    np.testing.assert_allclose(rows, expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("start", "has_stop", "stop", "word"),
    [(nan, 0, 0.0, "start"), (-inf, 0, 0.0, "start"), (1.0, 1, 0.5, "stop"), (0.0, 1, nan, "stop")],
)
def test_an_experiment_that_makes_no_sense_is_refused(instance, start, has_stop, stop, word):
    assert instance.call("fmi2SetupExperiment", 0, 0.0, start, has_stop, stop) == ERROR
    assert word in instance.messages[-1][1]
    assert instance.call("fmi2Reset") == OK
    assert instance.call("fmi2SetupExperiment", 1, 1e-6, 0.0, 1, 1.0) == OK  # with a tolerance, which we do not need


@pytest.mark.parametrize(("start", "size"), [(nan, 0.01), (inf, 0.01), (0.0, nan), (0.0, inf), (0.0, -0.01)])
def test_a_step_that_makes_no_sense_is_refused(instance, start, size):
    assert instance.initialise({"parameter_source": 2}) == OK
    assert instance.step(start, size) == ERROR and "step" in instance.messages[-1][1]
    assert instance.call("fmi2Reset") == OK and instance.initialise({"parameter_source": 2}) == OK
    assert instance.step(0.0, 0.01) == OK


@pytest.mark.parametrize(("kind", "guid"), [(0, None), (1, b"")], ids=["model exchange", "no GUID"])
def test_what_cannot_be_made_is_a_null_pointer_and_one_sentence(either_fmu, kind, guid):
    instance = Instance(either_fmu)
    instance.messages.clear()
    model, resources = either_fmu.description, (either_fmu.folder / "resources").as_uri().encode()
    made = instance.slave.fmi2Instantiate(
        b"none", kind, model.guid.encode() if guid is None else guid, resources, byref(instance.callbacks), 0, 1
    )
    assert not made
    ((status, sentence),) = instance.messages
    assert status == ERROR and ": " in sentence
    instance.close()


def test_references_of_the_other_type_or_of_nothing_are_refused(instance):
    reals, integers = instance.fmu.reference["mu"], instance.fmu.reference["potential"]
    cases = [("Real", integers), ("Real", 10**6), ("Integer", reals), ("Integer", 10**6)]
    for kind, reference in cases:
        value = c_double(0.5) if kind == "Real" else c_int(1)
        assert instance.call(f"fmi2Set{kind}", byref(c_uint(reference)), 1, byref(value)) == ERROR
        assert f"value reference {reference} " in instance.messages[-1][1]
        assert instance.call("fmi2Reset") == OK
    assert instance.initialise({"parameter_source": 2}) == OK
    assert instance.call("fmi2GetInteger", byref(c_uint(reals)), 1, byref(c_int())) == ERROR


def test_a_saved_state_may_be_overwritten_and_freed_twice_does_nothing(instance):
    assert instance.initialise({"parameter_source": 2}) == OK
    state = c_void_p()
    assert instance.call("fmi2GetFMUstate", byref(state)) == OK
    assert instance.step(0.0, 0.3) == OK
    later = instance.outputs()
    assert instance.call("fmi2GetFMUstate", byref(state)) == OK
    assert instance.step(0.3, 0.3) == OK
    assert instance.call("fmi2SetFMUstate", state) == OK
    assert instance.outputs() == later
    assert instance.call("fmi2FreeFMUstate", byref(state)) == OK and state.value is None
    assert instance.call("fmi2FreeFMUstate", byref(state)) == OK
    assert instance.call("fmi2FreeFMUstate", None) == OK


@pytest.mark.parametrize("function", ["fmi2SetFMUstate", "fmi2FreeFMUstate", "fmi2GetFMUstate"])
def test_a_state_that_is_none_of_ours_is_refused(instance, function):
    assert instance.initialise({"parameter_source": 2}) == OK
    made_up = c_void_p(4096)
    argument = made_up if function == "fmi2SetFMUstate" else byref(made_up)
    assert instance.call(function, argument) == ERROR
    assert "not one of this instance" in instance.messages[-1][1]
    assert instance.call("fmi2Reset") == OK and instance.initialise({"parameter_source": 2}) == OK


@pytest.mark.parametrize(("unknown", "known"), [("mu", "x_start"), ("a[1]", "a[2]"), ("a[1]", "potential")])
def test_derivatives_of_what_is_no_output_or_by_what_is_no_parameter_are_refused(native, unknown, known):
    reference, value = native.fmu.reference, c_double(1.0)
    assert native.call("fmi2SetupExperiment", 0, 0.0, 0.0, 0, 0.0) == OK
    assert native.set({"parameter_source": 2}) == OK
    assert native.call("fmi2EnterInitializationMode") == OK
    places = byref(c_uint(reference[unknown])), 1, byref(c_uint(reference[known])), 1
    assert native.call("fmi2GetDirectionalDerivative", *places, byref(value), byref(c_double())) == ERROR
    assert "derivative" in native.messages[-1][1]
