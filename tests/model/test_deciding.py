"""The controller's decision and the ideal plant as pure functions: values in and out, verdicts instead of actions."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from class_examples import plain
from psp_model import (
    BEST_FIXED,
    V_OLD,
    Fixed,
    Lemma1Policy,
    ModelError,
    PlatoonParameters,
    PlatoonState,
    PotentialParameters,
    Sampling,
    Selection,
    feedback,
    largest_period,
    project_networks,
)
from psp_model.controller import (
    BadMeasurement,
    Command,
    ControllerSettings,
    Decision,
    Measurement,
    SampledController,
    Verdict,
    decide,
    no_command,
)
from psp_model.law.feedback import feedback_towards
from psp_model.parameters import Actuation
from psp_model.selection.selectors import ParameterSource, Request, Selector
from psp_model.vehicles.ideal import STOPPING, IdealPlant
from strategies import CONSTANTS, paper_start

FIXED = Request(source=ParameterSource.FIXED)


def told(capacity: int = 4, policy: int = 2, T: float = 0.01, **others: Any) -> ControllerSettings:
    return ControllerSettings(capacity, sampling=Sampling(T, policy), request=FIXED, **others).checked()


def decided(settings: ControllerSettings, measured: Measurement, before: Command | None = None) -> Decision:
    return decide(settings, Fixed(), {}, before or no_command(settings), 2.5, measured)


@given(st.integers(0, 300), st.integers(1, 6), st.integers(0, 3), st.sampled_from([1, 2, 3]))
@settings(max_examples=40)
def test_a_decision_is_the_law_and_the_same_whoever_asks_how_often(seed, n, spare, policy) -> None:
    s, v = paper_start(seed, n + spare)
    of = told(n + spare, policy)
    before, measured = no_command(of), Measurement(s, v, n)
    kept = plain((before, measured, of))
    first = decided(of, measured, before)
    assert plain(first) == plain(decided(of, measured, before)) and plain((before, measured, of)) == kept
    command = first.command
    law = feedback(s[: n - 1], v[:n], BEST_FIXED, CONSTANTS)
    assert command.a.tolist() == [*law.tolist(), *[0.0] * spare]
    assert command.T_max == largest_period(s[: n - 1], v[:n], law, CONSTANTS)
    assert (command.in_order, command.n_active, command.choices, command.faults) == (True, n, 1, 0)
    certified = command.T_max > 0.01
    assert first.verdict is (Verdict.IN_ORDER if certified else Verdict.NOT_CERTIFIED)
    assert (first.why is None) == certified and command.violations == (not certified)
    for array in (command.a, command.saturated):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


BAD: dict[str, tuple[dict[str, Any], str]] = {
    "nobody": ({"n_active": 0}, "active"),
    "half a vehicle": ({"n_active": 1.5}, "active"),
    "too many": ({"n_active": 5}, "active"),
    "stale": ({"age": 0.3}, "stale"),
    "age unknown": ({"age": np.nan}, "age"),
    "resolve": ({"resolve": np.inf}, "finite"),
    "no number": ({"s": np.array([9.0, np.nan, 9.0])}, "finite"),
    "overtaken": ({"s": np.array([9.0, -1.0, 9.0])}, "measured_order"),
    "too close": ({"s": np.array([4.9, 9.0, 9.0])}, "measured_spacing"),
    "backwards": ({"v": np.array([30.0, 30.0, -1.0, 30.0])}, "measured_backwards"),
    "too fast": ({"v": np.array([36.0, 30.0, 30.0, 30.0])}, "measured_speed"),
    "speed unknown": ({"v": np.array([30.0, np.nan, 30.0, 30.0])}, "finite"),
    "desired unknown": ({"v_desired": np.nan}, "v_desired_finite"),
    "desired backwards": ({"v_desired": -1.0}, "v_desired_backwards"),
    "desired too fast": ({"v_desired": 36.0}, "v_desired"),
}


@pytest.mark.parametrize("policy", list(BadMeasurement))
@pytest.mark.parametrize("case", BAD)
def test_what_is_not_in_order_is_a_verdict_and_raises_nothing(case: str, policy: BadMeasurement) -> None:
    changed, key = BAD[case]
    of = told(bad_input=policy, max_age=0.25)
    good = Measurement(np.array([9.0, 10.0, 11.0]), np.array([30.0, 0.005, 31.0, 20.0]), 4)
    before = decided(of, good).command
    found = decided(of, replace(good, **changed), before)
    assert found.verdict is Verdict.BAD_MEASUREMENT and found.why is not None and found.why.key == key
    command = found.command
    assert not command.in_order and command.T_max == 0.0 and command.faults == 1 and not command.saturated.any()
    kept = ("violations", "choices", "n_active", "shape", "in_domain", "resolve")
    assert [getattr(command, name) for name in kept] == [getattr(before, name) for name in kept]
    v = changed.get("v", good.v)
    for i, a in enumerate(command.a.tolist()):
        slowest = -max(v[i], 0.0) / 0.01 if np.isfinite(v[i]) else -np.inf
        assert a == max(of.a_safe, slowest)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_the_fail_safe_command_is_for_active_vehicles_only(n: int) -> None:
    found = decided(told(max_age=0.1), Measurement(np.full(3, 9.0), np.full(4, 30.0), n, age=1.0))
    assert found.command.a.tolist() == [-2.0] * n + [0.0] * (4 - n)


def test_limits_of_the_command_are_marked_and_count_in_T_max() -> None:
    s, v = np.array([5.5, 12.0, 30.0]), np.array([30.0, 30.0, 25.0, 35.0])
    of = told(actuation=Actuation(a_min=-1.0, a_max=0.5), a_safe=-0.5)
    command = decided(of, Measurement(s, v, 4)).command
    law = feedback(s, v, BEST_FIXED, CONSTANTS)
    assert command.a.tolist() == np.clip(law, -1.0, 0.5).tolist()
    assert command.saturated.tolist() == ((law < -1.0) | (law > 0.5)).tolist() and command.saturated.any()
    assert command.T_max == largest_period(s, v, command.a, CONSTANTS)


class Counting:
    """A selector of one's own that gives another potential each time."""

    def __init__(self) -> None:
        self.asked: list[int] = []

    def select(self, s: Any, v: Any, constants: PlatoonParameters) -> Selection:
        self.asked.append(len(v))
        return Selection(PotentialParameters(1e-3, 10.0 + 0.1 * len(self.asked), 5.0), warning=f"no. {len(self.asked)}")


