"""The meaning of the variables that say what the vehicles of `PspPlant` are; see meaning.py."""

from __future__ import annotations

from math import inf, nextafter
from sys import float_info

import numpy as np
from numpy.typing import NDArray

from psp_model.law.cooperation import Cooperation
from psp_model.parameters import NO_LIMIT, Actuation, PlatoonParameters
from psp_model.sampling.policy import Sampling
from psp_model.validate import validate
from psp_model.vehicles.road_plant import RoadPlant

from .meaning import Read, start_of

_ANYWHERE = PlatoonParameters(L=nextafter(0.0, 1.0), v_max=float_info.max)
"""Constants for a plant, which requires of a start only that vehicles are in order and do not reverse."""


def each_of(read: Read, name: str, n: int) -> NDArray[np.float64]:
    """name[1] to name[n].

    Parameters
    ----------
    read : value by name
    name : of the array
    n : vehicles
    """
    return np.array([read(f"{name}[{i}]") for i in range(1, n + 1)])


def actuation_of(read: Read, n: int) -> Actuation:
    """Dead time, lags and limits of n vehicles.

    Parameters
    ----------
    read : value by name
    n : vehicles

    Raises
    ------
    ModelError : if a value is outside the model's domain
    """
    least, most = each_of(read, "a_min", n), each_of(read, "a_max", n)
    told = validate(Actuation(read("actuation_delay"), each_of(read, "actuator_lag", n), least, most))
    free = np.where(least > -NO_LIMIT, least, -inf), np.where(most < NO_LIMIT, most, inf)
    return Actuation(told.actuation_delay, told.actuator_lag, *free)


def plant_of(read: Read, n: int) -> RoadPlant:
    """The plant of n vehicles at its start.

    Parameters
    ----------
    read : value by name
    n : vehicles

    Raises
    ------
    ModelError : if a value is outside the model's domain
    """
    start, T = start_of(read, n, _ANYWHERE), validate(Sampling(read("T"))).T
    length = each_of(read, "length", n)
    validate(Cooperation(length=length))
    return RoadPlant.begin(start, T, actuation_of(read, n), length)
