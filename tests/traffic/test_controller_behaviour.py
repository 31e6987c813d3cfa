"""What the controller FMU does with time, with joining vehicles, with bounds and with bad inputs."""

from __future__ import annotations

from math import nan
from pathlib import Path

import numpy as np
import pytest

from harness import ERROR, OK, WARNING, random_start, starts
from psp_model import BEST_FIXED, PlatoonParameters, feedback, project
from psp_model.selection.network import ParameterNetwork

T, N = 0.01, 7
FIXED = {"parameter_source": 2}
SAFE = FIXED | {"bad_input": 2, "a_safe": -3.0}


def named(s, v) -> dict[str, float]:
    spacings = {f"s[{i}]": spacing for i, spacing in enumerate(s, start=2)}
    return spacings | {f"v[{i}]": speed for i, speed in enumerate(v, start=1)}


def law(s, v) -> np.ndarray:
    return feedback(np.array(s), np.array(v), BEST_FIXED, PlatoonParameters())


@pytest.fixture
def controller(instances, controller_fmu):
    return instances(controller_fmu)


def test_commands_are_held_between_sampling_instants(controller):
    (s, v), (s2, v2) = random_start(1), random_start(2)
    assert controller.initialise(FIXED | named(s, v)) == OK
    np.testing.assert_allclose(controller.group("a"), law(s, v), atol=1e-12)
    assert controller.step(0.0, 0.4 * T) == OK
    assert controller.set(named(s2, v2)) == OK
    np.testing.assert_allclose(controller.group("a"), law(s, v), atol=1e-12)
    assert controller.step(0.4 * T, 0.6 * T) == OK  # the instant T comes only with the next step
    np.testing.assert_allclose(controller.group("a"), law(s, v), atol=1e-12)
    assert controller.step(T, 0.5 * T) == OK
    np.testing.assert_allclose(controller.group("a"), law(s2, v2), atol=1e-12)


def test_at_an_instant_outputs_follow_the_inputs_set_there_and_reading_changes_nothing(controller):
    (s, v), (s2, v2), (s3, v3) = (random_start(k) for k in (1, 2, 3))
    assert controller.initialise(FIXED | named(s, v)) == OK
    assert controller.step(0.0, T) == OK
    for s_now, v_now in ((s2, v2), (s3, v3), (s2, v2)):
        assert controller.set(named(s_now, v_now)) == OK
        for _ in range(2):
            np.testing.assert_allclose(controller.group("a"), law(s_now, v_now), atol=1e-12)
    assert controller.step(T, 0.0) == OK
    assert controller.set(named(s3, v3)) == OK
    assert controller.step(T, T) == OK
    np.testing.assert_allclose(controller.group("a"), law(s3, v3), atol=1e-12)


def test_parameters_are_chosen_anew_when_vehicles_join_or_resolve_rises(controller):
    s, v = random_start(4)
    assert controller.initialise(named(s, v)) == OK
    first = controller.get("r", "choices", "network_in_domain")
    assert first[1:] == [1.0, 1.0]
    s2, v2 = random_start(5)
    inputs = [{}, {"resolve": 1.0}, {"resolve": 1.0}, {"resolve": 0.0}, {"resolve": 1.0}, {"n_active": 6.0}, {}]
    counts = []
    for k, given in enumerate(inputs):
        assert controller.set(named(s2, v2) | given) == OK
        assert controller.step(k * T, T) <= WARNING
        counts.append(controller.get("choices")[0])
    assert np.diff([1.0, *counts]).tolist() == [0, 1, 0, 0, 1, 1, 0]
    network = ParameterNetwork(Path(__file__).parents[2] / "onnx" / "platoon_any.onnx")
    expected = project(network.evaluate(s2[:5], v2[:6]), PlatoonParameters())
    assert controller.get("network_in_domain") == [1.0]
    np.testing.assert_allclose(controller.get("alpha", "r", "p"), [expected.alpha, expected.r, expected.p], rtol=1e-9)


