"""Scenario files: TOML, checked against a schema, with the line number where something is wrong."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import AliasChoices, BaseModel, ConfigDict, Field, ValidationError

from psp_model import PspError, StartDomain

from .bad_input import BadInput
from .quantities import MOST_VEHICLES, quantity
from .settings import checked

Number = Annotated[float, Field(strict=True)] | Annotated[str, Field(strict=True)]
"""A number in SI units, or a text of number and unit."""


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid")


class StartTable(_Strict):
    """`[start]`: spacings (`gaps` in older files) and speeds, or a seed to draw them from the training domain."""

    spacings: Annotated[list[Number] | None, Field(validation_alias=AliasChoices("spacings", "gaps"))] = None
    speeds: list[Number] | None = None
    position: Number = 0.0
    seed: Annotated[int, Field(ge=0)] | None = None


class RunTable(_Strict):
    """`[[runs]]`: one run of several, with parameters of its own."""

    name: Annotated[str, Field(min_length=1)]
    set: dict[str, Number] = {}


class ScenarioTable(_Strict):
    """The whole file."""

    fmu: str | None = None
    vehicles: Annotated[int, Field(ge=2, le=MOST_VEHICLES)] = 7
    duration: Number = 20.0
    step: Number | None = None
    start: StartTable = StartTable()
    set: dict[str, Number] = {}
    runs: list[RunTable] = []


@dataclass(frozen=True)
class Scenario:
    """What a scenario file says, in SI units.

    Attributes
    ----------
    vehicles : n
    duration : of the run [s]
    step : communication step [s], None for the sampling period
    values : parameters of the FMU by name
    runs : values on top of these, by the name of the run; empty where the file names none
    fmu : path of the FMU, None where the file names none
    """

    vehicles: int = 7
    duration: float = 20.0
    step: float | None = None
    values: dict[str, float] = field(default_factory=dict)
    runs: dict[str, dict[str, float]] = field(default_factory=dict)
    fmu: Path | None = None


def read_scenario(path: Path) -> Scenario:
    """A scenario from its file.

    Parameters
    ----------
    path : TOML file

    Raises
    ------
    BadInput : with the file, and the line where there is one
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(f"{path} cannot be read as a scenario ({error}): give the path of a TOML file") from None
    try:
        table = ScenarioTable.model_validate(tomllib.loads(text))
    except tomllib.TOMLDecodeError as error:
        place = re.search(r"line (\d+)", str(error))
        line = place[1] if place else str(text.count("\n") + 1)
        raise BadInput(f"{path}:{line}: not TOML ({error}): write it as key = value") from None
    except RecursionError:
        raise BadInput(f"{path}: tables or lists are nested too deeply: a scenario needs no more than three") from None
    except OverflowError:
        raise BadInput(f"{path}: a number is too large: give it in SI units or with its unit") from None
    except ValidationError as error:  # a ValueError too
        first = error.errors()[0]
        location = tuple(part for part in first["loc"] if part not in ("float", "str"))
        raise BadInput(f"{path}:{line_of(text, location)}: {_dotted(location)}: {_reason(first)}") from None
    except ValueError as error:  # an integer of thousands of digits
        raise BadInput(f"{path}: not TOML ({error}): write it as key = value") from None
    return _in_si_units(table, text, path)


def _reason(error: Any) -> str:
    """What is wrong, with the value and the remedy."""
    if error["type"] == "extra_forbidden":
        return "no such key: remove it, or see the documentation for the keys there are"
    return f"{error['input']!r} will not do: {error['msg'][0].lower()}{error['msg'][1:]}"


def _dotted(location: tuple[Any, ...]) -> str:
    return ".".join(str(part) for part in location)


