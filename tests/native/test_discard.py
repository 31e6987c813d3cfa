"""A step of which only a part could be computed: fmi2Discard, how far it came, and that it can be done again."""

from __future__ import annotations

from ctypes import byref, c_double, c_int
from math import nan

import numpy as np
import pytest

from harness import DISCARD, ERROR, OK, Instance, Unpacked, random_start, starts

T = 0.01
OPENING = starts([20.0] * 6, [0.0, *[35.0] * 6]) | {"potential": 1}  # V_old: a few instants are certified, then none is
CASES = {
    "policy 1": OPENING | {"T": 0.1},
    "policy 2 to L": starts([6.5, *[9.0] * 5], [0.0, *[35.0] * 6]) | {"potential": 1, "T": 0.06, "lemma1_policy": 2},
    "short periods": starts([5.001] * 6, [30.0] * 7) | {"potential": 1, "lemma1_policy": 3, "max_short_periods": 9},
}


def reached(instance: Instance) -> float:
    """The last successful time [s]."""
    time = c_double()
    assert instance.call("fmi2GetRealStatus", 2, byref(time)) == OK
    return time.value


@pytest.fixture(scope="module")
def python_controller_fmu(tmp_path_factory) -> Unpacked:
    from native.conftest import built

    return built("python", 7, tmp_path_factory.mktemp("python_controller"), "controller")


@pytest.fixture(params=["native", "python"])
def controller(request):
    instance = Instance(request.getfixturevalue(f"{request.param}_controller_fmu"))
    yield instance
    instance.close()


def _same_step_again(instance: Instance, begin: float, state) -> list[float]:
    """A discarded step from `begin` with length 2 s, and a step to where it came: the same outputs."""
    assert instance.step(begin, 2.0) == DISCARD
    came, seen = reached(instance), instance.outputs()
    assert begin < came < begin + 2.0
    value = c_int(9)
    assert instance.call("fmi2GetStatus", 0, byref(value)) == OK and value.value == DISCARD
    assert instance.call("fmi2GetBooleanStatus", 3, byref(value)) == OK and value.value == 0
    assert instance.step(came, T) == ERROR  # the standard wants fmi2SetFMUstate before
    assert "step failed" in instance.messages[-1][1] and "fmi2SetFMUstate" in instance.messages[-1][1]
    instance.slave.setFMUState(state)
    assert instance.step(begin, came - begin) == OK and reached(instance) == came
    np.testing.assert_allclose(instance.outputs(), seen, rtol=0, atol=1e-12)
    return seen


@pytest.mark.parametrize("start_time", [0.0, -3.5])
@pytest.mark.parametrize("case", CASES)
def test_a_platoon_comes_as_far_as_it_can(instance, case, start_time):
    assert instance.initialise(CASES[case], start_time) == OK
    state = instance.slave.getFMUState()
    _same_step_again(instance, start_time, state)
    discards = [text for status, text in instance.messages if status == DISCARD]
    assert len(discards) == 1 and ":" in discards[0]
    came = reached(instance)
    status = instance.step(came, 10 * T) if case == "policy 2 to L" else instance.step(came, 0.1)
    assert status in (ERROR, DISCARD)  # the instant behind it is refused whatever the step


@pytest.mark.parametrize("case", CASES)
def test_both_runtimes_come_as_far_and_say_the_same(python_fmu, native_fmu, case):
    seen = []
    for fmu in (python_fmu, native_fmu):
        instance = Instance(fmu)
        assert instance.initialise(CASES[case]) == OK
        assert instance.step(0.0, 2.0) == DISCARD
        seen.append((reached(instance), instance.messages, instance.outputs()))
        assert instance.call("fmi2Terminate") == OK and instance.outputs() == seen[-1][2]
        instance.close()
    assert seen[0][:2] == seen[1][:2]
    np.testing.assert_allclose(seen[0][2], seen[1][2], rtol=0, atol=1e-9)


def test_a_refusal_at_the_first_instant_of_a_step_is_an_error(instance):
    assert instance.initialise(CASES["policy 1"]) == OK
    k = 0
    while (status := instance.step(k * 0.1, 0.1)) == OK:
        k += 1
    assert k > 0 and status == ERROR
    assert instance.get("lemma1_ok") == [0.0]  # the outputs show what was refused
    assert instance.call("fmi2Reset") == OK
    assert instance.initialise(CASES["policy 1"]) == OK
    assert instance.step(0.0, 2.0) == DISCARD and reached(instance) == pytest.approx((k - 0) * 0.1)


def test_without_debug_logging_a_discarded_step_is_silent(either_fmu):
    instance = Instance(either_fmu, logging=False)
    assert instance.initialise(CASES["policy 1"]) == OK
    assert instance.step(0.0, 2.0) == DISCARD and instance.messages == []
    instance.close()


def test_a_controller_comes_to_the_instant_at_which_its_inputs_are_stale(controller):
    s, v = random_start(8)
    inputs = {f"s[{i}]": spacing for i, spacing in enumerate(s, start=2)} | {
        f"v[{i}]": v_i for i, v_i in enumerate(v, start=1)
    }
    assert controller.initialise({"parameter_source": 2, "max_age": 0.035} | inputs, 1.0) == OK
    state = controller.slave.getFMUState()
    seen = _same_step_again(controller, 1.0, state)
    assert reached(controller) == pytest.approx(1.04) and seen[0] != 0.0
    assert controller.set(inputs) == OK and controller.step(reached(controller), T) == OK  # newer inputs: it goes on
    assert controller.set({"v[3]": nan}) == OK and controller.step(reached(controller), T) == ERROR
