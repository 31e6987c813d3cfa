"""A potential over a range of gaps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from psp_model.law.potential import PotentialParameters, potential, potential_slope
from psp_model.parameters import PlatoonParameters


@dataclass(frozen=True, eq=False)
class Curve:
    """One potential over a range of gaps.

    Attributes
    ----------
    label : what distinguishes it
    shape : its parameters
    s : (K,) gaps [m]
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