def line_of(text: str, location: tuple[Any, ...]) -> int:
    """The line of a TOML file that a key stands in; that of the closest enclosing key or table where it has none.

    Parameters
    ----------
    text : the file
    location : keys, and indices of arrays of tables, from the outside in

    Returns
    -------
    line number, from 1
    """
    best, depth = 1, 0
    here: tuple[Any, ...] = ()
    counts: dict[str, int] = {}
    for number, line in enumerate(text.splitlines(), start=1):
        if header := re.match(r"\s*\[\[\s*([\w.-]+)\s*\]\]", line):
            counts[header[1]] = counts.get(header[1], -1) + 1
            here = (*header[1].split("."), counts[header[1]])
            found = here
        elif header := re.match(r"\s*\[\s*([\w.-]+)\s*\]", line):
            here = found = tuple(header[1].split("."))
            # a subtable of the last entry of an array of tables
            if here[0] in counts:
                here = found = (here[0], counts[here[0]], *here[1:])
        elif key := re.match(r"""\s*("[^"]*"|'[^']*'|[\w.-]+)\s*=""", line):
            found = (*here, key[1].strip("\"'"))
        else:
            continue
        if len(found) > depth and found == location[: len(found)]:
            best, depth = number, len(found)
    return best


def _in_si_units(table: ScenarioTable, text: str, path: Path) -> Scenario:
    """Convert units and start values; errors get the line of their key."""

    def at(location: tuple[Any, ...], convert: Any) -> Any:
        try:
            return convert()
        except PspError as error:
            raise BadInput(f"{path}:{line_of(text, location)}: {error.problem}", error.remedy) from None

    n = table.vehicles
    values: dict[str, float] = at(("start",), lambda: start_values(table.start, n))
    for name, value in table.set.items():
        values |= at(("set", name), lambda name=name, value=value: checked({name: value}, n))
    runs: dict[str, dict[str, float]] = {}
    for index, run in enumerate(table.runs):
        runs[run.name] = {}
        for name, value in run.set.items():
            here = ("runs", index, "set", name)
            runs[run.name] |= at(here, lambda name=name, value=value: checked({name: value}, n))
    duration = at(("duration",), lambda: _positive(table.duration, "duration"))
    step = None if table.step is None else at(("step",), lambda: _positive(table.step, "step"))
    fmu = None if table.fmu is None else path.parent / table.fmu
    return Scenario(n, duration, step, values, runs, fmu)


def _positive(given: Any, name: str) -> float:
    time = quantity(given, "s", name)
    if not 0 < time < float("inf"):
        raise BadInput(f"{name} = {time:g} s must be positive: give it a time above 0 s")
    return time


def start_values(start: StartTable, vehicles: int) -> dict[str, float]:
    """The initial state as values of the FMU's parameters.

    Parameters
    ----------
    start : the table `[start]`
    vehicles : n

    Raises
    ------
    BadInput : where the table says too little, too much, or the wrong number of values
    """
    if start.seed is not None and (start.spacings or start.speeds):
        raise BadInput("start has a seed besides spacings or speeds: give the values, or the seed to draw them by")
    if start.seed is not None:
        return drawn(start.seed, vehicles)
    values = {"x_start": quantity(start.position, "m", "position")} if start.position else {}
    for given, letter, unit, count in (
        (start.spacings, "s", "m", vehicles - 1),
        (start.speeds, "v", "m/s", vehicles),
    ):
        if given is None:
            continue
        word = "spacings" if letter == "s" else "speeds"
        if len(given) != count:
            raise BadInput(f"{len(given)} {word} do not fit {vehicles} vehicles: give {count}")
        first = vehicles - count + 1
        for i, value in enumerate(given, start=first):
            values[f"{letter}_start[{i}]"] = quantity(value, unit, f"{letter}_start[{i}]")
    return values


def drawn(seed: int, vehicles: int, domain: StartDomain | None = None) -> dict[str, float]:
    """A start drawn from the networks' training domain, as values of the FMU's parameters.

    Parameters
    ----------
    seed : of the draw
    vehicles : n
    domain : the paper's by default
    """
    s, v = (domain or StartDomain()).draw(np.random.default_rng(seed), vehicles, 1)
    values = {f"s_start[{i}]": float(spacing) for i, spacing in enumerate(s[:, 0], start=2)}
    return values | {f"v_start[{i}]": float(speed) for i, speed in enumerate(v[:, 0], start=1)}
