"""The global optimum of J over (alpha, r, p) for many starts: a grid, then pattern search from its best minima.

J jumps where a vehicle no longer makes it over a hill, and the optimum often stands at the edge of such a cliff, so
nothing here uses a derivative (ours).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...law.potential import PotentialParameters
from ...parameters import ALPHA_MAX, ALPHA_MIN, HILL_WIDTH
from ..feasible import project
from .engine import Engine, Problem
from .ridges import descend, suspected
from .slope_limit import SlopeLimit

Array = NDArray[Any]


@dataclass(frozen=True)
class Grid:
    """Candidates on a rectangle: r against the level of p between 3 and the slope limit.

    Attributes
    ----------
    alpha : of all candidates [1]
    r : (R,) array [m]
    level : (P,) array, 0 for p = 3, 1 for the largest feasible p
    """

    alpha: float
    r: Array
    level: Array


@dataclass(frozen=True)
class Effort:
    """How hard to search.

    Attributes
    ----------
    r_step : spacing of the main grid, at the smallest alpha [m]
    r_share : how much of the feasible part of r, from its lower end, the grids cover
    levels : cells of p on it
    alphas : further values of alpha, on grids of twice the spacing
    grid_periods : sampling periods that the grids' rollouts take at a time; everything later takes one
    seeds, survivors : minima that are refined in the first round, and in the later ones
    rounds : of refinement; the pattern is halved after each
    finalists : candidates that are compared in float64
    ridges : suspected cliffs that are searched across (module `ridges`), 0 for none
    ridge_survivors, ridge_rounds : how many of them are followed, in how many halvings
    """

    r_step: float = 0.1
    r_share: float = 1.0
    levels: int = 12
    alphas: tuple[float, ...] = (2e-3, 4e-3)
    grid_periods: int = 2
    seeds: int = 8
    survivors: int = 3
    rounds: int = 5
    finalists: int = 6
    ridges: int = 40
    ridge_survivors: int = 4
    ridge_rounds: int = 4


EFFORTS = {
    "full": Effort(),
    "quick": Effort(r_step=0.15, levels=11, alphas=(), seeds=3, survivors=1, rounds=3, finalists=1, ridges=0),
    "grid": Effort(r_step=0.2, r_share=0.75, levels=9, alphas=(), seeds=1, rounds=0, finalists=1, ridges=0),
}
"""`full` for optima that others are judged by; `grid`, the best of a grid, for recipe cost, which wants many starts."""


@dataclass(frozen=True)
class Solutions:
    """Optima of B starts.

    Attributes
    ----------
    triples : (B, 3) alpha [1], r [m], p [1], feasible
    J : (B,) objective, in float64
    T_max : (B,) smallest bound of Lemma 1 on the way [s]
    tables : (B, R, P) float32, J on the main grid, at `grid_periods` T; infinite where no p is feasible
    """

    triples: Array
    J: Array
    T_max: Array
    tables: Array


class Search:
    """Solves starts of one problem.

    Attributes
    ----------
    problem, effort : what is solved and how hard; the horizon is an even multiple of T
    grid : the main grid, at the smallest alpha
    """

    def __init__(self, problem: Problem, effort: Effort | None = None, threads: int | None = None):
        self.problem, self.effort = problem, effort or Effort()
        self.limit = SlopeLimit(problem.constants)
        self.single, self.double = Engine(problem, "float", threads), Engine(problem, "double", threads)
        self.coarse = Engine(replace(problem, T=problem.T * self.effort.grid_periods), "float", threads)
        self.grid = self._grid(ALPHA_MIN, 1)

    def _grid(self, alpha: float, coarseness: int) -> Grid:
        """The grid over the feasible part of r at one alpha, `coarseness` times wider than the main one."""
        constants = self.problem.constants
        fine = np.arange(constants.L + 0.02, constants.lam - HILL_WIDTH, 0.01)
        lowest = fine[np.isfinite(self.limit.largest_p(np.full(fine.shape, alpha), fine))][0]
        highest = lowest + self.effort.r_share * (constants.lam - HILL_WIDTH - lowest)
        count = max(3, round((highest - lowest) / (self.effort.r_step * coarseness)) + 1)
        return Grid(alpha, np.linspace(lowest, highest, count), np.linspace(0, 1, self.effort.levels // coarseness + 1))

    def solve(self, starts: Array) -> Solutions:
        """Solve starts.

        Parameters
        ----------
        starts : (B, 2n-1) array, spacings [m] then speeds [m/s] of each start

        Returns
        -------
        Solutions
        """
        effort = self.effort
        grids = [self.grid] + [self._grid(alpha, 2) for alpha in effort.alphas]
        tables = [self.table(starts, grid) for grid in grids]
        found = [_minima(table, grid, effort.seeds) for table, grid in zip(tables, grids, strict=True)]
        places, J = (np.concatenate(parts, axis=1) for parts in zip(*found, strict=True))
        places, J = _best(places, J, effort.seeds)
        J = np.full(J.shape, np.inf)  # what the grids say holds for their sampling period only
        steps = np.array([np.log(1.5), 0.5 * effort.r_step, 0.5 / effort.levels])
        for number in range(effort.rounds):
            places, J = self._refine(starts, places, J, steps * 0.5**number)
            places, J = _best(places, J, effort.survivors)
        if effort.ridges:
            valleys, least = self._valleys(starts, tables[0], self.grid)
            places, J = np.concatenate([places, valleys], axis=1), np.concatenate([J, least], axis=1)
        return self._finish(starts, *_best(places, J, effort.finalists), tables[0])

    def table(self, starts: Array, grid: Grid) -> Array:
        """J of every start at every point of a grid.

        Parameters
        ----------
        starts : (B, 2n-1) array, spacings [m] then speeds [m/s]

        Returns
        -------
        (B, R, P) float32 array; infinite where no p is feasible
        """
        triples, feasible = self.limit.triples(np.array(grid.alpha), grid.r[:, None], grid.level)
        J = self._costs(starts, np.broadcast_to(triples, (len(starts), *triples.shape)), self.coarse)
        return np.where(feasible, J, np.float32(np.inf))

    def _costs(self, starts: Array, triples: Array, engine: Engine | None = None) -> Array:
        """J of (B, ..., 3) candidates of B starts."""
        per_start = triples[0].size // 3
        which = np.repeat(np.arange(len(starts)), per_start)
        J, _ = (engine or self.single).costs(starts, which, triples.reshape(-1, 3))
        return J.reshape(triples.shape[:-1])

    def _costs_at(self, starts: Array, places: Array) -> tuple[Array, Array]:
        """J of (B, ..., 3) places (log alpha, r, level), infinite where not feasible, and the places inside bounds."""
        constants = self.problem.constants
        low = [np.log(ALPHA_MIN), constants.L + 0.02, 0.0]
        places = np.clip(places, low, [np.log(ALPHA_MAX), constants.lam - HILL_WIDTH, 1.0])
        triples, feasible = self.limit.triples(np.exp(places[..., 0]), places[..., 1], places[..., 2])
        return np.where(feasible, self._costs(starts, triples), np.inf), places

    def _refine(self, starts: Array, places: Array, J: Array, steps: Array) -> tuple[Array, Array]:
        """One round of pattern search around (B, K, 3) places in (log alpha, r, level)."""
        costs, tried = self._costs_at(starts, places[:, :, None] + _PATTERN * steps)
        best = costs.argmin(axis=2)[..., None]
        found = np.take_along_axis(costs, best, axis=2)[..., 0]
        moved = np.take_along_axis(tried, best[..., None], axis=2)[:, :, 0]
        better = found < J
        return np.where(better[..., None], moved, places), np.where(better, found, J)

    def _valleys(self, starts: Array, table: Array, grid: Grid) -> tuple[Array, Array]:
        """The best places at the edges of cliffs."""
        effort = self.effort
        places, axes = suspected(table, np.log(grid.alpha), grid.r, grid.level, effort.ridges)
        cells = np.array([0.0, grid.r[1] - grid.r[0], grid.level[1] - grid.level[0]])

        def costs(places: Array) -> Array:
            return self._costs_at(starts, places)[0]

        return descend(costs, places, axes, cells, effort.ridge_survivors, effort.ridge_rounds)

    def _finish(self, starts: Array, places: Array, J: Array, tables: Array) -> Solutions:
        """The best finalist of each start in float64, inside the feasible set."""
        triples, _ = self.limit.triples(np.exp(places[..., 0]), places[..., 1], places[..., 2])
        exact = self._costs(starts, triples, self.double)
        best = triples[np.arange(len(starts)), exact.argmin(axis=1)]
        best[best[:, 0] < ALPHA_MIN * (1 + 1e-12), 0] = ALPHA_MIN  # exp(log(bound)) is not quite the bound
        best[:, 0] = np.minimum(best[:, 0], ALPHA_MAX)
        final = np.array([_projected(triple, self.problem) for triple in best]).reshape(-1, 3)
        costs, T_max = self.double.costs(starts, np.arange(len(starts)), final)
        return Solutions(final, costs, T_max, tables)


def _projected(triple: Array, problem: Problem) -> list[float]:
    """A triple inside the feasible set by the model's own test, whatever the table of the slope limit says."""
    shape = project(PotentialParameters(*map(float, triple)), problem.constants)
    return [shape.alpha, shape.r, shape.p]


