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
    """What one delay, lag or integrator did to one potential, the worst of several starts.

    Attributes
    ----------
    driver : name
    disturbance : that was in effect
    starts, collided, uncertified, outside : starts that were run, of which vehicles touched, T was not certified at a
        sampling instant, a measurement lay outside the state space
    gap_min : smallest free space [m]
    first : when the first of these happened [s], infinite if never
    a_rms : largest r.m.s. acceleration [m/s2]
    """

    driver: str
    disturbance: Disturbance
    starts: int
    collided: int
    uncertified: int
    outside: int
    gap_min: float
    first: float
    a_rms: float


def sweep(
    fmu: Path, situations: Sequence[Scenario], delays: Sequence[float], lags: Sequence[float]
) -> Iterator[Tolerance]:
    """Delay alone, lag alone, and SUMO's ballistic step, for V_new and V_old.

    Parameters
    ----------
    fmu : PspController
    situations : to run with each
    delays, lags : [s]
    """
    cases = [Disturbance(delay=delay) for delay in delays] + [Disturbance(lag=lag) for lag in lags if lag > 0]
    cases.append(Disturbance(ballistic=True))
    for driver in controllers(fmu):
        for disturbance in cases:
            yield _tolerance(situations, driver, disturbance)


def _tolerance(situations: Sequence[Scenario], driver: Driver, disturbance: Disturbance) -> Tolerance:
    records = [simulate(one, driver, disturbance=disturbance) for one in situations]
    rows = [measure(record, one) for record, one in zip(records, situations, strict=True)]
    uncertified = [record.reports["uncertified_from"] for record in records]
    outside = [record.reports["fault_from"] for record in records]
    return Tolerance(
        driver.name,
        disturbance,
        starts=len(rows),
        collided=sum(row.collisions > 0 for row in rows),
        uncertified=int(np.isfinite(uncertified).sum()),
        outside=int(np.isfinite(outside).sum()),
        gap_min=min(row.gap_min for row in rows),
        first=min(uncertified + outside),
        a_rms=max(row.a_rms for row in rows),
    )


def tolerance_table(rows: Sequence[Tolerance]) -> str:
    """A Markdown table of a sweep.

    Parameters
    ----------
    rows : from `sweep`
    """
    head = "| potential | delay [s] | lag [s] | step | starts | collided | T >= T_max | outside Omega | first [s] "
    lines = [head + "| least free gap [m] | r.m.s. a [m/s2] |", "|---" * 11 + "|"]
    for row in rows:
        d, first = row.disturbance, "-" if np.isinf(row.first) else f"{row.first:.2f}"
        kind = "ballistic" if d.ballistic else "Euler"
        lines.append(
            f"| {row.driver} | {d.delay:g} | {d.lag:g} | {kind} | {row.starts} | {row.collided} | {row.uncertified} "
            f"| {row.outside} | {first} | {row.gap_min:.2f} | {row.a_rms:.2f} |"
        )
    return "\n".join(lines)
