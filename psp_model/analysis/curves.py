"""A potential over a range of spacings, and where its hill lies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..law.potential import PotentialParameters, potential, potential_slope
from ..parameters import HILL_WIDTH, PlatoonParameters


@dataclass(frozen=True, eq=False)
class Curve:
    """One potential over a range of spacings.

    Attributes
    ----------
    label : what distinguishes it
    shape : its parameters
    s : (K,) spacings [m]
    V : (K,) potential [m2/s2]
    slope : (K,) V' [m/s2]
    """

    label: str
    shape: PotentialParameters
    s: NDArray[np.float64]
    V: NDArray[np.float64]
    slope: NDArray[np.float64]


def curve(shape: PotentialParameters, constants: PlatoonParameters, label: str = "", points: int = 1601) -> Curve:
    """A potential sampled from just above L to just beyond lambda.

    Parameters
    ----------
    shape : the potential
    constants : L and lambda
    label : its name
    points : K

    Returns
    -------
    Curve
    """
    s = np.linspace(constants.L, constants.lam + 1.0, points + 1)[1:]
    return Curve(label, shape, s, potential(s, shape, constants), potential_slope(s, shape, constants))


def hill(shape: PotentialParameters, constants: PlatoonParameters) -> tuple[float, float] | None:
    """Where the hill's local minimum and its crest lie: the sign changes of V' on [r, r + 3] (ours).

    Parameters
    ----------
    shape : the potential
    constants : L and lambda

    Returns
    -------
    spacing of the minimum and spacing of the crest [m], or None where V falls all the way
    """
    if not shape.hill:
        return None
    s = shape.r + np.linspace(0.0, HILL_WIDTH, 3001)
    rising = np.flatnonzero(potential_slope(s, shape, constants) > 0)
    if rising.size == 0:
        return None
    first, last = int(rising[0]), int(rising[-1])
    # V' <= 0 at both ends of the hill, so a sample lies before the first and after the last that rises
    return _root(s[first - 1], s[first], shape, constants), _root(s[last + 1], s[last], shape, constants)


def _root(falling: float, rising: float, shape: PotentialParameters, constants: PlatoonParameters) -> float:
    """Bisect for the zero of V' between a spacing where it is at most 0 and one where it is above."""
    for _ in range(60):
        middle = 0.5 * (falling + rising)
        if potential_slope(np.array([middle]), shape, constants)[0] > 0:
            rising = middle
        else:
            falling = middle
    return 0.5 * (falling + rising)
