"""Short forms of the road tables (`python -m benchmarks.road`): nobody touches, and disturbances do not grow."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from benchmarks.road import BEHAVIOUR, CONSTANTS, FULL, LIMITS, RADAR, TRUE, Setting, believed, hopeless, leaders, trial
from psp_model import BEST_FIXED, StartDomain
from psp_model.law.cooperation import Cooperation
from psp_model.parameters import Actuation
from psp_model.vehicles.delayed import DelayedVehicles
from psp_model.vehicles.road_law import RoadLaw
from psp_model.vehicles.road_run import Sensing, run_on_road, started

SETTING = Setting(6, 0.05, None)
CLEARANCES = (7.0, 11.0)


@pytest.mark.parametrize(
    ("leader", "least"), [("wave", 5.0), ("2.5 m/s2 to standstill", 4.0), ("6 m/s2 to standstill", 1.8)]
)
@pytest.mark.parametrize("share", [0.7, 1.0, 1.3])
def test_nobody_touches_a_foreign_leader(leader: str, least: float, share: float) -> None:
    law = RoadLaw(BEST_FIXED, CONSTANTS, FULL, believed(share))
    sensing = Sensing(SETTING.old, 0.1, 0.1)
    run = trial(SETTING, law, TRUE, leaders(SETTING)[leader], CLEARANCES, sensing)
    assert run.least.min() > least
    assert run.gain(-1, 1) < 1.02


def test_without_a_predictor_it_is_touched() -> None:
    law = RoadLaw(BEST_FIXED, CONSTANTS, Cooperation(feedforward=0.0))
    assert trial(SETTING, law, TRUE, leaders(SETTING)["wave"], CLEARANCES, Sensing(SETTING.old)).touched.any()


@pytest.mark.parametrize("leader", ["wave", "8 m/s2 to standstill"])
def test_radar_alone_is_enough_at_a_time_gap_of_1_s(leader: str) -> None:
    law = RoadLaw(RADAR, CONSTANTS, Cooperation(kappa=1.0, time_gap=1.0, following=2, feedforward=0.0), TRUE)
    run = trial(SETTING, law, TRUE, leaders(SETTING)[leader], (37.0, 41.0), Sensing(SETTING.old, known=False))
    assert run.least.min() > 2.5
    assert run.gain(-1, 0) < 1.0 and run.gain(-1, 1) < 1.0


@pytest.mark.parametrize(("delay", "lag"), [(0.3, 0.3), (0.5, 0.5)])
def test_the_paper_s_starts_bear_dead_time_and_lag(delay: float, lag: float) -> None:
    s, v = StartDomain().draw(np.random.default_rng(11), 7, 40)
    true = Actuation(delay, lag, **LIMITS)
    lost = hopeless(s, v, true)
    law = RoadLaw(BEST_FIXED, CONSTANTS, FULL, true, SETTING.T)
    run = run_on_road(started(DelayedVehicles(true), s, v), law, true, None, {}, 200)
    assert not (run.touched & ~lost).any() and not lost.all()


def test_a_platoon_closes_up() -> None:
    """From 38 to 48 m to at most 20 m within 60 s, gently, and stays apart."""
    rng = np.random.default_rng(5)
    s, v = rng.uniform(38, 48, (6, 4)), np.full((7, 4), 27.0)
    law = RoadLaw(BEST_FIXED, replace(CONSTANTS, v_star=27.0), Cooperation(closing_speed=0.6), TRUE, 0.1)
    run = run_on_road(started(DelayedVehicles(TRUE), s, v), law, TRUE, None, {}, 600)
    assert run.vehicles.s.max() <= 20.0
    assert run.largest.max() <= 1.5
    run = run_on_road(run, law, TRUE, None, {}, 400)
    assert run.least.min() > 9.0


@pytest.mark.parametrize("name", sorted(BEHAVIOUR))
def test_tables_are_made(name: str, capsys: Any) -> None:
    BEHAVIOUR[name](Setting(2, 0.1, None))
    shown = capsys.readouterr().out
    assert "touch" not in shown.replace("touch under any law", "").replace("how many of them touch", "")
    assert shown.count("|") > 10
