"""Which delay and lag are tolerated together, with V_new and V_old."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np

from .driver import Driver, controllers
from .measures import contact, spacings
from .results import Results, Row
from .scenario import LENGTH, Scenario
from .simulation import Disturbance, simulate

DELAYS = (0.0, 0.1, 0.2, 0.3, 0.5, 0.7)  # [s] of the sensors
LAGS = (0.0, 0.1, 0.2, 0.3, 0.5, 0.8)  # [s] of the actuators
DURATIONS = {"highway": 20.0, "stop-and-go": 60.0}  # [s] a little more than one wave


@dataclass(frozen=True)
class Trial:
    """One run, which ends when two vehicles touch.

    Attributes
    ----------
    contact : when they do [s], infinite if never
    violation : the first sampling instant with T >= T_max or with a measurement outside the state space [s], infinite
        if there was none
    clearance_min : smallest clearance, 0 if vehicles touched [m]
    a_rms : r.m.s. acceleration [m/s2]
    """

    contact: float
    violation: float
    clearance_min: float
    a_rms: float


@dataclass(frozen=True)
class Tolerance:
    """The effect of a delay and a lag on one driver from several starts.

    Attributes
    ----------
    trials : one for each start
    """

    trials: tuple[Trial, ...]

    @property
    def collided(self) -> int:
        """Number of starts in which vehicles touched."""
        return sum(np.isfinite(trial.contact) for trial in self.trials)

    @property
    def violated(self) -> int:
        """Number of starts with a violation."""
        return sum(np.isfinite(trial.violation) for trial in self.trials)

    @property
    def first(self) -> float:
        """The earliest contact or violation [s]."""
        return min(min(trial.contact, trial.violation) for trial in self.trials)

    @property
    def clearance_min(self) -> float:
        """The smallest clearance [m]."""
        return min(trial.clearance_min for trial in self.trials)


Case = tuple[str, float, float]  # driver, delay [s], lag [s]


def swept(fmu: Path, led: bool) -> list[Driver]:
    """The controllers of a sweep; behind a leader they receive its speed.

    Parameters
    ----------
    fmu : PspController
    led : whether the leader drives a speed of its own
    """
    return [driver for driver in controllers(fmu, led=led) if driver.follows is led]


def sweep(
    starts: Mapping[int, Scenario],
    fmu: Path,
    results: Results,
    delays: Sequence[float] = DELAYS,
    lags: Sequence[float] = LAGS,
    progress: Callable[[], None] = lambda: None,
) -> dict[Case, Tolerance]:
    """Every delay with every lag, for V_new and V_old.

    Parameters
    ----------
    starts : of one situation, by seed
    fmu : PspController
    results : where runs are kept
    delays, lags : [s]
    progress : called after each run
    """
    led = next(iter(starts.values())).leader is not None
    found: dict[Case, list[Trial]] = {}
    for driver, delay, lag, (seed, scenario) in product(swept(fmu, led), delays, lags, starts.items()):
        name = f"{scenario.name}; {driver.name}; start {seed}; delay {delay:g} s; lag {lag:g} s"
        row = results.run(name, partial(_try, scenario, driver, Disturbance(delay, lag), seed))
        found.setdefault((driver.name, delay, lag), []).append(Trial(**row))
        progress()
    return {case: Tolerance(tuple(trials)) for case, trials in found.items()}


def _try(scenario: Scenario, driver: Driver, disturbance: Disturbance, seed: int) -> Row:
    record = simulate(scenario, driver, seed=seed, disturbance=disturbance, to_contact=True)
    step = scenario.duration if record.time.size < 2 else float(record.time[1] - record.time[0])
    a = np.diff(record.v, axis=0) / step
    trial = Trial(
        contact=contact(record),
        violation=min(record.reports["uncertified_from"], record.reports["fault_from"]),
        clearance_min=max(float(np.nanmin(spacings(record)[0])) - LENGTH, 0.0),
        a_rms=float(np.sqrt((a**2).mean())),
    )
    return asdict(trial)


def of_sweep(runs: Mapping[str, Row], scenario: str) -> dict[Case, Tolerance]:
    """What `sweep` returned, from runs that were kept.

    Parameters
    ----------
    runs : by name
    scenario : name of the situation
    """
    trials: dict[Case, list[Trial]] = {}
    for name, row in runs.items():
        situation, driver, _, delay, lag = name.split("; ")
        if situation == scenario:
            case = driver, float(delay.split()[1]), float(lag.split()[1])
            trials.setdefault(case, []).append(Trial(**row))
    return {case: Tolerance(tuple(rows)) for case, rows in trials.items()}


def tolerance_table(found: Mapping[Case, Tolerance], driver: str) -> str:
    """A Markdown table: delays down, lags across.

    A cell says in how many starts vehicles touched and when the first contact or violation came; if none touched,
    the least clearance.

    Parameters
    ----------
    found : from `sweep`
    driver : its name
    """
    (corner, *lags), *rows = cells(found, driver)
    lines = [f"| {corner} | " + " | ".join(lags) + " |", "|---" * (len(lags) + 1) + "|"]
    lines += [f"| **{delay}** | " + " | ".join(line) + " |" for delay, *line in rows]
    return "\n".join(lines)


def cells(found: Mapping[Case, Tolerance], driver: str) -> list[list[str]]:
    """The same table as rows of cells, the first with the lags, each other with its delay before it.

    Parameters
    ----------
    found : from `sweep`
    driver : its name
    """
    delays = sorted({delay for name, delay, _ in found if name == driver})
    lags = sorted({lag for name, _, lag in found if name == driver})
    rows = [[f"{delay:g} s", *(_cell(found[driver, delay, lag]) for lag in lags)] for delay in delays]
    return [["delay \\ lag", *(f"{lag:g} s" for lag in lags)], *rows]


def _cell(row: Tolerance) -> str:
    if row.collided:
        return f"{row.collided} of {len(row.trials)}, {row.first:.1f} s"
    warned = f"; {row.violated} not certified, {row.first:.1f} s" if row.violated else ""
    return f"{row.clearance_min:.2f} m{warned}"


def announced(trials: Sequence[Trial]) -> str:
    """How many contacts there were, and how long before each T_max or the state space gave a warning.

    Parameters
    ----------
    trials : the runs
    """
    touched = [trial for trial in trials if np.isfinite(trial.contact)]
    times = [trial.contact - trial.violation for trial in touched if trial.violation < trial.contact]
    text = f"contacts {len(touched)} in {len(trials)} runs, without a violation before {len(touched) - len(times)}"
    if times:
        text += f", otherwise {min(times):.2f} to {max(times):.2f} s before (median {float(np.median(times)):.2f} s)"
    return text


def title(scenario: str, starts: int) -> str:
    """The heading of a sweep.

    Parameters
    ----------
    scenario : name of the situation
    starts : how many there are
    """
    return f"{scenario}, starts: {starts}"


def sweep_text(found: Mapping[Case, Tolerance]) -> str:
    """The tables of a sweep in Markdown, and below each how contacts were announced.

    Parameters
    ----------
    found : from `sweep`
    """
    parts = [f"{driver}:\n\n{tolerance_table(found, driver)}\n\n{told_of(found, driver)}" for driver in swept_of(found)]
    return "\n\n".join(parts)


def swept_of(found: Mapping[Case, Tolerance]) -> list[str]:
    """The names of the drivers of a sweep.

    Parameters
    ----------
    found : from `sweep`
    """
    return list(dict.fromkeys(name for name, *_ in found))


def told_of(found: Mapping[Case, Tolerance], driver: str) -> str:
    """How one driver's contacts were announced, without delay and with delay.

    Parameters
    ----------
    found : from `sweep`
    driver : its name
    """
    of_driver = {case: row for case, row in found.items() if case[0] == driver}
    prompt = [trial for (_, delay, _), row in of_driver.items() if delay == 0 for trial in row.trials]
    late = [trial for (_, delay, _), row in of_driver.items() if delay > 0 for trial in row.trials]
    return f"Without delay: {announced(prompt)}. With delay: {announced(late)}."
