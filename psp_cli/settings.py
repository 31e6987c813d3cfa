"""Values of the FMU's parameters by name, and what they mean to the model."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from .bad_input import BadInput
from .quantities import quantity

if TYPE_CHECKING:
    from psp_model.analysis.cases import Setup


def parameter_units(vehicles: int) -> dict[str, str]:
    """Unit of every parameter of the FMU for n vehicles, by name.

    Parameters
    ----------
    vehicles : n
    """
    from fmu_src.interface.platoon import platoon_table

    fixed = {"n_start"}  # a command knows how many vehicles there are
    rows = platoon_table(vehicles)
    return {row.name: row.unit for row in rows if row.causality == "parameter" and row.name not in fixed}


def checked(given: Mapping[str, str | float], vehicles: int) -> dict[str, float]:
    """Values in SI units of parameters that exist.

    Parameters
    ----------
    given : numbers or texts of number and unit, by name
    vehicles : n

    Raises
    ------
    BadInput : where a name is not a parameter's or a value is no good, naming what is close
    """
    units = parameter_units(vehicles)
    for name in given:
        if name not in units:
            close = difflib.get_close_matches(name, units, n=3, cutoff=0.5)
            hint = f"did you mean {' or '.join(close)}?" if close else "psp simulate --list shows the names"
            raise BadInput(f"{name!r} is not a parameter of the platoon of {vehicles} vehicles: {hint}")
    return {name: quantity(value, units[name], name) for name, value in given.items()}


def split(assignments: Iterable[str]) -> dict[str, str]:
    """`name=value` texts, as --set takes them, as a dictionary.

    Parameters
    ----------
    assignments : the texts

    Raises
    ------
    BadInput : where one has no equals sign
    """
    values = {}
    for assignment in assignments:
        name, equals, value = assignment.partition("=")
        if not equals:
            raise BadInput(f"--set {assignment!r} has no '=': write it as name=value, for example T='10 ms'")
        values[name.strip()] = value.strip()
    return values


def setup(values: Mapping[str, float], vehicles: int, has_network: bool = True) -> Setup:
    """The model's objects for parameter values, start values of the table where a name is missing.

    Parameters
    ----------
    values : SI values by name of the FMU's parameters
    vehicles : n
    has_network : whether there is a network for n vehicles; as in the FMU, parameter_source starts at 2 without

    Raises
    ------
    ModelError : where a value is outside the model's domain
    BadInput : where a selector has no such choice
    """
    from fmu_src.interface.meaning import (
        constants_of,
        cooperation_of,
        join_margin_of,
        request_of,
        sampling_of,
        start_of,
        weights_of,
    )
    from fmu_src.interface.platoon import platoon_table
    from psp_model.analysis.cases import Setup
    from psp_model.validate import validate_law

    table = platoon_table(vehicles, default_source=1 if has_network else 2)
    read = {row.name: row.start for row in table if row.start is not None} | dict(values)
    for row in table:
        if row.integer:
            _require_choice(row.name, read[row.name], row.minimum, row.maximum)
    value, rows = read.__getitem__, {row.name: row for row in table}
    constants = constants_of(value)
    cooperation = cooperation_of(value, rows, vehicles, constants.L)
    validate_law(cooperation, constants)
    join_margin_of(value)  # nobody joins here, but a value that is no good is no good
    start = start_of(value, vehicles, constants, cooperation)
    return Setup(
        start,
        request_of(value, rows),
        weights_of(value),
        sampling_of(value, rows),
        not has_network and "parameter_source" not in values,
        cooperation,
    )


def _require_choice(name: str, value: float, low: float | None, high: float | None) -> None:
    """Refuse a selector or count that is no whole number inside its bounds."""
    inside = (low is None or value >= low) and (high is None or value <= high)
    if not (inside and float(value).is_integer()):
        upto = "upwards" if high is None else f"to {high:g}"
        raise BadInput(f"{name} = {value:g} is not one of its choices: give it a whole number from {low:g} {upto}")