@pytest.mark.parametrize("asked", [{}, FIXED, {"potential": 1}, {"parameter_source": 3, "rollout_horizon": 1.0}])
def test_network_in_domain_says_where_the_vehicles_are_whatever_is_asked_for(controller, platoon_fmu, instances, asked):
    s, v = random_start(6)
    far = [spacing + 20.0 for spacing in s]
    for spacings, more, expected in [
        (s, {}, 1.0),
        (far, {}, 0.0),
        (s, {"mu": 0.6}, 0.0),  # not what the network was trained with
        (s, {"n_active": 4.0}, 1.0),
        (s, {"n_active": 1.0}, 0.0),
    ]:
        assert controller.initialise(named(spacings, v) | asked | more) == OK
        assert controller.get("network_in_domain") == [expected], more
        assert controller.step(0.0, T) == OK and controller.set(named(s, v)) == OK and controller.step(T, T) == OK
        assert controller.get("network_in_domain") == [expected]  # until alpha, r, p are chosen anew
        assert controller.call("fmi2Reset") == OK
        platoon = instances(platoon_fmu)
        begin = {
            "n_start" if name == "n_active" else name: int(x) if name == "n_active" else x for name, x in more.items()
        }
        assert platoon.initialise(starts(spacings, v) | begin | asked) == OK
        assert platoon.get("network_in_domain") == [expected]


@pytest.mark.parametrize("n", [1, 2, 6])
def test_only_active_vehicles_count_and_are_commanded(controller, n):
    s, v = random_start(6)
    inputs = named(s[: n - 1], v[:n]) | {"n_active": float(n)}
    absent = {f"v[{i}]": nan for i in range(n + 1, N + 1)} | {f"s[{i}]": -1.0 for i in range(n + 1, N + 1)}
    assert controller.initialise(FIXED | inputs | absent) == OK
    a = controller.group("a")
    assert a[n:] == [0.0] * (N - n)
    np.testing.assert_allclose(a[:n], law(s[: n - 1], v[:n]), atol=1e-12)


def test_the_desired_speed_may_change(controller):
    s, v = random_start(6)
    assert controller.initialise(FIXED | named(s, v) | {"v_desired": 20.0}) == OK
    slower = feedback(np.array(s), np.array(v), BEST_FIXED, PlatoonParameters(v_star=20.0))
    np.testing.assert_allclose(controller.group("a"), slower, atol=1e-12)


def limits(least: float, most: float) -> dict[str, float]:
    """The same limits for all vehicles."""
    return {f"a_min[{i}]": least for i in range(1, N + 1)} | {f"a_max[{i}]": most for i in range(1, N + 1)}


def test_the_command_is_bounded_and_says_where(controller):
    s, v = random_start(7)
    assert controller.initialise({"potential": 1} | limits(-3.0, 1.5) | named(s, v)) == OK
    a = np.array(controller.group("a"))
    saturated = np.array(controller.get(*(f"saturated[{i}]" for i in range(1, N + 1))))
    assert a.min() == -3.0 and a.max() == 1.5 and 0 < saturated.sum() <= N
    np.testing.assert_array_equal(saturated == 1.0, (a == -3.0) | (a == 1.5))


BAD = [
    ({"s[3]": 5.0}, "s[3] = 5 m"),
    ({"s[3]": nan}, "s[3] must be a finite number"),
    ({"v[2]": 35.5}, "v[2] = 35.5 m/s"),
    ({"v[7]": -0.1}, "v[7] = -0.1 m/s"),
    ({"v[1]": nan}, "v[1] must be a finite number"),
    ({"n_active": 2.5}, "n_active = 2.5"),
    ({"n_active": 0.0}, "n_active = 0"),
    ({"n_active": 8.0}, "n_active = 8"),
    ({"n_active": nan}, "n_active = nan"),
    ({"v_desired": 35.1}, "v_desired = 35.1 m/s"),
    ({"v_desired": -0.1}, "v_desired = -0.1 m/s"),
    ({"v_desired": nan}, "v_desired = nan m/s"),
    ({"resolve": nan}, "resolve must be a finite number"),
    ({"t_measured": 0.0}, "0.02 s old"),
    ({"t_measured": nan}, "nan s old"),
]


