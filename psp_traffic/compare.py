"""The comparison of drivers, and how far delay and lag may go."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from .driver import Driver, controllers, sumo_drivers
from .measures import Measures, measure
from .scenario import Scenario, highway, ramp, stop_and_go
from .simulation import Disturbance, simulate

DELAYS = (0.0, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0)  # [s] of the sensors
LAGS = (0.0, 0.1, 0.2, 0.3, 0.5, 0.8, 1.2)  # [s] of the actuators


def scenarios(seed: int, duration: float | None = None) -> list[Scenario]:
    """The three traffic situations.

    Parameters
    ----------
    seed : of the starts
    duration : of all of them instead of their own [s]
    """
    found = [highway(seed=seed), ramp(seed=seed), stop_and_go()]
    return found if duration is None else [replace(one, duration=duration) for one in found]


def compare(
    scenario: Scenario, fmu: Path, seed: int, progress: Callable[[str], None] = lambda line: None
) -> dict[str, Measures]:
    """The measures of all drivers in one scenario.

    Parameters
    ----------
    scenario : to run
    fmu : PspController, for as many vehicles as there are
    seed : of SUMO
    progress : called with one line for each run of the controller
    """
    rows = {}
    for driver in (*controllers(fmu, wave=scenario.wave), *sumo_drivers()):
        record = simulate(scenario, driver, seed=seed)
        rows[driver.name] = measure(record, scenario)
        if record.reports:
            told = ", ".join(f"{name} = {value:.4g}" for name, value in record.reports.items())
            progress(f"{scenario.name}, {driver.name}: {told}")
    return rows


@dataclass(frozen=True)
class Tolerance:
    """What one delay, lag and integrator did to one potential.

    Attributes
    ----------
    driver : name
    disturbance : that was in effect
    measures : of the run
    uncertified_from : first sampling instant with T >= T_max [s], infinite if none
    outside_from : first measurement outside the state space [s], infinite if none
    """

    driver: str
    disturbance: Disturbance
    measures: Measures
    uncertified_from: float
    outside_from: float


def sweep(fmu: Path, scenario: Scenario, delays: Sequence[float], lags: Sequence[float]) -> Iterator[Tolerance]:
    """Delay alone, lag alone, and SUMO's ballistic step, for V_new and V_old.

    Parameters
    ----------
    fmu : PspController
    scenario : to run
    delays, lags : [s]
    """
    cases = [Disturbance(delay=delay) for delay in delays] + [Disturbance(lag=lag) for lag in lags if lag > 0]
    cases.append(Disturbance(ballistic=True))
    for driver in controllers(fmu):
        for disturbance in cases:
            yield _tolerance(scenario, driver, disturbance)


def _tolerance(scenario: Scenario, driver: Driver, disturbance: Disturbance) -> Tolerance:
    record = simulate(scenario, driver, disturbance=disturbance)
    told = record.reports
    measures = measure(record, scenario)
    return Tolerance(driver.name, disturbance, measures, told["uncertified_from"], told["fault_from"])


def tolerance_table(rows: Sequence[Tolerance]) -> str:
    """A Markdown table of a sweep.

    Parameters
    ----------
    rows : from `sweep`
    """
    head = "| potential | delay [s] | lag [s] | step | collisions | least free gap [m] | not certified from [s] "
    lines = [head + "| outside Omega from [s] | r.m.s. a [m/s2] |", "|---" * 9 + "|"]
    for row in rows:
        d, m = row.disturbance, row.measures
        times = " | ".join("-" if np.isinf(t) else f"{t:.2f}" for t in (row.uncertified_from, row.outside_from))
        kind = "ballistic" if d.ballistic else "Euler"
        lines.append(
            f"| {row.driver} | {d.delay:g} | {d.lag:g} | {kind} | {m.collisions} | {m.gap_min:.2f} | {times} "
            f"| {m.a_rms:.2f} |"
        )
    return "\n".join(lines)
