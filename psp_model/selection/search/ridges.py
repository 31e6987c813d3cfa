"""Minima at the edges of cliffs, where a vehicle only just makes it over a hill (ours).

J jumps across curves in the (r, p) plane and falls steeply towards them from one side: the run in which a vehicle hangs
on top of the hill for longest is often the best one.  Such a valley is a few millimetres of r wide and no grid sees its
bottom, so each is searched along a line across it, and then step by step along it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Costs = Callable[[Array], Array]
"""(B, N, 3) places (log alpha, r, level) to (B, N) J, infinite where not feasible."""

_JUMP = 0.004  # of J between neighbours on the grid, from which a cliff is suspected
_POINTS = np.linspace(-1.0, 1.0, 8)
_SHRINK = 2.0 / 7.0  # each zoom ends between two neighbours of the best of the points
_ACROSS, _ALONG = 2, 4  # zooms in the first round, and in the later ones
_REACH = 3.0  # cells across for each cell along: how steeply the valleys run


def suspected(table: Array, log_alpha: float, r: Array, level: Array, count: int) -> tuple[Array, Array]:
    """The lowest points of the grid that are least along a line and stand next to a jump.

    Parameters
    ----------
    table : (B, R, P) J
    log_alpha, r, level : of the grid's points
    count : how many to keep for each start, K

    Returns
    -------
    places : (B, K, 3) log alpha, r, level
    axes : (B, K) the place's component along that line, 1 or 2
    """
    values = []
    for axis in (1, 2):
        before, after = np.roll(table, 1, axis), np.roll(table, -1, axis)
        first, last = [slice(None)] * 3, [slice(None)] * 3
        first[axis], last[axis] = slice(0, 1), slice(-1, None)
        before[tuple(first)], after[tuple(last)] = table[tuple(first)], table[tuple(last)]
        least = (table <= before) & (table <= after)
        jump = np.maximum(before, after) - table > _JUMP * table
        values.append(np.where(least & jump, table, np.float32(np.inf)).reshape(len(table), -1))
    both = np.concatenate(values, axis=1)
    order = np.argsort(both, axis=1, kind="stable")[:, :count]
    axes, cell = np.divmod(order, values[0].shape[1])
    i, j = np.divmod(cell, level.size)
    return np.stack([np.full(i.shape, log_alpha), r[i], level[j]], axis=-1), axes + 1


def zoom(costs: Costs, places: Array, J: Array, axes: Array, width: Array, rounds: int) -> tuple[Array, Array]:
    """The least J on a line through each place, found by ever closer points around the best one.

    Parameters
    ----------
    costs : J of places
    places, J : (B, K, 3) and (B, K)
    axes : (B, K) the component that varies
    width : (B, K) how far to look to either side
    rounds : of zooming

    Returns
    -------
    places, J : the best found
    """
    direction = np.eye(3)[axes]
    for _ in range(rounds):
        tried = places[:, :, None] + (_POINTS[:, None] * (direction * width[..., None])[:, :, None])
        found = costs(tried.reshape(len(places), -1, 3)).reshape(tried.shape[:-1])
        best = found.argmin(axis=2)[..., None]
        least = np.take_along_axis(found, best, axis=2)[..., 0]
        moved = np.take_along_axis(tried, best[..., None], axis=2)[:, :, 0]
        better = least < J
        places, J = np.where(better[..., None], moved, places), np.where(better, least, J)
        width = width * _SHRINK
    return places, J


def descend(costs: Costs, places: Array, axes: Array, cells: Array, survivors: int, rounds: int) -> tuple[Array, Array]:
    """Follow valleys: across each first, then along the best ones in halving steps.

    Parameters
    ----------
    costs : J of places
    places, axes : (B, K, 3) and (B, K), from `suspected`
    cells : (3,) size of the grid's cells
    survivors : valleys that are followed
    rounds : of halving

    Returns
    -------
    places, J : (B, survivors, 3) and (B, survivors)
    """
    places, J = zoom(costs, places, np.full(axes.shape, np.inf), axes, cells[axes], _ACROSS)
    order = np.argsort(J, axis=1, kind="stable")[:, :survivors]
    places = np.take_along_axis(places, order[..., None], axis=1)
    J, axes = np.take_along_axis(J, order, axis=1), np.take_along_axis(axes, order, axis=1)
    other = 3 - axes
    places, J = zoom(costs, places, J, axes, cells[axes] * _SHRINK**_ACROSS, _ALONG - _ACROSS)
    for number in range(rounds):
        share = 0.5 ** (number + 1)
        step = np.eye(3)[other] * (cells[other] * share)[..., None]
        width = cells[axes] * share * _REACH
        tried = [zoom(costs, places + sign * step, np.full(J.shape, np.inf), axes, width, _ALONG) for sign in (1, -1)]
        for moved, least in tried:
            better = least < J
            places, J = np.where(better[..., None], moved, places), np.where(better, least, J)
    return places, J
