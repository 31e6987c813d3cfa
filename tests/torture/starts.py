"""Random starts over all of Omega, with all feasible parameters and all admissible constants."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from psp_model.law.potential import PotentialParameters, potential_slope
from psp_model.parameters import ALPHA_MAX, ALPHA_MIN, HILL_WIDTH, P_MAX, P_MIN, generic

Array = NDArray[np.float64]

CLOSEST = 1e-3  # [m] above L
_POINTS = 121  # of the hill at which the slope limit is looked at
_SAFETY = 0.995  # of the limit, for what lies between these points


@dataclass
class Lanes:
    """Fields by name, a column for each start; what psp_model takes as constants.

    Attributes
    ----------
    L, lam, v_star, v_max, epsilon, mu, z : (B,) constants
    alpha, r, p, hill : (B,) parameters
    T : (B,) sampling periods [s]
    s, v : (n-1, B), (n, B) initial spacings [m] and speeds [m/s]
    """

    L: Array
    lam: Array
    v_star: Array
    v_max: Array
    epsilon: Array
    mu: Array
    z: Array
    alpha: Array
    r: Array
    p: Array
    hill: Array
    T: Array
    s: Array
    v: Array

    @property
    def shape(self) -> PotentialParameters:
        """The potentials, one for each column."""
        return generic(PotentialParameters, alpha=self.alpha, r=self.r, p=self.p, hill=self.hill)

    def take(self, which: Any) -> Lanes:
        """Some of the starts."""
        return Lanes(**{name: value[..., which] for name, value in vars(self).items()})

    def put(self, places: Any, others: Lanes) -> None:
        """Replace the starts at some places."""
        for name, value in vars(self).items():
            value[..., places] = getattr(others, name)


def _constants(rng: np.random.Generator, count: int) -> dict[str, Array]:
    """The paper's constants for a half of the starts, any others for the rest."""
    paper = {"L": 5.0, "lam": 20.0, "v_star": 30.0, "v_max": 35.0, "epsilon": 0.2, "mu": 0.5, "z": 4.0}
    own = {"L": rng.uniform(1, 12, count), "v_max": rng.uniform(5, 60, count)}
    own["lam"] = own["L"] + HILL_WIDTH + rng.uniform(5, 30, count)
    own["v_star"] = own["v_max"] * rng.uniform(0.2, 0.98, count)
    own |= {"epsilon": 10 ** rng.uniform(-2, 1, count), "mu": 10 ** rng.uniform(-1.5, 0.5, count)}
    own["z"] = rng.uniform(2, 8, count)
    ours = rng.random(count) < 0.5
    return {name: np.where(ours, value, own[name]) for name, value in paper.items()}


def _shapes(rng: np.random.Generator, lanes: Lanes) -> None:
    """Give every start a feasible triple."""
    todo = np.arange(lanes.L.size)
    while todo.size:
        part = lanes.take(todo)
        part.alpha = ALPHA_MIN * (ALPHA_MAX / ALPHA_MIN) ** rng.random(todo.size)
        part.r = part.L + (part.lam - HILL_WIDTH - part.L) * rng.random(todo.size) ** 0.7
        part.p = rng.uniform(P_MIN, P_MAX, todo.size)
        spacings = part.r + np.linspace(0, HILL_WIDTH, _POINTS)[:, None]
        with np.errstate(all="ignore"):
            feasible = np.abs(potential_slope(spacings, part, part)).max(axis=0) < _SAFETY * part.z
        for name in ("alpha", "r", "p"):
            getattr(lanes, name)[todo] = getattr(part, name)
        todo = todo[~feasible]


def draw(rng: np.random.Generator, vehicles: int, count: int, old: bool = False) -> Lanes:
    """Starts over all of Omega.

    Spacings from 1 mm above L: a third of all starts has most close to L, a third is spread evenly up to lambda,
    the rest lies anywhere up to 60 m.  A quarter of all speeds is 0 or v_max.

    Parameters
    ----------
    rng : source of randomness
    vehicles : n
    count : B
    old : V_old instead of V_new with a feasible triple
    """
    kind, shape = rng.integers(0, 3, count), (vehicles - 1, count)
    constants = _constants(rng, count)
    L, lam, v_max = constants["L"], constants["lam"], constants["v_max"]
    near = CLOSEST * (60.0 / CLOSEST) ** rng.random(shape)
    close = np.where(rng.random(shape) < 0.7, CLOSEST * 300.0 ** rng.random(shape), near)
    room = np.select([kind == 0, kind == 1], [close, (lam - L) * rng.random(shape)], near)
    s = L + np.maximum(room, CLOSEST)
    v, pick = v_max * rng.random((vehicles, count)), rng.random((vehicles, count))
    v = np.where(pick < 0.125, 0.0, np.where(pick < 0.25, v_max, v))
    T = np.where(rng.random(count) < 0.7, 0.01, 1e-3 * 500.0 ** rng.random(count))
    shape_of = {"alpha": float(old), "r": 0.0, "p": 0.0, "hill": float(not old)}
    lanes = Lanes(**constants, **{name: np.full(count, value) for name, value in shape_of.items()}, T=T, s=s, v=v)
    if not old:
        _shapes(rng, lanes)
    return lanes
