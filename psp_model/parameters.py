"""The constants of the model and the weights of its objective."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

Struct = TypeVar("Struct")

HILL_WIDTH = 3.0  # [m] the paper's convention: the hill spans [r, r + 3 m]
ALPHA_MIN, ALPHA_MAX = 1e-3, 1e-1  # [1] paper, feasible set
P_MIN, P_MAX = 3.0, 9.0  # [1] paper, feasible set
NO_LIMIT = 1000.0  # [m/s2] a bound on commands that stands for none; importers do not like infinity


@dataclass(frozen=True)
class PlatoonParameters:
    """The constants of the closed loop (paper, section V, except where marked ours).

    Each field is a number, or a symbol; `validate` checks numbers.

    Attributes
    ----------
    L : smallest allowable spacing [m]
    lam : spacing from which vehicles no longer repel each other, the paper's lambda [m]
    v_star : desired cruising speed [m/s]
    v_max : speed limit [m/s]
    epsilon : width over which f is smoothed [m/s2]
    mu : smallest feedback gain [1/s]
    z : limit of |V_new'| on the hill [m/s2]
    """

    L: float = 5.0
    lam: float = 20.0
    v_star: float = 30.0
    v_max: float = 35.0
    epsilon: float = 0.2
    mu: float = 0.5
    z: float = 4.0


@dataclass(frozen=True)
class ObjectiveWeights:
    """Weights and scales of the objective J.

    Each field is a number, or a symbol; `validate` checks numbers.

    Attributes
    ----------
    w1, w2 : weights of acceleration and of spacings [1] (paper, section V)
    a_ref : scale of acceleration [m/s2] (ours: equal to z)
    s_ref : scale of the spacings [m] (ours: equal to lambda)
    """

    w1: float = 0.5
    w2: float = 0.5
    a_ref: float = 4.0
    s_ref: float = 20.0


@dataclass(frozen=True)
class Actuation:
    """How commands become accelerations (ours: the paper's vehicles follow commands at once).

    Each field but the first is a number, an array that broadcasts with the vehicles, or a symbol.

    Attributes
    ----------
    actuation_delay : time from a command to its first effect, one for all vehicles [s]
    actuator_lag : time constant of the way from the present acceleration to the commanded one; 0 for none [s]
    a_min, a_max : limits of the command [m/s2]
    """

    actuation_delay: float = 0.0
    actuator_lag: float | NDArray[np.float64] = 0.0
    a_min: float | NDArray[np.float64] = -inf
    a_max: float | NDArray[np.float64] = inf


def generic(kind: type[Struct], **fields: Any) -> Struct:
    """A struct of the model that holds arrays or symbols instead of numbers (ours).

    Parameters
    ----------
    kind : its class
    fields : arrays that broadcast with the spacings, or symbols, by name; the others keep their defaults

    Returns
    -------
    the struct, for functions that are generic over the array namespace
    """
    return cast(Struct, cast(Any, kind)(**fields))