def test_a_selector_is_asked_where_vehicles_change_or_resolve_rises_and_nowhere_else() -> None:
    of, selector = told(), Counting()
    assert isinstance(selector, Selector)
    now, warnings = no_command(of), []
    s, v = np.array([12.0, 13.0, 14.0]), np.full(4, 30.0)
    rows = [
        (4, 0.0),
        (4, 0.0),
        (4, 1.0),
        (4, 1.0),
        (4, 0.4),
        (4, 0.6),
        (3, 0.6),
        (3, 0.6),
        (4, 0.0),
        (9, 1.0),
        (4, 1.0),
    ]
    for n, resolve in rows:
        found = decide(of, selector, {}, now, 0.0, Measurement(s, v, n, resolve=resolve))
        now = found.command
        warnings.append(found.warning)
    assert selector.asked == [4, 4, 4, 3, 4, 4] and now.choices == 6
    assert [one is not None for one in warnings] == [
        True,
        False,
        True,
        False,
        False,
        True,
        True,
        False,
        True,
        False,
        True,
    ]
    assert now.shape == PotentialParameters(1e-3, 10.6, 5.0) and now.faults == 1
    law = feedback_towards(s, v, now.shape, CONSTANTS, 20.0)
    towards = decide(of, selector, {}, now, 0.0, Measurement(s, v, 4, resolve=1.0, v_desired=20.0)).command
    assert towards.a.tolist() == law.tolist() and towards.choices == 6


