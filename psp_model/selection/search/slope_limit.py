"""The slope limit as a table: the largest feasible p for every alpha and r, for whole batches of candidates."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...law.potential import PotentialParameters, potential_slope
from ...parameters import ALPHA_MAX, ALPHA_MIN, HILL_WIDTH, P_MAX, P_MIN, PlatoonParameters, generic

Array = NDArray[Any]

_ALPHAS, _R_STEP, _POINTS, _HALVINGS = 25, 0.05, 241, 20
MARGIN = 2e-4  # [1] in p, kept from the limit because the table is interpolated; J does not notice


@dataclass(frozen=True)
class SlopeLimit:
    """Largest p with |V_new'| <= z on the hill, by bisection on a fine grid and interpolation (ours).

    Attributes
    ----------
    constants : of the model
    """

    constants: PlatoonParameters

    def largest_p(self, alpha: Array, r: Array) -> Array:
        """The largest p that is surely feasible.

        Parameters
        ----------
        alpha, r : arrays of one shape [1], [m]

        Returns
        -------
        array of that shape [1]; NaN where no p is feasible
        """
        log_alphas, rs, t = _table(self.constants)
        i, a = _cell(np.log(alpha), log_alphas)
        j, b = _cell(r, rs)
        p = (1 - a) * ((1 - b) * t[i, j] + b * t[i, j + 1]) + a * ((1 - b) * t[i + 1, j] + b * t[i + 1, j + 1])
        return np.where(p - MARGIN >= P_MIN, p - MARGIN, np.nan)

    def triples(self, alpha: Array, r: Array, level: Array) -> tuple[Array, Array]:
        """Candidates by how far p stands between 3 and the slope limit.

        Parameters
        ----------
        alpha, r : arrays that broadcast [1], [m]
        level : array that broadcasts with them, 0 for p = 3, 1 for the largest feasible p

        Returns
        -------
        triples : (..., 3) array of alpha [1], r [m], p [1]
        feasible : (...) booleans; where False, p stands at 3 and is not feasible
        """
        alpha, r, level = np.broadcast_arrays(alpha, r, level)
        limit = self.largest_p(alpha, r)
        feasible = np.isfinite(limit)
        p = P_MIN + level * (np.where(feasible, limit, P_MIN) - P_MIN)
        return np.stack([alpha, r, p], axis=-1), feasible


@lru_cache(maxsize=8)
def _table(constants: PlatoonParameters) -> tuple[Array, Array, Array]:
    """Axes log alpha and r, and the largest p at their points; NaN where not even p = 3 is feasible."""
    lowest, highest = constants.L + 0.02, constants.lam - HILL_WIDTH
    r = np.linspace(lowest, highest, max(2, round((highest - lowest) / _R_STEP) + 1))
    log_alphas = np.linspace(np.log(ALPHA_MIN), np.log(ALPHA_MAX), _ALPHAS)
    return log_alphas, r, np.array([_row(np.exp(log_alpha), r, constants) for log_alpha in log_alphas])


def _row(alpha: float, r: Array, constants: PlatoonParameters) -> Array:
    """The largest p along r at one alpha."""
    s = r + np.linspace(0.0, HILL_WIDTH, _POINTS)[:, None]

    def within(p: Array) -> Array:
        return (
            np.abs(potential_slope(s, generic(PotentialParameters, alpha=alpha, r=r, p=p), constants)).max(axis=0)
            <= constants.z
        )

    low, high = np.full(r.shape, P_MIN), np.full(r.shape, P_MAX)
    feasible = within(low)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        fits = within(middle)
        low, high = np.where(fits, middle, low), np.where(fits, high, middle)
    return np.where(feasible, low, np.nan)


def _cell(x: Array, axis: Array) -> tuple[Array, Array]:
    """Index of the cell of an even axis that holds x, and where in it (0 to 1); x is clipped to the axis."""
    place = np.clip((x - axis[0]) / (axis[-1] - axis[0]), 0.0, 1.0) * (axis.size - 1)
    index = np.minimum(place.astype(int), axis.size - 2)
    return index, place - index
