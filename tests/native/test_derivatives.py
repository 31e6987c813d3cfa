"""Directional derivatives of the native FMU against central differences through the FMU itself."""

from __future__ import annotations

from ctypes import c_double, c_uint

import numpy as np
import pytest

from harness import ERROR, OK, WARNING, Instance, random_start, starts

OUTPUTS = [f"a[{i}]" for i in range(1, 8)] + ["x[4]", "v[2]", "s[5]", "T_max", "T_exact", "alpha", "r", "p", "J"]
KNOWN = ["s_start[2]", "s_start[5]", "v_start[1]", "v_start[6]", "x_start", "mu", "v_star", "v_max", "epsilon", "L"]
KNOWN += ["lambda", "alpha_fixed", "r_fixed", "p_fixed", "T", "w1"]


def _initial(instance: Instance, values: dict[str, float]) -> np.ndarray:
    assert instance.call("fmi2Reset") == OK
    assert instance.initialise(values) == OK
    return np.array(instance.get(*OUTPUTS))


def _derivative(instance: Instance, known: list[str], seed: list[float]) -> tuple[int, np.ndarray]:
    reference = instance.fmu.reference
    unknowns = (c_uint * len(OUTPUTS))(*(reference[name] for name in OUTPUTS))
    knowns = (c_uint * len(known))(*(reference[name] for name in known))
    result = (c_double * len(OUTPUTS))()
    directions = (c_double * len(seed))(*seed)
    counts = len(OUTPUTS), len(known)
    status = instance.call("fmi2GetDirectionalDerivative", unknowns, counts[0], knowns, counts[1], directions, result)
    return status, np.array(result)


@pytest.mark.parametrize("potential", [1, 2])
@pytest.mark.parametrize("known", KNOWN)
def test_derivatives_at_the_start_match_differences(native, potential, known):
    values = starts(*random_start(8)) | {
        "potential": potential,
        "parameter_source": 2,
        "alpha_fixed": 2e-3,
        "p_fixed": 5.0,
    }
    start = {v.name: float(v.start) for v in native.fmu.description.modelVariables if v.start is not None}
    at, h = (start | values)[known], 1e-6
    slope = (_initial(native, values | {known: at + h}) - _initial(native, values | {known: at - h})) / (2 * h)
    assert native.call("fmi2Reset") == OK
    assert native.set(values) == OK and native.call("fmi2EnterInitializationMode") == OK
    status, derivative = _derivative(native, [known], [1.0])
    assert status == OK
    np.testing.assert_allclose(derivative, slope, rtol=1e-5, atol=1e-6)


def test_several_knowns_add_up(native):
    assert native.set({"parameter_source": 2}) == OK and native.call("fmi2EnterInitializationMode") == OK
    single = [_derivative(native, [name], [1.0])[1] for name in KNOWN]
    seed = list(np.linspace(-1, 2, len(KNOWN)))
    _, together = _derivative(native, KNOWN, seed)
    np.testing.assert_allclose(together, np.array(seed) @ np.array(single), rtol=1e-9, atol=1e-12)


def test_what_the_network_chooses_has_no_derivative_and_says_so(native):
    assert native.call("fmi2EnterInitializationMode") == OK
    status, _ = _derivative(native, ["s_start[2]"], [1.0])
    assert status == ERROR and "set parameter_source to 2" in native.messages[-1][1]


def test_fewer_vehicles_than_places_have_the_same_derivatives_and_the_other_places_none(native):
    values = starts(*random_start(8)) | {"parameter_source": 2, "n_start": 4}
    at, h = values["s_start[4]"], 1e-6
    slope = (_initial(native, values | {"s_start[4]": at + h}) - _initial(native, values | {"s_start[4]": at - h})) / (
        2 * h
    )
    assert native.call("fmi2Reset") == OK
    assert native.set(values) == OK and native.call("fmi2EnterInitializationMode") == OK
    status, derivative = _derivative(native, ["s_start[4]"], [1.0])
    assert status == OK and slope[3] != 0.0
    np.testing.assert_allclose(derivative, slope, rtol=1e-5, atol=1e-6)
    _, behind = _derivative(native, ["s_start[5]", "v_start[6]"], [1.0, 1.0])
    assert not behind.any()


def test_a_lone_vehicle_has_derivatives_by_its_speed_only(native):
    values = {"parameter_source": 2, "n_start": 1, "v_start[1]": 25.0}
    assert native.set(values) == OK and native.call("fmi2EnterInitializationMode") == OK
    status, derivative = _derivative(native, ["v_start[1]", "s_start[2]"], [1.0, 1.0])
    assert status == OK and np.isfinite(derivative).all()
    gain = 0.5 + 35.0 / (30.0 * 5.0) * 0.1  # mu + g(0)
    assert derivative[0] == pytest.approx(-gain) and not derivative[1:7].any()


def test_after_initialisation_outputs_depend_on_no_parameter_and_on_no_input_at_once(native):
    assert native.initialise({"parameter_source": 2}) == OK
    assert _derivative(native, [], [])[0] == OK
    assert _derivative(native, ["s_start[2]"], [1.0])[0] == ERROR
    assert "initialization mode" in native.messages[-1][1]
    assert native.call("fmi2Reset") == OK and native.initialise({}) == OK
    status, derivative = _derivative(native, ["insert", "insert_gap"], [1.0, 1.0])
    assert status == OK and not derivative.any()


@pytest.mark.parametrize(
    "values", [{"kappa": 0.1}, {"closing_speed": 0.5}, {"length[3]": 6.0}, {"leader_automated": 0.0}]
)
def test_the_extended_law_has_no_derivatives_and_says_so(native, values):
    assert native.set({"parameter_source": 2} | values) == OK and native.call("fmi2EnterInitializationMode") == OK
    assert _derivative(native, ["s_start[2]"], [1.0])[0] == ERROR
    assert "the derivatives of the paper's law only: set kappa and closing_speed to 0" in native.messages[-1][1]


@pytest.mark.parametrize("known", ["kappa", "kappa_reach", "closing_speed", "closing_reach", "length[7]"])
def test_there_is_no_derivative_by_what_the_extended_law_has(native, known):
    assert native.set({"parameter_source": 2}) == OK and native.call("fmi2EnterInitializationMode") == OK
    assert _derivative(native, [known], [1.0])[0] == ERROR
    assert f"no derivative with respect to {known}: leave it out" in native.messages[-1][1]


def test_the_derivative_of_an_exact_period_that_a_spacing_sets(native):
    s, v, h = 5.2, 30.0, 1e-7
    values = starts([s, *[12.0] * 5], [0.0, *[v] * 6]) | {"parameter_source": 2, "lemma1_policy": 2}
    found = []
    for step in (h, -h):
        assert native.call("fmi2Reset") == OK
        assert native.initialise(values | {"s_start[2]": s + step, "v_start[2]": v - step}) <= WARNING
        found += native.get("T_exact")
    assert native.call("fmi2Reset") == OK
    assert native.set(values) == OK and native.call("fmi2EnterInitializationMode") == OK
    status, derivative = _derivative(native, ["s_start[2]", "v_start[2]"], [1.0, -1.0])
    assert status == OK and found[0] == pytest.approx((s - 5.0) / v, rel=0.2)
    assert derivative[OUTPUTS.index("T_exact")] == pytest.approx((found[0] - found[1]) / (2 * h), rel=1e-5)
