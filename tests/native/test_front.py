"""The FMI 2.0 front of both FMUs: call order, arguments, handles, logging, saved states."""

from __future__ import annotations

from ctypes import byref, c_char, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p, create_string_buffer

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from harness import DISCARD, ERROR, OK, Instance, random_start, starts

ALLOWED = {  # FMI 2.0.1, section 4.2.4: where each function may be called; * stands for every state
    "fmi2SetupExperiment": "instantiated",
    "fmi2EnterInitializationMode": "instantiated",
    "fmi2ExitInitializationMode": "initialization",
    "fmi2DoStep": "stepped",
    "fmi2Terminate": "stepped",
    "fmi2GetReal": "initialization stepped terminated error",
    "fmi2SetReal": "instantiated initialization stepped",
    "fmi2Reset": "*",
    "fmi2CancelStep": "",
}
STATES = ("instantiated", "initialization", "stepped", "terminated", "error")


def _bring_to(instance: Instance, state: str) -> None:
    if state == "instantiated":
        return
    assert instance.call("fmi2SetupExperiment", 0, 0.0, 0.0, 0, 0.0) == OK
    assert instance.call("fmi2EnterInitializationMode") == OK
    if state == "initialization":
        return
    assert instance.call("fmi2ExitInitializationMode") == OK
    if state == "terminated":
        assert instance.call("fmi2Terminate") == OK
    if state == "error":
        assert instance.step(0.0, -1.0) == ERROR


def _call(instance: Instance, function: str) -> int:
    value, reference = c_double(0.0), c_uint(instance.fmu.reference["x_start"])
    if function == "fmi2SetupExperiment":
        return instance.call(function, 0, 0.0, 0.0, 0, 0.0)
    if function == "fmi2DoStep":
        return instance.step(0.0, 0.01)
    if function in ("fmi2GetReal", "fmi2SetReal"):
        return instance.call(function, byref(reference), 0, byref(value))
    return instance.call(function)


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("function", ALLOWED)
def test_functions_are_refused_where_the_standard_does_not_allow_them(instance, function, state):
    _bring_to(instance, state)
    instance.messages.clear()
    status = _call(instance, function)
    if ALLOWED[function] == "*" or state in ALLOWED[function].split():
        assert status == OK
    else:
        assert status == ERROR
        if state == "error" and function == "fmi2Terminate":  # only cleans up: the error has been told
            assert instance.messages == []
        else:
            ((_, text),) = instance.messages
            assert function in text and "call" in text
        assert instance.call("fmi2Reset") == OK and instance.initialise({"parameter_source": 2}) == OK


def test_a_call_out_of_order_changes_nothing(instance):
    assert instance.call("fmi2GetReal", byref(c_uint(0)), 1, byref(c_double())) == ERROR
    assert instance.step(0.0, 0.01) == ERROR
    assert instance.initialise({"parameter_source": 2}) == OK
    assert instance.call("fmi2SetupExperiment", 0, 0.0, 0.0, 0, 0.0) == ERROR
    assert instance.step(0.0, 0.01) == OK


def test_null_pointers_are_refused_and_a_null_instance_too(instance):
    _bring_to(instance, "stepped")
    assert instance.call("fmi2GetReal", None, 1, None) == ERROR
    assert "null pointer" in instance.messages[-1][1]
    assert instance.call("fmi2Reset") == OK
    assert instance.call("fmi2SerializedFMUstateSize", c_void_p(12345), byref(c_size_t())) == ERROR
    assert "not one of this instance" in instance.messages[-1][1]
    assert instance.slave.dll.fmi2DoStep(None, c_double(0), c_double(1), 0) == ERROR


def test_unknown_references_and_wrong_types_are_refused(instance):
    _bring_to(instance, "stepped")
    for reference in (10**6, instance.fmu.reference["potential"]):
        assert instance.call("fmi2GetReal", byref(c_uint(reference)), 1, byref(c_double())) == ERROR
        assert f"value reference {reference} " in instance.messages[-1][1]
    assert instance.call("fmi2GetBoolean", byref(c_uint(0)), 1, byref(c_int())) == ERROR


