"""The meaning of the variables that say what the vehicles of `PspPlant` are; see meaning.py."""

from __future__ import annotations

from dataclasses import replace
from math import inf, nextafter
from sys import float_info

import numpy as np

from psp_model.law.cooperation import Cooperation
from psp_model.parameters import NO_LIMIT, Actuation, PlatoonParameters
from psp_model.sampling.policy import Sampling
from psp_model.validate import validate
from psp_model.vehicles.road_plant import RoadPlant

from .meaning import Read, actuation_of, start_of

_ANYWHERE = PlatoonParameters(L=nextafter(0.0, 1.0), v_max=float_info.max)
"""Constants for a plant, which requires of a start only that vehicles are in order and do not reverse."""


def vehicles_of(read: Read, n: int) -> Actuation:
    """Dead time, lags and limits that n vehicles have.

    Parameters
    ----------
    read : value by name
    n : vehicles

    Raises
    ------
    ModelError : if a value is outside the model's domain
    """
    told = validate(actuation_of(read, n))
    least = np.where(np.greater(told.a_min, -NO_LIMIT), told.a_min, -inf)
    return replace(told, a_min=least, a_max=np.where(np.less(told.a_max, NO_LIMIT), told.a_max, inf))


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
    length = np.array([read(f"length[{i}]") for i in range(1, n + 1)])
    validate(Cooperation(length=length))
    return RoadPlant.begin(start, T, vehicles_of(read, n), length)
