"""J on the search's main grid as a smooth function of r and p, to train networks on what their answers cost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..parameters import P_MIN
from ..selection.search.search import Grid
from ..selection.search.slope_limit import SlopeLimit

Array = NDArray[Any]


def regret_tables(tables: Array, J: Array, cap: float) -> Array:
    """J/J* - 1 at every point of the grid, at most `cap`, 0 where the table is below J*.

    Parameters
    ----------
    tables : (B, R, P) J, infinite where no p is feasible
    J : (B,) optima
    cap : largest value kept; gradients far from the minimum do not help

    Returns
    -------
    (B, R, P) float32 array
    """
    return np.clip(tables / J[:, None, None].astype(np.float32) - 1.0, 0.0, cap).astype(np.float32)


def blurred(tables: Array, cells: float) -> Array:
    """Tables blurred by a Gaussian: cliffs that no network can place exactly become slopes (ours).

    Parameters
    ----------
    tables : (B, R, P) array
    cells : standard deviation in cells of the grid, 0 for none

    Returns
    -------
    (B, R, P) float32 array
    """
    from scipy.ndimage import gaussian_filter

    return gaussian_filter(tables, sigma=(0, cells, cells), mode="nearest") if cells else tables


@dataclass(frozen=True)
class TableCost:
    """Interpolation in the tables of one grid, differentiable in r and p, in JAX.

    Attributes
    ----------
    r : (R,) even axis of the grid [m]
    limit : (R,) largest feasible p at each r, where the projection would put a larger one
    levels : P, the number of levels of p, even between 0 and 1
    """

    r: Array
    limit: Array
    levels: int

    @classmethod
    def of(cls, grid: Grid, limit: SlopeLimit) -> TableCost:
        """For a grid of the search."""
        largest = limit.largest_p(np.full(grid.r.shape, grid.alpha), grid.r)
        return cls(grid.r.astype(np.float32), np.fmax(largest, P_MIN).astype(np.float32), grid.level.size)

    def __call__(self, tables: Any, r: Any, p: Any) -> Any:
        """Values of B tables at B points.

        Parameters
        ----------
        tables : (B, R * P) array
        r, p : (B,) arrays [m], [1]; p above the limit counts as at the limit, as after projection

        Returns
        -------
        (B,) array
        """
        import jax.numpy as jnp

        i, a = self._cell(r, self.r[0], self.r[-1], self.r.size)
        limit = jnp.asarray(self.limit)
        room = (1 - a) * limit[i] + a * limit[i + 1] - P_MIN
        j, b = self._cell((p - P_MIN) / jnp.maximum(room, 1e-3), 0.0, 1.0, self.levels)

        def at(i: Any, j: Any) -> Any:
            return jnp.take_along_axis(tables, (i * self.levels + j)[:, None], axis=1)[:, 0]

        low = (1 - b) * at(i, j) + b * at(i, j + 1)
        return (1 - a) * low + a * ((1 - b) * at(i + 1, j) + b * at(i + 1, j + 1))

    @staticmethod
    def _cell(x: Any, first: Any, last: Any, count: int) -> tuple[Any, Any]:
        """Index of the cell of an even axis, and place in it; clipped to the axis."""
        import jax.numpy as jnp

        place = jnp.clip((x - first) / (last - first), 0.0, 1.0) * (count - 1)
        index = jnp.minimum(place.astype(jnp.int32), count - 2)
        return index, place - index