@pytest.mark.parametrize(("bad", "part"), BAD, ids=str)
def test_bad_input_is_an_error_of_one_sentence_or_the_safe_action_until_it_is_good_again(
    instances, controller_fmu, bad, part
):
    good = named(*random_start(8)) | {"n_active": 7.0, "resolve": 0.0, "t_measured": 0.02, "v_desired": -1.0}
    strict = instances(controller_fmu)
    assert strict.initialise(FIXED | {"max_age": 0.015} | good) == OK
    assert strict.step(0.0, 2 * T) == OK
    assert strict.set(good | bad) == OK
    assert strict.step(2 * T, T) == ERROR
    assert part in strict.messages[-1][1] and "\n" not in strict.messages[-1][1]
    assert strict.call("fmi2Reset") == OK
    assert strict.initialise(FIXED | named(*random_start(8))) == OK

    safe = instances(controller_fmu)  # not before: fmpy hands all messages to the logger of the newest instance
    assert safe.initialise(SAFE | {"max_age": 0.015} | good) == OK
    assert safe.step(0.0, 2 * T) == OK
    assert safe.set(good | bad) == OK
    assert safe.step(2 * T, T) == OK
    assert safe.messages[-1][0] == WARNING and part in safe.messages[-1][1]
    backwards = [bad.get(f"v[{i}]", 1.0) < 0 for i in range(1, N + 1)]
    assert safe.group("a") == [0.0 if stands else -3.0 for stands in backwards]
    assert safe.get("input_ok", "input_faults", "T_max", "lemma1_ok") == [0.0, 1.0, 0.0, 0.0]
    assert safe.set(good | {"t_measured": 0.03}) == OK
    assert safe.step(3 * T, T) == OK
    assert safe.get("input_ok", "input_faults") == [1.0, 1.0]
    np.testing.assert_allclose(safe.group("a"), law(*random_start(8)), atol=1e-12)


def test_the_safe_action_stops_at_standstill(controller):
    s, v = random_start(9)
    assert controller.initialise(SAFE | named(s, [0.01, 0.0, *v[2:]]) | {"s[2]": 1.0}) <= WARNING
    np.testing.assert_allclose(controller.group("a"), [-1.0, 0.0, *[-3.0] * 5])


def test_inputs_that_nobody_renews_grow_stale_inside_a_long_step(controller):
    assert controller.initialise(SAFE | {"max_age": 0.035} | named(*random_start(8))) == OK
    assert controller.step(0.0, 10 * T) == OK
    assert controller.get("input_faults") == [6.0]  # instants 0 to 3 T are fresh enough


def test_inputs_set_before_the_start_time_is_known_belong_to_the_start(controller):
    s, v = random_start(8)
    assert controller.set(FIXED | {"max_age": 1.0} | named(s, v)) == OK
    assert controller.call("fmi2SetupExperiment", 0, 0.0, 100.0, 0, 0.0) == OK
    assert controller.call("fmi2EnterInitializationMode") == OK
    np.testing.assert_allclose(controller.group("a"), law(s, v), atol=1e-12)
    assert controller.call("fmi2ExitInitializationMode") == OK
    assert controller.step(100.0, T) == OK


@pytest.mark.parametrize(
    "change", [{"a_min[2]": 1.0}, {"a_max[7]": 0.0}, {"a_safe": 1.0}, {"max_age": 0.0}, {"phase": T}]
)
def test_a_bad_parameter_is_an_error_of_one_sentence(controller, change):
    assert controller.initialise(change) == ERROR
    assert next(iter(change)) in controller.messages[-1][1]


@pytest.mark.parametrize("pending", [False, True])
def test_a_saved_state_has_the_identical_future_also_in_another_instance(instances, controller_fmu, pending):
    one, other = instances(controller_fmu), instances(controller_fmu)
    starts = [random_start(k) for k in range(12)]

    def future(instance) -> list[list[float]]:
        seen = []
        for k in range(4, 12):
            assert instance.step(k * T, T) == OK
            assert instance.set(named(*starts[k]) | {"resolve": float(k % 2)}) == OK
            seen.append(instance.outputs())
        return seen

    assert one.initialise(named(*starts[0])) == OK
    for k in range(4):
        assert one.step(k * T, T) == OK
        assert one.set(named(*starts[k])) == OK
    if pending:
        one.outputs()
    state = one.slave.getFMUstate()
    data = one.slave.serializeFMUstate(state)
    expected = future(one)
    one.slave.setFMUstate(state)
    assert future(one) == expected
    other.slave.setFMUstate(other.slave.deSerializeFMUstate(data))
    assert future(other) == expected


def test_descriptions_pass_fmpys_checks_and_name_dependencies(controller_fmu, plant_fmu):
    from fmpy.validation import validate_fmu

    for fmu in (controller_fmu, plant_fmu):
        assert validate_fmu(str(fmu.path)) == []
    a = next(u for u in controller_fmu.description.outputs if u.variable.name == "a[3]")
    assert {"s[2]", "v[7]", "n_active", "resolve"} <= {known.name for known in a.dependencies}
    assert all(v.type == "Real" for v in controller_fmu.description.modelVariables if v.causality != "parameter")
