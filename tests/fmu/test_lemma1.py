"""Lemma 1 at every sampling instant, with its three policies."""

from __future__ import annotations

import numpy as np

from harness import DISCARD, ERROR, OK, WARNING, starts
from psp_model import StartDomain
from reference import reference_run

OLD = {"potential": 1}


def start_that_breaks_the_limit() -> tuple[list[float], list[float]]:
    """A start in the paper's ranges on which V_old, sampled every 0.02 s, drives a vehicle beyond v_max."""
    s, v = StartDomain().draw(np.random.default_rng(3), 7, 400)
    for spacings, speeds in zip(s.T.tolist(), v.T.tolist(), strict=True):
        run = reference_run(spacings, speeds, alpha=1.0, r=0.0, p=0.0, hill=False, T=0.02, duration=0.4)
        if max(map(max, run.v)) > 35.0:
            return spacings, speeds
    raise AssertionError("no start of 400 breaks the limit")


def test_v_old_at_0_02_s_is_refused_where_it_would_break_the_speed_limit(instances):
    start = starts(*start_that_breaks_the_limit())
    refused = instances()
    status = refused.initialise(start | OLD | {"T": 0.02})
    time = 0.0
    while status == OK and time < 0.4:
        status = refused.step(time, 0.02)
        time += 0.02
    assert status == ERROR
    sentence = refused.messages[-1][1]
    assert "T = 0.02 s is not below T_max" in sentence and "v_max = 35 m/s" in sentence and "choose T <" in sentence
    accepted = instances()
    assert accepted.initialise(start | OLD | {"T": 0.01}) == OK
    for k in range(2000):
        assert accepted.step(k * 0.01, 0.01) == OK
    assert accepted.get("lemma1_violations") == [0.0]


def test_at_the_end_of_initialisation_the_error_names_vehicle_values_bound_and_largest_period(instance):
    s, v = [10.0] * 6, [30.0] * 7
    s[3] = 5.2
    assert instance.initialise(starts(s, v) | OLD) == ERROR
    (sentence,) = [text for status, text in instance.messages if status == ERROR]
    bound = float(sentence.split("T_max = ")[1].split(" s")[0])
    assert "vehicle 5" in sentence or "vehicle 4" in sentence
    assert f"choose T < {bound:.10g} s" in sentence
    assert instance.call("fmi2Reset") == OK
    assert instance.initialise(starts(s, v) | OLD | {"T": 0.999 * bound}) == OK
    assert instance.get("lemma1_ok") == [1.0]


def test_policy_2_warns_once_a_stretch_and_counts_every_instant(instance):
    start = starts(*start_that_breaks_the_limit())
    statuses = [instance.initialise(start | OLD | {"T": 0.02, "lemma1_policy": 2})]
    flags, speeds = [instance.get("lemma1_ok")[0]], []
    for k in range(50):
        statuses.append(instance.step(k * 0.02, 0.02))
        flags.append(instance.get("lemma1_ok")[0])
        speeds.append(max(instance.group("v")))
    assert set(statuses) == {OK}  # a warning is a message: as a status it would end the run in several hosts
    assert instance.get("lemma1_violations") == [flags.count(0.0)]
    stretches = sum(now == 0.0 and before == 1.0 for before, now in zip([1.0, *flags], flags, strict=False))
    assert sum(status == WARNING for status, _ in instance.messages) == stretches
    assert max(speeds) > 35.0  # which is what the certificate would have prevented


def test_policy_3_shortens_periods_and_stays_inside_the_state_space(instance):
    s, v = [5.001, 9.0, 5.001, 5.01, 8.0, 5.002], [35.0, 0.0, 35.0, 20.0, 0.0, 35.0, 30.0]
    assert instance.initialise(starts(s, v) | {"parameter_source": 2, "lemma1_policy": 3}) == OK
    for k in range(400):
        assert instance.step(k * 0.01, 0.01) == OK
        assert min(instance.group("s")) > 5.0
        assert min(instance.group("v")) >= 0.0 and max(instance.group("v")) <= 35.0
    assert instance.get("lemma1_violations")[0] > 0


def test_policy_3_gives_the_same_run_for_any_communication_step(instances):
    s, v = [5.01] * 6, [35.0, 0.0, 35.0, 0.0, 35.0, 0.0, 35.0]
    ends = []
    for step in (0.01, 0.0025, 0.05):
        instance = instances()
        assert instance.initialise(starts(s, v) | {"parameter_source": 2, "lemma1_policy": 3}) == OK
        for k in range(round(0.5 / step)):
            assert instance.step(k * step, step) == OK
        ends.append(instance.outputs())
    np.testing.assert_allclose(ends[1], ends[0], rtol=0, atol=1e-9)
    np.testing.assert_allclose(ends[2], ends[0], rtol=0, atol=1e-9)


def test_the_limit_on_short_periods_ends_in_a_clear_error(instance):
    s, v = [5.001] * 6, [30.0] * 7
    values = OLD | {"lemma1_policy": 3, "max_short_periods": 10}
    assert instance.initialise(starts(s, v) | values) == OK
    assert instance.step(0.0, 0.01) == DISCARD
    sentence = instance.messages[-1][1]
    assert "max_short_periods = 10" in sentence and "raise max_short_periods" in sentence
