"""Numbers with units, as people type them: `0.01`, `10 ms`, `108 km/h`."""

from __future__ import annotations

import re

from .bad_input import BadInput

MOST_VEHICLES = 10_000  # that a command takes: memory and time grow with them

_FACTORS: dict[str, dict[str, float]] = {
    "s": {"s": 1.0, "ms": 1e-3, "min": 60.0},
    "m": {"m": 1.0, "km": 1e3, "cm": 1e-2},
    "m/s": {"m/s": 1.0, "km/h": 1.0 / 3.6},
    "m/s2": {"m/s2": 1.0, "m/s²": 1.0, "m/s^2": 1.0},
    "1/s": {"1/s": 1.0},
    "1": {"": 1.0, "1": 1.0},
}
_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?inf|nan)\s*(.*?)\s*", re.IGNORECASE)


def quantity(given: str | float, unit: str, name: str) -> float:
    """A number in the SI unit that the model uses.

    Parameters
    ----------
    given : a number, taken as it is, or a text of number and unit, converted
    unit : SI unit wanted, a key of the table above
    name : what the number is for, for the error's sentence

    Returns
    -------
    the number

    Raises
    ------
    BadInput : where the text is no number or its unit does not measure the same
    """
    if not isinstance(given, str):
        try:
            return float(given)
        except OverflowError:
            raise BadInput(f"{name} is too large a number: give it as a number like {_like(unit)}") from None
    match = _NUMBER.fullmatch(given)
    if match is None:
        raise BadInput(
            f"{name} = {given!r} is not a number: give it as a number with or without unit, like {_like(unit)}"
        )
    number, written = float(match[1]), match[2]
    if not written:
        return number
    if written not in _FACTORS[unit]:
        known = ", ".join(filter(None, _FACTORS[unit])) if unit != "1" else "none"
        raise BadInput(f"{name} = {given!r} has the unit {written!r}, which does not fit", f"use one of: {known}")
    return number * _FACTORS[unit][written]


def _like(unit: str) -> str:
    return {"s": "'10 ms'", "m": "'9.5 m'", "m/s": "'108 km/h'"}.get(unit, "'0.5'")