def test_in_domain_says_where_the_vehicles_were_whatever_is_asked_for() -> None:
    networks = project_networks(3)
    s, v = paper_start(5, 3)
    of = told(3)
    for shift, inside in ((0.0, True), (8.0, False)):
        found = decide(of, Fixed(), networks, no_command(of), 0.0, Measurement(s + shift, v, 3)).command
        assert found.in_domain is inside and found.shape == BEST_FIXED
    assert not decide(of, Fixed(), {}, no_command(of), 0.0, Measurement(s, v, 3)).command.in_domain


def test_policies_act_on_verdicts_in_the_shell_alone() -> None:
    """The same decisions; policy 1 raises and keeps the last command, policy 2 warns at the first of a stretch."""
    close, apart = (Measurement(np.array([spacing, 15.0, 15.0]), np.full(4, 30.0), 4) for spacing in (5.2, 15.0))
    rows = [apart, close, close, apart, close]
    for policy in (1, 2):
        heard: list[str] = []
        of = told(policy=policy)
        shell, pure, said = SampledController.begin(of, {}, heard.append), no_command(of), []
        for k, row in enumerate(rows):
            found = decide(of, Fixed(), {}, pure, 0.1 * k, row)
            if policy == 1 and found.verdict is Verdict.NOT_CERTIFIED:
                with pytest.raises(ModelError) as caught:
                    shell.sample(0.1 * k, row)
                assert str(caught.value) == str(found.why) and caught.value.key == "lemma1_controller_spacing"
                continue
            shell.sample(0.1 * k, row)
            if found.verdict is Verdict.NOT_CERTIFIED and pure.T_max > 0.01:
                said.append(str(found.why))
            pure = found.command
            assert plain(shell.now) == plain(pure)
        assert heard == said and len(said) == (2 if policy == 2 else 0)


def test_before_the_first_instant_nothing_is_commanded() -> None:
    for request, shape in ((FIXED, BEST_FIXED), (Request(old=True), V_OLD)):
        command = no_command(ControllerSettings(3, request=request))
        assert command.a.tolist() == [0.0] * 3 and command.saturated.tolist() == [False] * 3
        assert command.in_order and command.shape == shape and not command.in_domain
        assert (command.T_max, command.violations, command.faults, command.choices) == (0.0, 0, 0, 0)


@given(st.integers(0, 300), st.integers(1, 6), st.lists(st.integers(0, 4), min_size=1, max_size=8))
@settings(max_examples=30)
def test_the_ideal_plant_is_a_value_and_waits_for_nobody(seed, n, jumps) -> None:
    """Periods passed in one call or in many are the same, and earlier plants stay as they were."""
    rng = np.random.default_rng(seed)
    a = rng.normal(0.0, 20.0, n)
    start = IdealPlant.begin(PlatoonState(*paper_start(seed, n), x_leader=3.0), 0.05)
    kept, walked, now = plain(start), start, start.now
    for period in np.cumsum(jumps).tolist():
        for _ in range(walked.period, period):
            now, _ = STOPPING.advance(now, a, 0.05)
        walked = walked.advanced_to(period, a)
        assert plain(walked) == plain(IdealPlant(now, 0.05, period)) == plain(start.advanced_to(period, a))
        assert (walked.now.v >= 0).all()
    assert plain(walked.advanced_to(0, a)) == plain(walked) and plain(start) == kept
    with pytest.raises(ValueError, match="read-only"):
        walked.now.v[0] = 1.0


def test_policy_3_makes_no_sense_for_measured_vehicles_and_counts_as_2() -> None:
    close = Measurement(np.array([5.2, 15.0, 15.0]), np.full(4, 30.0), 4)
    heard: dict[int, list[str]] = {2: [], 3: []}
    for policy, sentences in heard.items():
        made = SampledController.begin(told(policy=policy), {}, sentences.append)
        made.sample(0.0, close)
        assert made.now.violations == 1
    assert heard[2] == heard[3] and len(heard[2]) == 1 and Lemma1Policy(3) is Lemma1Policy.SHORTEN
