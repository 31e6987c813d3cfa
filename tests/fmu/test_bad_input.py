"""Every bad start value and file: fmi2Error at initialisation, one sentence, and the instance runs after a reset."""

from __future__ import annotations

import shutil
from math import inf, nan
from pathlib import Path

import pytest

from fmu_src.python.build import build_python_fmu
from harness import ERROR, OK, Instance, Unpacked

FIXED = {"parameter_source": 2}
BAD_VALUES = [
    ({"L": 0.0}, ["L = 0 m", "positive"]),
    ({"L": -1.0}, ["L = -1 m", "positive"]),
    ({"lambda": 8.0}, ["lambda = 8 m", "8 m", "raise lambda or lower L"]),
    ({"lambda": 7.0}, ["lambda = 7 m"]),
    ({"lambda": 1e110, "parameter_source": 2}, ["max |V_new'| = inf m/s2", "z = 4 m/s2"]),
    ({"v_star": 0.0}, ["v_star = 0 m/s", "v_max = 35 m/s"]),
    ({"v_star": 35.0}, ["v_star = 35 m/s", "v_max = 35 m/s"]),
    ({"v_max": -3.0}, ["v_max = -3 m/s"]),
    ({"epsilon": 0.0}, ["epsilon = 0 m/s2"]),
    ({"mu": 0.0}, ["mu = 0 1/s"]),
    ({"z": 0.0}, ["z = 0 m/s2"]),
    ({"w1": -0.1}, ["w1 = -0.1"]),
    ({"w2": -0.1}, ["w2 = -0.1"]),
    ({"a_ref": 0.0}, ["a_ref = 0 m/s2"]),
    ({"s_ref": 0.0}, ["s_ref = 0 m"]),
    ({"T": 0.0}, ["T = 0 s", "positive"]),
    ({"T": -0.01}, ["T = -0.01 s", "positive"]),
    ({"T": nan}, ["T must be a finite number", "nan"]),
    ({"mu": nan}, ["mu must be a finite number", "nan", "1/s"]),
    ({"lambda": inf}, ["lambda must be a finite number", "inf"]),
    ({"x_start": nan}, ["x_start must be a finite number"]),
    ({"s_start[3]": nan}, ["s_start[3] must be a finite number", "nan"]),
    ({"v_start[7]": inf}, ["v_start[7] must be a finite number", "inf"]),
    ({"s_start[4]": 5.0}, ["spacing s[4] = 5 m", "L = 5 m", "further apart"]),
    ({"s_start[2]": -3.0}, ["spacing s[2] = -3 m"]),
    ({"v_start[1]": -0.001}, ["speed v[1] = -0.001 m/s", "[0, 35] m/s"]),
    ({"v_start[6]": 35.001}, ["speed v[6] = 35.001 m/s", "[0, 35] m/s"]),
    ({"s_start[4]": 5.0 - 1e-12}, ["spacing s[4] = 4.999999999998", "L = 5 m"]),
    ({"v_start[6]": 35.0 + 1e-12}, ["speed v[6] = 35.00000000000100", "[0, 35] m/s"]),
    ({"potential": 0}, ["potential = 0", "1 to 2"]),
    ({"parameter_source": 4}, ["parameter_source = 4", "1 to 3"]),
    ({"lemma1_policy": 0}, ["lemma1_policy = 0", "1 to 3"]),
    ({"max_short_periods": 0}, ["max_short_periods = 0"]),
    ({"n_start": 0}, ["n_start = 0", "1 to 7"]),
    ({"n_start": 8}, ["n_start = 8", "1 to 7"]),
    ({"p_fixed": 8.0}, ["max |V_new'| = ", "z = 4 m/s2", "lower p"]),
    (FIXED | {"alpha_fixed": 9e-4}, ["alpha = 0.0009", "[0.001, 0.1]"]),
    (FIXED | {"alpha_fixed": 0.11}, ["alpha = 0.11", "[0.001, 0.1]"]),
    (FIXED | {"r_fixed": 5.0}, ["r = 5 m", "L = 5 m"]),
    (FIXED | {"r_fixed": 17.1}, ["r = 17.1 m", "17 m"]),
    (FIXED | {"p_fixed": 2.9}, ["p = 2.9", "[3, 9]"]),
    (FIXED | {"p_fixed": 9.1}, ["p = 9.1", "[3, 9]"]),
    (FIXED | {"p_fixed": 8.0}, ["max |V_new'| = ", "z = 4 m/s2", "lower p"]),
    (FIXED | {"p_fixed": nan}, ["p must be a finite number"]),
    ({"rollout_horizon": 0.0}, ["rollout_horizon = 0 s"]),
]


