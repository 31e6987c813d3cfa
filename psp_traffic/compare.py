"""The comparison of drivers in several situations, each from several starts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, fields, replace
from functools import partial
from pathlib import Path

from psp_model.vehicles.leader import Profile

from .driver import Driver, controllers, sumo_drivers
from .measures import Measures, measure
from .results import Results, Row
from .scenario import Scenario, highway, highway_apart, on_profile, ramp, stop_and_go
from .simulation import simulate

SITUATIONS = ("highway", "highway-apart", "ramp", "stop-and-go", "profile")


def situation(name: str, seed: int, duration: float | None = None, profile: Profile | None = None) -> Scenario:
    """One start of a traffic situation.

    Parameters
    ----------
    name : of SITUATIONS
    seed : of the start
    duration : instead of the default [s]
    profile : of the leader, if there is one; by default phase High of the WLTC
    """
    makers: dict[str, Callable[[], Scenario]] = {
        "highway": lambda: highway(seed=seed),
        "highway-apart": lambda: highway_apart(seed=seed),
        "ramp": lambda: ramp(seed=seed),
        "stop-and-go": lambda: stop_and_go(seed=seed),
        "profile": lambda: on_profile(seed=seed, profile=profile),
    }
    found = makers[name]()
    return found if duration is None else replace(found, duration=duration)


def drivers(fmu: Path, led: bool) -> list[Driver]:
    """All drivers compared.

    Parameters
    ----------
    fmu : PspController
    led : whether the leader drives a speed of its own
    """
    return [*controllers(fmu, led=led), *sumo_drivers()]


def compare(
    starts: Mapping[int, Scenario], fmu: Path, results: Results, progress: Callable[[], None] = lambda: None
) -> dict[str, list[Measures]]:
    """The measures of all drivers in one situation.

    Parameters
    ----------
    starts : of the situation, by seed
    fmu : PspController, for as many vehicles as there are
    results : where runs are kept
    progress : called after each run

    Returns
    -------
    measures of the starts by name of the driver
    """
    rows: dict[str, list[Measures]] = {}
    led = next(iter(starts.values())).leader is not None
    for seed, scenario in starts.items():
        for driver in drivers(fmu, led):
            name = f"{scenario.name}; {driver.name}; start {seed}"
            row = results.run(name, partial(_run, scenario, driver, seed))
            rows.setdefault(driver.name, []).append(_measures(row))
            progress()
    return rows


def _run(scenario: Scenario, driver: Driver, seed: int) -> Row:
    record = simulate(scenario, driver, seed=seed)
    return asdict(measure(record, scenario)) | record.reports


def _measures(row: Row) -> Measures:
    found = {field.name: row[field.name] for field in fields(Measures)}
    return Measures(**(found | {"collisions": int(row["collisions"])}))  # type: ignore[arg-type]


def of_situation(runs: Mapping[str, Row], name: str) -> dict[str, list[Measures]]:
    """What `compare` returned for a situation, from runs that were kept.

    Parameters
    ----------
    runs : by name
    name : of the situation
    """
    rows: dict[str, list[Measures]] = {}
    for key, row in runs.items():
        situation_of, driver, _ = key.split("; ", 2)
        if situation_of == name:
            rows.setdefault(driver, []).append(_measures(row))
    return rows


def title(scenario: Scenario, starts: int) -> str:
    """The heading of a table.

    Parameters
    ----------
    scenario : one start of the situation
    starts : how many there are
    """
    return f"**{scenario.name}**, {scenario.vehicles} vehicles, {scenario.duration:g} s, starts: {starts}"


def count(names: Iterable[str], starts: int) -> int:
    """How many runs a comparison takes.

    Parameters
    ----------
    names : of the situations
    starts : of each
    """
    wanted: Sequence[str] = list(names)
    led = sum(name in ("stop-and-go", "profile") for name in wanted)
    return starts * (5 * len(wanted) + 2 * led)
