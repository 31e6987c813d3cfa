"""The native FMU against the Python FMU: same numbers, same counters, same sentences."""

from __future__ import annotations

import numpy as np
import pytest

from fmu.test_bad_input import BAD_VALUES
from fmu_src.native.build import build_native_fmu, native_platoon
from harness import DISCARD, ERROR, OK, WARNING, Instance, Unpacked, random_start, starts


def _trajectory(fmu: Unpacked, values: dict[str, float], sizes: list[float]) -> tuple[np.ndarray, list]:
    """Outputs at the start and after each step, and the messages."""
    instance = Instance(fmu)
    rows, time = [], 0.0
    if instance.initialise(values) <= WARNING:
        rows.append(instance.outputs())
        for size in sizes:
            if instance.step(time, size) > WARNING:
                break
            time += size
            rows.append(instance.outputs())
    messages = instance.messages
    instance.close()
    return np.array(rows), messages


def _agree(python_fmu, native_fmu, values, sizes, tolerance):
    reference, sentences = _trajectory(python_fmu, values, sizes)
    seen, said = _trajectory(native_fmu, values, sizes)
    assert said == sentences
    np.testing.assert_allclose(seen, reference, rtol=0, atol=tolerance)
    return reference, sentences


@pytest.mark.parametrize(("potential", "source", "tolerance"), [(1, 2, 1e-9), (2, 2, 1e-9), (2, 1, 1e-6), (2, 3, 1e-6)])
def test_20_seconds_from_random_starts_agree(python_fmu, native_fmu, potential, source, tolerance):
    for seed in range(2 if source == 3 else 6):  # 20 each: python -m benchmarks agreement
        values = starts(*random_start(seed)) | {"potential": potential, "parameter_source": source}
        _agree(python_fmu, native_fmu, values, [0.05] * 400, tolerance)


@pytest.mark.parametrize("sizes", [[0.037] * 100, [0.0025] * 300, [0.01, 0.0, 0.003, 0.007, 0.5] * 4])
def test_any_communication_step_agrees(python_fmu, native_fmu, sizes):
    _agree(python_fmu, native_fmu, starts(*random_start(5)) | {"parameter_source": 2}, sizes, 1e-9)


def test_policy_2_counts_and_warns_alike(python_fmu, native_fmu):
    values = starts(*random_start(2)) | {"potential": 1, "T": 0.05, "lemma1_policy": 2}
    rows, sentences = _agree(python_fmu, native_fmu, values, [0.1] * 30, 1e-9)
    assert sentences and sentences[0][0] == WARNING and len(rows) == 31


def test_policy_3_takes_the_same_short_periods(python_fmu, native_fmu):
    values = starts(*random_start(2)) | {"potential": 1, "T": 0.05, "lemma1_policy": 3, "s_start[2]": 5.01}
    rows, _ = _agree(python_fmu, native_fmu, values, [0.03] * 50, 1e-9)
    assert len(rows) == 51


def test_too_many_short_periods_end_alike(python_fmu, native_fmu):
    values = {"potential": 1, "lemma1_policy": 3, "s_start[2]": 5.0 + 1e-5, "max_short_periods": 3}
    _, sentences = _agree(python_fmu, native_fmu, values, [0.1] * 3, 1e-9)
    assert sentences[-1][0] == DISCARD


def test_other_constants_fall_back_alike(python_fmu, native_fmu):
    _, sentences = _agree(python_fmu, native_fmu, {"mu": 0.6}, [0.1] * 10, 1e-9)
    assert sentences[0][0] == WARNING


@pytest.mark.parametrize("r_fixed", [5.2, 9.0, 14.0])
def test_a_bad_start_is_refused_in_the_same_words(python_fmu, native_fmu, r_fixed):
    values = {"parameter_source": 2, "p_fixed": 7.3, "r_fixed": r_fixed}
    _agree(python_fmu, native_fmu, values, [], 0.0)


def test_every_bad_value_is_refused_in_the_same_words(python_fmu, native_fmu):
    said = []
    for fmu in (python_fmu, native_fmu):
        instance = Instance(fmu)
        for values, _ in BAD_VALUES:
            assert instance.initialise(values) == ERROR
            assert instance.call("fmi2Reset") == OK
        said.append(instance.messages)
        instance.close()
    assert said[0] == said[1] and len(said[0]) == len(BAD_VALUES)


def test_the_variables_are_the_same(python_fmu, native_fmu):
    def rows(fmu):
        return [
            (v.name, v.valueReference, v.type, v.causality, v.variability, v.initial, v.start, v.unit, v.min, v.max)
            for v in fmu.description.modelVariables
        ]

    assert rows(native_fmu) == rows(python_fmu)


def test_without_a_network_source_1_is_refused(tmp_path):
    instance = Instance(Unpacked(build_native_fmu(native_platoon(3, {}), tmp_path), tmp_path / "unpacked"))
    assert instance.initialise({"parameter_source": 1}) == ERROR
    assert "there is no network for 3 vehicles" in instance.messages[0][1]
    instance.close()