@pytest.mark.parametrize(("values", "parts"), BAD_VALUES, ids=lambda value: str(value)[:40])
def test_a_bad_start_value_is_one_sentence_and_the_instance_runs_after_a_reset(instance, values, parts):
    assert instance.initialise(values) == ERROR
    (sentence,) = [text for status, text in instance.messages if status == ERROR]
    for part in parts:
        assert part in sentence
    assert "\n" not in sentence and "Traceback" not in sentence
    assert instance.call("fmi2Reset") == OK
    assert instance.initialise() == OK
    assert instance.step(0.0, 0.01) == OK


def _cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:200])


def _scramble(path: Path) -> None:
    path.write_bytes(b"not a network at all" * 20)


def _other_size(path: Path) -> None:
    shutil.copy(Path(__file__).parents[2] / "onnx" / "platoon_4_alone.onnx", path)


@pytest.mark.parametrize("damage", [Path.unlink, _cut, _scramble, _other_size], ids=lambda f: f.__name__)
def test_a_bad_network_file_is_one_sentence_and_source_2_still_runs(fmu, tmp_path, damage):
    copy = Unpacked(fmu.path, tmp_path / "copy")
    network = copy.folder / "resources" / "platoon_7.onnx"
    damage(network)
    instance = Instance(copy)
    assert instance.initialise() == ERROR
    (sentence,) = [text for status, text in instance.messages if status == ERROR]
    assert network.name in sentence and "\n" not in sentence
    assert instance.call("fmi2Reset") == OK
    assert instance.initialise(FIXED) == OK
    assert instance.step(0.0, 0.01) == OK
    instance.close()


@pytest.mark.parametrize("step", [-0.01, nan, inf])
def test_a_bad_step_is_an_error_and_not_a_crash(instance, step):
    assert instance.initialise() == OK
    assert instance.step(0.0, step) == ERROR
    assert "step" in instance.messages[-1][1]


@pytest.mark.parametrize(("T", "step"), [(0.01, 1e17), (0.01, 1e300), (5e-324, 1.0), (1e-300, 0.01)])
def test_more_sampling_periods_than_can_be_counted_are_an_error_and_not_a_hang(instance, T, step):
    assert instance.initialise({"T": T}) == OK
    assert instance.step(0.0, step) == ERROR
    sentence = instance.messages[-1][1]
    assert f"{step:g} s are more sampling periods of T = {T:.10g} s than can be counted" in sentence


@pytest.mark.parametrize("value", [1e300, 1e-300])
@pytest.mark.parametrize("name", ["a_ref", "s_ref"])
def test_scales_whose_squares_leave_double_precision_are_no_failure(instance, name, value):
    assert instance.initialise({name: value}) == OK
    assert instance.step(0.0, 0.05) == OK
    assert all(term >= 0.0 for term in instance.get("J", "J_acceleration", "J_gap"))


def test_a_step_from_another_time_than_the_last_is_an_error(instance):
    assert instance.initialise() == OK
    assert instance.step(0.0, 0.01) == OK
    assert instance.step(0.5, 0.01) == ERROR
    assert "0.5 s" in instance.messages[-1][1] and "0.01 s" in instance.messages[-1][1]


def test_parameters_are_fixed_once_initialisation_ends(instance):
    assert instance.initialise() == OK
    assert instance.set({"mu": 0.4}) == ERROR


def test_an_output_cannot_be_set(instance):
    assert instance.set({"x[1]": 3.0}) == ERROR
    assert "x[1]" in instance.messages[-1][1]


def test_without_a_network_source_1_says_so(tmp_path):
    instance = Instance(Unpacked(build_python_fmu(3, tmp_path, {}), tmp_path / "unpacked"))
    assert instance.initialise({"parameter_source": 1}) == ERROR
    assert "no network for 3 vehicles" in instance.messages[-1][1]
    assert instance.call("fmi2Reset") == OK
    assert instance.initialise() == OK
    instance.close()


def test_statuses_and_errors_do_not_depend_on_debug_logging(instances):
    silent = instances(logging=False)
    assert silent.initialise({"L": -1.0}) == ERROR
    assert [status for status, _ in silent.messages] == [ERROR]