_R, _P = (axis.ravel() for axis in np.meshgrid(np.arange(-2, 3), np.arange(-2, 3), indexing="ij"))
_NEAR = np.maximum(abs(_R), abs(_P)) <= 1
_PATTERN = np.concatenate(
    [np.stack([np.zeros(_R.size), _R, _P], axis=1)]
    + [np.stack([np.full(_NEAR.sum(), k), _R[_NEAR], _P[_NEAR]], axis=1) for k in (-1, 1)]
)
"""(43, 3) the pattern in (log alpha, r, level): 5 by 5 at the same alpha, 3 by 3 at a smaller and a larger one."""


def _minima(tables: Array, grid: Grid, count: int) -> tuple[Array, Array]:
    """The `count` lowest local minima of each table.

    Returns
    -------
    places : (B, count, 3) log alpha, r, level
    J : (B, count); infinite where a table has fewer minima
    """
    rows, columns = tables.shape[1:]
    padded = np.pad(tables, ((0, 0), (1, 1), (1, 1)), constant_values=np.inf)
    lowest = np.ones(tables.shape, bool)
    for down in range(3):
        for right in range(3):
            lowest &= tables <= padded[:, down : down + rows, right : right + columns]
    J = np.where(lowest, tables, np.float32(np.inf)).reshape(len(tables), -1)
    order = np.argsort(J, axis=1, kind="stable")[:, :count]
    i, j = np.divmod(order, columns)
    places = np.stack([np.full(i.shape, np.log(grid.alpha)), grid.r[i], grid.level[j]], axis=-1)
    return places, np.take_along_axis(J, order, axis=1)


def _best(places: Array, J: Array, count: int) -> tuple[Array, Array]:
    """The `count` places of each start with the lowest J, best first."""
    order = np.argsort(J, axis=1, kind="stable")[:, :count]
    return np.take_along_axis(places, order[..., None], axis=1), np.take_along_axis(J, order, axis=1)
