"""What the FMU puts out against the independent reference, whatever the communication step."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from harness import OK, random_start, starts
from psp_model import PlatoonParameters, PotentialParameters, project
from reference import reference_run

T = 0.01
SHAPES = [(1, 1.0, 0.0, 0.0), (2, 1e-3, 11.0, 5.5), (2, 2e-2, 9.0, 4.2), (2, 1e-3, 8.2, 3.0)]


def shape_values(potential: int, alpha: float, r: float, p: float) -> dict[str, float]:
    """Start values for a given potential, feasible by projection."""
    if potential == 1:
        return {"potential": 1}
    shape = project(PotentialParameters(alpha, r, p), PlatoonParameters())
    triple = {"alpha_fixed": shape.alpha, "r_fixed": shape.r, "p_fixed": shape.p}
    return triple | {"parameter_source": 2}


@pytest.mark.parametrize("case", range(len(SHAPES)))
def test_outputs_equal_the_reference_at_every_sampling_instant(instance, case):
    s, v = random_start(case)
    values = shape_values(*SHAPES[case]) | {"x_start": -12.5}
    assert instance.initialise(starts(s, v) | values) == OK
    alpha, r, p = instance.get("alpha", "r", "p")
    expected = reference_run(s, v, -12.5, alpha=alpha, r=r, p=p, hill=SHAPES[case][0] == 2, T=T)
    for k in range(2001):
        for name in ("x", "s", "v", "a"):
            np.testing.assert_allclose(instance.group(name), getattr(expected, name)[k], rtol=0, atol=1e-9)
        report = instance.get("T_max", "J_acceleration", "J_gap", "J")
        terms = (expected.J_acceleration[k], expected.J_gap[k])
        np.testing.assert_allclose(report, [expected.T_max[k], *terms, sum(terms)], rtol=0, atol=1e-9)
        assert instance.step(k * T, T) == OK


def run_to_end(instance, times: np.ndarray, duration: float = 20.0) -> dict[int, list[float]]:
    """Outputs at the common instants k * 1.85 s, which T, 5T, T/4 and 0.037 s all reach."""
    seen = {}
    for begin, end in pairwise(times):
        assert instance.step(begin, end - begin) == OK
        periods = end / T
        if abs(periods - round(periods)) < 1e-6 and round(periods) % 185 == 0:
            seen[round(periods)] = instance.outputs()
    return seen


def test_results_do_not_depend_on_the_communication_step(instances):
    s, v = random_start(11)
    runs = []
    for step in (T, 5 * T, T / 4, 0.037):
        instance = instances()
        assert instance.initialise(starts(s, v)) == OK
        runs.append(run_to_end(instance, np.cumsum(np.r_[0.0, np.full(round(18.5 / step), step)])))
    assert len(runs[0]) == 10
    for other in runs[1:]:
        assert other.keys() == runs[0].keys()
        for instant, outputs in other.items():
            np.testing.assert_allclose(outputs, runs[0][instant], rtol=0, atol=1e-9)


def test_steps_with_rounding_error_of_zero_length_and_of_random_length_change_nothing(instances):
    rng = np.random.default_rng(5)
    s, v = random_start(12)
    plain, odd = instances(), instances()
    for instance in (plain, odd):
        assert instance.initialise(starts(s, v)) == OK
    for k in range(370):
        assert plain.step(k * T, T) == OK
    time = 0.0
    while time < 3.7 - 0.08:
        step = rng.choice([0.0, T * (1 + 1e-13), T * (1 - 1e-13), rng.uniform(0, 7 * T)])
        assert odd.step(time, step) == OK
        time += step
    assert odd.step(time, 3.7 - time) == OK
    assert odd.step(3.7, 0.0) == OK
    np.testing.assert_allclose(odd.outputs(), plain.outputs(), rtol=0, atol=1e-9)


def test_between_instants_the_outputs_follow_the_exact_polynomial(instance):
    s, v = random_start(13)
    assert instance.initialise(starts(s, v)) == OK
    a = instance.group("a")
    assert instance.step(0.0, 0.3 * T) == OK
    tau = 0.3 * T
    np.testing.assert_allclose(
        instance.group("v"), [v_i + tau * a_i for v_i, a_i in zip(v, a, strict=True)], atol=1e-12
    )
    spacings = [s[i] + tau * (v[i] - v[i + 1]) + tau**2 / 2 * (a[i] - a[i + 1]) for i in range(6)]
    np.testing.assert_allclose(instance.group("s"), spacings, atol=1e-12)
    assert instance.group("a") == a  # held until the next instant
    area = sum(tau * s[i] + tau**2 / 2 * (v[i] - v[i + 1]) + tau**3 / 6 * (a[i] - a[i + 1]) for i in range(6))
    np.testing.assert_allclose(instance.get("J_gap"), 0.5 * area / 20, atol=1e-12)


def test_a_run_may_start_at_any_time(instances):
    early, late = instances(), instances()
    assert early.initialise() == OK
    assert late.initialise(start_time=123.456) == OK
    for k in range(50):
        assert early.step(k * T, T) == OK
        assert late.step(123.456 + k * T, T) == OK
    np.testing.assert_allclose(late.outputs(), early.outputs(), rtol=0, atol=1e-9)


def test_scenario_1_opens_the_spacings_to_lambda_and_scenario_2_keeps_them_near_the_hill(instances):
    ends, peaks = [], []
    for potential in (1, 2):
        instance = instances()
        assert instance.initialise({"potential": potential}) == OK
        peak = 0.0
        for k in range(6000):
            peak = max(peak, *map(abs, instance.group("a")))
            assert instance.step(k * T, T) == OK
        ends.append(instance.group("s"))
        peaks.append(peak)
        r = instance.get("r")[0]
    assert min(ends[0]) > 20.0 - 0.05  # V_old repels up to lambda, ever more weakly
    assert peaks[0] > 100.0
    assert peaks[1] < peaks[0] / 30.0
    assert np.median(ends[1]) < r + 3.0
