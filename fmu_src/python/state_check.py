"""Checks of what is read from the bytes of a saved state: the launcher's checksum around it can be forged.

Every error raises ValueError; `TableSlave` turns it into one sentence.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from math import isfinite, isnan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from psp_model.law.potential import V_OLD, PotentialParameters
from psp_model.parameters import ALPHA_MAX, ALPHA_MIN, P_MAX, P_MIN, PlatoonParameters
from psp_model.sampling.clock import MOST_PERIODS, Clock

Vector = NDArray[np.float64]


def require(holds: bool) -> None:
    """Reject the state unless a condition holds."""
    if not holds:
        raise ValueError("no run can come to this state")


def record(value: Any, names: Collection[str]) -> dict[str, Any]:
    """A JSON object with exactly these names."""
    require(isinstance(value, dict) and set(value) == set(names))
    found: dict[str, Any] = value
    return found


def flag(value: Any) -> bool:
    """True or False."""
    require(isinstance(value, bool))
    return bool(value)


def number(value: Any, least: float = -np.inf) -> float:
    """A finite number, not below `least`."""
    require(type(value) in (int, float) and isfinite(value) and value >= least)
    return float(value)


def bound(value: Any) -> float:
    """T_max: a number, possibly infinite."""
    require(type(value) in (int, float) and not isnan(value))
    return float(value)


def count(value: Any, least: int = 0) -> int:
    """A whole number, not below `least` and not above the largest count of periods."""
    require(type(value) is int and least <= value <= MOST_PERIODS)
    return int(value)


def clock(value: Any) -> Clock:
    """Where the last communication point is.

    Parameters
    ----------
    value : from JSON, the fields of a clock by name
    """
    fields = record(value, Clock._fields)
    period, offset = fields["period"], number(fields["offset"])
    require(type(period) is int and abs(period) < MOST_PERIODS and abs(offset) <= 1.0)
    last, doubt = number(fields["last"], 0.0), number(fields["doubt"], 0.0)
    return Clock(number(fields["first"]), number(fields["time"]), period, offset, last, doubt)


def fresh(here: Clock) -> None:
    """Reject a clock that has passed a step before anything exists that could have made the step.

    Parameters
    ----------
    here : the clock
    """
    require(-1.0 <= here.period + here.offset <= 0.0 and here.last == here.doubt == 0.0)


def vector(value: Any, size: int) -> Vector:
    """Finite numbers, (size,)."""
    require(isinstance(value, list) and len(value) == size)
    return np.array([number(one) for one in value], dtype=float)


def variables(value: Any, integers: Sequence[bool]) -> tuple[float, ...]:
    """Values of variables as a host may have set them; whole where the variable is an Integer.

    Parameters
    ----------
    value : from JSON
    integers : for each variable, whether it is one
    """
    require(isinstance(value, list) and len(value) == len(integers))
    for one, integer in zip(value, integers, strict=True):
        require(type(one) in (int, float))
        require(not integer or (isfinite(one) and one == int(one)))
    return tuple(map(float, value))


def potential(value: Any, constants: PlatoonParameters, old: bool) -> PotentialParameters:
    """A potential that can have been selected.

    Parameters
    ----------
    value : from JSON
    constants : of the model
    old : whether it is V_old
    """
    fields = record(value, PotentialParameters.__dataclass_fields__)
    shape = PotentialParameters(**{name: number(one) for name, one in fields.items()})
    if old:
        require(shape == V_OLD)
    else:
        require(shape.hill == 1.0 and ALPHA_MIN <= shape.alpha <= ALPHA_MAX and P_MIN <= shape.p <= P_MAX)
        require(constants.L < shape.r <= constants.lam)
    return shape
