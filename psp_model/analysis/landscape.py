"""The landscape of J over r and p from one start, and its lowest point (not in the paper)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..law.potential import PotentialParameters
from ..objective import HORIZON
from ..parameters import ALPHA_MIN, HILL_WIDTH, P_MAX, P_MIN, ObjectiveWeights
from ..sampling.policy import Sampling
from ..selection.feasible import slope_within_limit
from ..selection.rollout import rollout_costs
from ..state import PlatoonState

_REFINED, _ROUNDS, _FINER = 4, 3, 7  # points that are refined at a time, how often, and points per side


@dataclass(frozen=True, eq=False)
class Landscape:
    """J over a grid of r and p.

    Attributes
    ----------
    alpha : scale of all potentials [1]
    r : (R,) [m]
    p : (P,) [1]
    J : (P, R) objective at the end of the horizon; NaN where the triple is not feasible or T not certified throughout
    """

    alpha: float
    r: NDArray[np.float64]
    p: NDArray[np.float64]
    J: NDArray[np.float64]

    @property
    def best(self) -> PotentialParameters:
        """The grid point with the smallest J."""
        row, column = np.unravel_index(np.nanargmin(self.J), self.J.shape)
        return PotentialParameters(self.alpha, float(self.r[column]), float(self.p[row]))


def landscape(
    start: PlatoonState,
    alpha: float = ALPHA_MIN,
    points: int = 51,
    weights: ObjectiveWeights | None = None,
    T: float = 0.01,
    horizon: float = HORIZON,
) -> Landscape:
    """J over the feasible part of a grid in r and p at one alpha.

    Parameters
    ----------
    start : initial state
    alpha : scale of the potentials [1]; the bound at which the optimum nearly always lies by default
    points : R and P
    weights : of the objective; the paper's by default
    T : sampling period [s]
    horizon : [s]

    Returns
    -------
    Landscape
    """
    constants = start.constants
    r = np.linspace(constants.L, constants.lam - HILL_WIDTH, points + 1)[1:]
    p = np.linspace(P_MIN, P_MAX, points)
    grid = [PotentialParameters(alpha, float(column), float(row)) for row in p for column in r]
    J = _costs(start, grid, weights or ObjectiveWeights(), T, horizon)
    return Landscape(alpha, r, p, J.reshape(points, points))


def _costs(
    start: PlatoonState, shapes: list[PotentialParameters], weights: ObjectiveWeights, T: float, horizon: float
) -> NDArray[np.float64]:
    """J of each triple, NaN where it is not feasible or T not certified throughout."""
    feasible = np.array([slope_within_limit(shape, start.constants) for shape in shapes])
    candidates = [shape for shape, inside in zip(shapes, feasible, strict=True) if inside]
    J = np.full(len(shapes), np.nan)
    if candidates:
        costs, certified = rollout_costs(start, candidates, weights, Sampling(T), horizon)
        J[feasible] = np.where(certified, costs, np.nan)
    return J


def optimum(
    start: PlatoonState,
    scene: Landscape,
    weights: ObjectiveWeights | None = None,
    T: float = 0.01,
    horizon: float = HORIZON,
) -> tuple[PotentialParameters, float]:
    """The best triple found at the landscape's alpha: finer and finer grids around its best points (ours).

    Parameters
    ----------
    start, weights, T, horizon : those of the landscape
    scene : the landscape

    Returns
    -------
    triple and its J
    """
    constants = start.constants
    order = np.argsort(scene.J, axis=None)[:_REFINED]  # NaN comes last
    rows, columns = np.unravel_index(order, scene.J.shape)
    best = scene.best
    J_best = float(np.nanmin(scene.J))
    centres = [(float(scene.r[column]), float(scene.p[row])) for row, column in zip(rows, columns, strict=True)]
    width = np.array([scene.r[1] - scene.r[0], scene.p[1] - scene.p[0]])
    for _ in range(_ROUNDS):
        steps = np.linspace(-1.0, 1.0, _FINER)
        places = {
            (
                float(np.clip(r + width[0] * i, constants.L + 1e-9, constants.lam - HILL_WIDTH)),
                float(np.clip(p + width[1] * j, P_MIN, P_MAX)),
            )
            for r, p in centres
            for i in steps
            for j in steps
        }
        shapes = [PotentialParameters(scene.alpha, r, p) for r, p in sorted(places)]
        J = _costs(start, shapes, weights or ObjectiveWeights(), T, horizon)
        order = np.argsort(J)[:_REFINED]
        centres = [(shapes[k].r, shapes[k].p) for k in order.tolist()]
        if J[order[0]] < J_best:
            best, J_best = shapes[order[0]], float(J[order[0]])
        width = width / (_FINER // 2)
    return best, J_best
