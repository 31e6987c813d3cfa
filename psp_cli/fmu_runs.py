"""Runs of an FMU of ours by fmpy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import isfinite
from pathlib import Path
from tempfile import gettempdir
from typing import Any

from fmu_src.python.surroundings import NOEXEC
from psp_model.errors import parts_of

from .bad_input import BadInput
from .options import require_countable
from .scenario import Scenario


@dataclass(frozen=True, eq=False)
class FmuRun:
    """What an FMU put out.

    Attributes
    ----------
    result : structured array, as fmpy returns it
    warnings : sentences that it logged
    """

    result: Any
    warnings: tuple[str, ...]


def inspect(fmu: Path) -> Any:
    """The model description of an FMU of ours.

    Parameters
    ----------
    fmu : the file

    Raises
    ------
    BadInput : where it is missing, unreadable or not ours
    """
    description = description_of(fmu)
    if not any(variable.name == "s_start[2]" for variable in description.modelVariables):
        raise BadInput(f"{fmu} is the FMU {description.modelName!r}, not a platoon: give one that `psp build` made")
    _require_starts(fmu, description)
    return description


def _require_starts(fmu: Path, description: Any) -> None:
    """Check that there is a T above 0, and that every parameter starts with a number."""
    starts = {variable.name: variable.start for variable in parameters_of(description)}
    for name, start in ({"T": None} | starts).items():
        try:
            makes_sense = isfinite(float(start)) and (name != "T" or float(start) > 0)
        except (TypeError, ValueError):
            makes_sense = False
        if not makes_sense:
            raise BadInput(f"{fmu} starts its parameter {name} with {start!r}, which cannot be: build the FMU anew")


def description_of(fmu: Path) -> Any:
    """The model description of any FMU.

    Parameters
    ----------
    fmu : the file

    Raises
    ------
    BadInput : where it is missing or unreadable
    """
    from fmpy import read_model_description

    if not fmu.exists():
        raise BadInput(f"{fmu} does not exist: build it with `psp build`, or give the path of an FMU")
    try:
        return read_model_description(str(fmu))
    except Exception as error:  # fmpy raises whatever its zip and XML readers do
        raise BadInput(
            f"{fmu} cannot be read as an FMU ({error}): give the path of one that `psp build` made"
        ) from None


def vehicles_of(description: Any) -> int:
    """Number of vehicles of an FMU of ours.

    Parameters
    ----------
    description : from `inspect`
    """
    return sum(variable.name.startswith("v_start[") for variable in description.modelVariables)


def parameters_of(description: Any) -> list[Any]:
    """The parameters of an FMU, in its order.

    Parameters
    ----------
    description : from `inspect`
    """
    return [variable for variable in description.modelVariables if variable.causality == "parameter"]


def run_fmu(fmu: Path, description: Any, scenario: Scenario, values: Mapping[str, float]) -> FmuRun:
    """Run an FMU from time 0.

    Parameters
    ----------
    fmu, description : the file and what `inspect` says of it
    scenario : duration and communication step
    values : parameter values in SI units

    Raises
    ------
    BadInput : with the sentence that the FMU logged where it refused
    """
    from tempfile import TemporaryDirectory

    from fmpy import extract, simulate_fmu

    log: list[tuple[int, str]] = []

    def logger(_environment: Any, _instance: Any, status: int, _category: Any, message: Any) -> None:
        log.append((status, message.decode(errors="replace") if isinstance(message, bytes) else str(message)))

    integers = {variable.name for variable in description.modelVariables if variable.type == "Integer"}
    start_values = {name: int(value) if name in integers else value for name, value in values.items()}
    step = scenario.step or values.get("T") or float(_start(description, "T"))
    require_countable(replace(scenario, step=step))
    try:
        with TemporaryDirectory() as folder:
            result = simulate_fmu(
                extract(str(fmu), folder),
                start_values=start_values,
                stop_time=scenario.duration,
                step_size=step,
                output_interval=step,
                debug_logging=True,  # without it an FMU tells of errors only
                logger=logger,
            )
    except Exception as error:  # fmpy's own exceptions say which call failed; the FMU's sentence says why
        sentences = [message for status, message in log if status >= _ERROR]
        problem, remedy = parts_of(sentences[-1] if sentences else _of_the_host(fmu, error))
        raise BadInput(problem, remedy) from None
    return FmuRun(result, tuple(message for status, message in log if status == _WARNING))


_WARNING, _ERROR = 1, 3  # fmi2Status


def _of_the_host(fmu: Path, error: Exception) -> str:
    """What fmpy says against an FMU that says nothing itself."""
    if NOEXEC not in str(error):
        return f"{fmu} failed: {error}"
    return (
        f"{fmu} was extracted to {gettempdir()}, and its library cannot be loaded from there, because that file system "
        "is mounted noexec: set TMPDIR to a folder on another one"
    )


def _start(description: Any, name: str) -> Any:
    return next(variable.start for variable in description.modelVariables if variable.name == name)


def listing(description: Any) -> str:
    """Name, unit, start value and meaning of every parameter.

    Parameters
    ----------
    description : from `inspect`
    """
    rows = [["parameter", "start", "unit", "meaning"]]
    rows += [[v.name, str(v.start), v.unit or "1", v.description] for v in parameters_of(description)]
    width = [max(len(row[i]) for row in rows) for i in range(3)]
    return "\n".join(f"{a:<{width[0]}}  {b:>{width[1]}}  {c:<{width[2]}}  {d}" for a, b, c, d in rows)


def as_dict(description: Any) -> list[dict[str, Any]]:
    """The same for JSON.

    Parameters
    ----------
    description : from `inspect`
    """
    return [
        {"name": v.name, "start": float(v.start), "unit": v.unit or "1", "meaning": v.description}
        for v in parameters_of(description)
    ]