def test_parameters_are_fixed_after_initialisation_and_outputs_cannot_be_set(instance):
    _bring_to(instance, "stepped")
    assert instance.set({"mu": 0.7}) == ERROR
    assert "mu is a fixed parameter" in instance.messages[-1][1]
    assert instance.call("fmi2Reset") == OK
    assert instance.set({"J": 1.0}) == ERROR


def test_a_step_must_start_where_the_last_one_ended_and_end_before_stop_time(instance):
    assert instance.call("fmi2SetupExperiment", 0, 0.0, 0.0, 1, 0.1) == OK
    assert instance.call("fmi2EnterInitializationMode") == OK
    assert instance.call("fmi2ExitInitializationMode") == OK
    assert instance.step(0.0, 0.05) == OK
    state = instance.slave.getFMUState()
    assert instance.step(0.07, 0.01) == ERROR
    assert "t = 0.07 s" in instance.messages[-1][1] and "t = 0.05 s" in instance.messages[-1][1]
    instance.slave.setFMUState(state)
    assert instance.step(0.05, 0.06) == ERROR
    assert "stopTime = 0.1 s" in instance.messages[-1][1]
    instance.slave.setFMUState(state)
    assert instance.step(0.05, 0.05) == OK


def test_rounding_errors_in_times_and_steps_of_no_length_are_taken(instance):
    _bring_to(instance, "stepped")
    assert instance.step(0.0, 0.0) == OK
    assert instance.step(1e-12, 0.01) == OK
    assert instance.step(0.01 - 1e-12, 0.01 + 1e-13) == OK


def test_status_inquiries(instance):
    _bring_to(instance, "stepped")
    assert instance.step(0.0, 0.02) == OK
    time, status, flag = c_double(), c_int(9), c_int(9)
    assert instance.call("fmi2GetRealStatus", 2, byref(time)) == OK and time.value == 0.02
    assert instance.call("fmi2GetStatus", 0, byref(status)) == OK and status.value == OK
    assert instance.call("fmi2GetBooleanStatus", 3, byref(flag)) == OK and flag.value == 0
    assert instance.call("fmi2GetIntegerStatus", 0, byref(flag)) == DISCARD
    assert instance.step(0.02, 0.02) == OK  # a question that has no answer harms nothing


def test_log_categories(either_fmu):
    instance = Instance(either_fmu)
    wanted = (c_char_p * 1)(b"logStatusError")
    assert instance.call("fmi2SetDebugLogging", 1, 1, wanted) == OK
    assert instance.initialise({"mu": 0.6}) == OK  # the fallback warns, but warnings were not asked for
    assert instance.messages == []
    assert instance.step(0.0, -1.0) == ERROR and len(instance.messages) == 1
    assert instance.call("fmi2SetDebugLogging", 1, 1, (c_char_p * 1)(b"logWeather")) == OK
    instance.close()


def test_messages_are_text_and_not_formats(instance):
    assert instance.call("fmi2SetDebugLogging", 1, 1, (c_char_p * 1)(b"100%s%n")) == OK
    assert "100%s%n" in instance.messages[-1][1]


@pytest.mark.parametrize("wrong", [{"guid": "{other}"}, {"instanceName": ""}], ids=["another GUID", "no instance name"])
def test_instances_that_cannot_be(either_fmu, wrong):
    instance = Instance(either_fmu)
    slave = instance.slave
    for name, value in wrong.items():
        setattr(slave, name, value)
    with pytest.raises(Exception, match=r"[Ii]nstantiate"):
        slave.instantiate(callbacks=instance.callbacks, loggingOn=True)
    assert instance.messages[-1][0] == ERROR


def test_a_restored_state_goes_on_bit_for_bit_also_in_another_instance(either_fmu):
    one, other = Instance(either_fmu), Instance(either_fmu)
    assert one.initialise(starts(*random_start(3)) | {"parameter_source": 2}) == OK
    assert one.step(0.0, 0.123) == OK
    state = one.slave.getFMUState()
    data = one.slave.serializeFMUState(state)
    assert one.step(0.123, 1.0) == OK
    expected = one.outputs()
    one.slave.setFMUState(state)
    assert one.step(0.123, 1.0) == OK
    assert one.outputs() == expected
    other.slave.setFMUState(other.slave.deserializeFMUState(data))
    assert other.step(0.123, 1.0) == OK
    assert other.outputs() == expected
    one.slave.freeFMUState(state)
    one.close()
    other.close()


