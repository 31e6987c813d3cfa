"""A dictionary of good triples, and the second output of the network, which ranks them for a start (ours)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..law.potential import PotentialParameters
from ..selection.feasible import project
from ..selection.search.slope_limit import SlopeLimit
from .fit import Layers, Schedule
from .mixture import Mixture
from .parquet import Dataset
from .recipes import Trained, Watch, fitted, regrets
from .structures import Structure

Array = NDArray[Any]

TEMPERATURE = 0.004  # regret at which a triple is worth 1/e of the best one
SCHEDULE = Schedule(1e-3, True, 40, 256, 40)


def choose_dictionary(regret: Array, size: int) -> Array:
    """Points of the grid that together serve the starts best: each one lowers the mean least regret most (greedy).

    Parameters
    ----------
    regret : (B, C) regret of B starts at C points
    size : how many points to choose, K

    Returns
    -------
    (K,) indices, the most useful first
    """
    least = np.full(len(regret), np.inf, np.float32)
    chosen: list[int] = []
    for _ in range(size):
        means = np.minimum(regret, least[:, None]).mean(axis=0)
        means[chosen] = np.inf
        chosen.append(int(means.argmin()))
        least = np.minimum(least, regret[:, chosen[-1]])
    return np.array(chosen)


def train_ranking(
    data: Mixture,
    structure: Structure,
    size: int,
    hidden: tuple[int, ...],
    seed: int,
    checkpoint: Path | None,
    watch: Watch,
    schedule: Schedule = SCHEDULE,
) -> tuple[Trained, Array]:
    """Train scores whose softmax is the softmax of -regret / TEMPERATURE over the dictionary.

    Parameters
    ----------
    data : with tables
    structure : of the network
    size : of the dictionary, K
    hidden : widths of the hidden layers
    seed, checkpoint, watch : as for `recipes.train`
    schedule : of the fit

    Returns
    -------
    trained : layers from a raw start to K scores
    dictionary : (K, 3) alpha, r, p, feasible
    """
    import jax

    regret = regrets(data, 0.15).reshape(len(data.J), -1)
    sample = np.random.default_rng(seed).permutation(len(regret))[:4000]
    chosen = choose_dictionary(regret[sample], size)
    worth = np.exp(-(regret[:, chosen] - regret[:, chosen].min(axis=1, keepdims=True)) / TEMPERATURE)
    arrays = {"x": data.rows(structure), "y": (worth / worth.sum(axis=1, keepdims=True)).astype(np.float32)}

    def loss(layers: Layers, batch: dict[str, Any]) -> Any:
        return -(batch["y"] * jax.nn.log_softmax(structure.apply(layers, batch["x"]))).sum(axis=1).mean()

    layers = structure.initial(hidden, size, seed)
    found, test = fitted(layers, loss, arrays, arrays, schedule, seed, checkpoint, watch)
    raw = structure.folded(found.best, data.domain, np.zeros(size), np.ones(size))
    return Trained(structure, raw, found.best, found, test), dictionary_triples(data, chosen)


def dictionary_triples(data: Dataset | Mixture, chosen: Array) -> Array:
    """Points of the data set's grid as triples inside the feasible set.

    Parameters
    ----------
    data : whose grid it is
    chosen : (K,) array, numbers of the points, r times level

    Returns
    -------
    (K, 3) array, alpha [1], r [m], p [1]
    """
    grid, constants = data.grid, data.problem.constants
    i, j = np.divmod(chosen, grid.level.size)
    triples, _ = SlopeLimit(constants).triples(np.full(i.shape, grid.alpha), grid.r[i], grid.level[j])
    shapes = [project(PotentialParameters(*map(float, row)), constants) for row in triples]
    return np.array([(shape.alpha, shape.r, shape.p) for shape in shapes])