def test_a_state_saved_in_initialisation_brings_that_mode_back(instance):
    _bring_to(instance, "initialization")
    state = instance.slave.getFMUState()
    assert instance.call("fmi2ExitInitializationMode") == OK
    assert instance.step(0.0, -1.0) == ERROR
    instance.slave.setFMUState(state)
    assert instance.set({"mu": 0.5}) == OK
    assert instance.call("fmi2ExitInitializationMode") == OK


@pytest.fixture(scope="module")
def serialised(native_fmu):
    """An instance and a state of it as bytes."""
    instance = Instance(native_fmu)
    assert instance.initialise({"parameter_source": 2}) == OK
    yield instance, bytes(instance.slave.serializeFMUState(instance.slave.getFMUState()))
    instance.close()


def _read_back(instance: Instance, data: bytes) -> int:
    buffer, state = (c_char * len(data)).from_buffer_copy(data), c_void_p()
    status = instance.call("fmi2DeSerializeFMUstate", buffer, len(data), byref(state))
    assert (state.value is None) == (status != OK)
    assert instance.call("fmi2Reset") == OK
    return status


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(place=st.floats(0, 1, exclude_max=True), bit=st.integers(0, 7))
def test_a_state_with_one_bit_flipped_is_refused(serialised, place, bit):
    instance, data = serialised
    damaged = bytearray(data)
    damaged[int(place * len(data))] ^= 1 << bit
    assert _read_back(instance, bytes(damaged)) == ERROR


@pytest.mark.parametrize("keep", [1, 7, 79, 80, 500, -1])
def test_a_truncated_state_is_refused(serialised, keep):
    instance, data = serialised
    assert _read_back(instance, data[:keep]) == ERROR
    assert _read_back(instance, data) == OK


def test_a_state_of_another_fmu_is_refused(serialised, native_fmu_of_three):
    other = Instance(native_fmu_of_three)
    assert _read_back(other, serialised[1]) == ERROR
    assert "another FMU" in other.messages[-1][1]
    other.close()


def test_too_small_a_buffer_is_refused(native):
    assert native.initialise({"parameter_source": 2}) == OK
    state = native.slave.getFMUState()
    assert native.call("fmi2SerializeFMUstate", state, create_string_buffer(10), 10) == ERROR
    assert "10 bytes" in native.messages[-1][1]


def test_instances_do_not_disturb_each_other(native_fmu):
    first, second = Instance(native_fmu, "first"), Instance(native_fmu, "second")
    assert first.initialise({"potential": 1}) == OK
    assert first.step(0.0, 1.0) == OK
    expected = first.outputs()
    assert second.initialise({"parameter_source": 2}) == OK
    assert second.step(0.0, 3.0) == OK
    assert first.outputs() == expected
    assert not np.allclose(second.outputs(), expected)
    first.close()
    second.close()


@pytest.mark.parametrize("function", ["fmi2FreeInstance", "fmi2Reset", "fmi2DoStep"])
def test_a_call_from_the_logger_of_a_running_call_is_refused(instance, function):
    """Freeing an instance from its own logger, in the middle of a step, would free it under the step's feet."""
    heard, keep = [], instance._log

    def log(environment, name, status, category, message):
        heard.append(message.decode())
        keep(environment, name, status, category, message)
        arguments = (c_double(0.0), c_double(0.01), c_int(1)) if function == "fmi2DoStep" else ()
        getattr(instance.slave.dll, function)(c_void_p(instance.slave.component), *arguments)

    instance._log = log
    _bring_to(instance, "stepped")
    assert instance.step(0.0, -1.0) == ERROR
    assert len(heard) == 2 and f"{function} was called while another call" in heard[1]
    instance._log = keep
    assert instance.call("fmi2Reset") == OK and instance.initialise({"parameter_source": 2}) == OK
    assert instance.step(0.0, 0.01) == OK
