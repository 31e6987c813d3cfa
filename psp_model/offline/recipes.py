"""The ways to train a network: `mse`, the paper's, `cost`, on what its answers cost on the road, and `any`.

`any` is `cost` for a network that serves any number of vehicles.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..parameters import ALPHA_MAX, ALPHA_MIN, HILL_WIDTH, P_MAX, P_MIN
from ..selection.search.engine import Problem
from ..selection.search.slope_limit import SlopeLimit
from .cost_table import TableCost, blurred, regret_tables
from .errors import OfflineError
from .fit import Fit, Layers, Schedule, fit
from .mixture import Mixture
from .parquet import Dataset
from .structures import Layered, PerSpacing, Structure

Array = NDArray[Any]
Watch = Callable[[int, float, float], None]


@dataclass(frozen=True)
class Recipe:
    """How a network is trained.

    Attributes
    ----------
    name : mse, cost or any
    hidden : widths of the hidden layers
    schedule : of the fit
    blur : standard deviation of the blur of the cost tables [cells]
    cap : largest regret that the cost tables keep
    per_spacing : widths of the layers that all spacings share; without any the network is for one number of vehicles
    """

    name: str
    hidden: tuple[int, ...]
    schedule: Schedule
    blur: float = 0.0
    cap: float = 0.15
    per_spacing: tuple[int, ...] = ()

    def structure(self, data: Mixture) -> Structure:
        """What a network trained on this data looks like.

        Raises
        ------
        OfflineError : where the data sets are of several numbers of vehicles and the network is for one
        """
        smallest, largest = data.vehicles
        if self.per_spacing:
            return PerSpacing(largest - 1, self.per_spacing)
        if smallest < largest:
            raise OfflineError(
                f"recipe {self.name} trains for one number of vehicles, and these data sets have {smallest} to "
                f"{largest}: give data sets of one number, or use recipe any"
            )
        return Layered(largest)


RECIPES = {
    # the paper's, section IV; batch and optimiser (Adam) are ours, as it gives none
    "mse": Recipe("mse", (32, 16), Schedule(35e-6, False, 2000, 32, 50, 1e-3)),
    # ours
    "cost": Recipe("cost", (32, 16), Schedule(3e-3, True, 100, 128, 100), blur=0.6),
    "any": Recipe("any", (64, 64), Schedule(3e-3, True, 40, 128, 40), blur=0.6, per_spacing=(64, 64)),
}


@dataclass(frozen=True)
class Trained:
    """A trained network.

    Attributes
    ----------
    structure : what it looks like
    layers : float32, from a raw start to raw output, all scaling inside
    scaled : the same on scaled input with scaled output, as it was trained
    fit : how the training went
    test_loss : the recipe's loss on the part of the data that neither trained nor stopped it
    """

    structure: Structure
    layers: Any
    scaled: Any
    fit: Fit
    test_loss: float


def split(rows: int, seed: int) -> tuple[Array, Array, Array]:
    """Row numbers for training (85 %), validation (7.5 %) and test (7.5 %) (paper, section IV).

    Parameters
    ----------
    rows : how many there are
    seed : of their order
    """
    order = np.random.default_rng(seed).permutation(rows)
    first, second = round(0.85 * rows), round(0.925 * rows)
    return order[:first], order[first:second], order[second:]


def output_scaling(problem: Problem) -> tuple[Array, Array]:
    """Shift and scale that map 0 and 1 to the bounds of alpha, r and p (paper: normalised data points)."""
    constants = problem.constants
    low = np.array([ALPHA_MIN, constants.L, P_MIN])
    return low, np.array([ALPHA_MAX, constants.lam - HILL_WIDTH, P_MAX]) - low


def train(data: Mixture, recipe: Recipe, seed: int, checkpoint: Path | None, watch: Watch) -> Trained:
    """Train the network that gives alpha, r, p.

    Parameters
    ----------
    data : starts and optima; with tables for all recipes but mse
    recipe : how
    seed : of weights, split and batches
    checkpoint : to go on from after an interruption
    watch : called after each epoch with its number and the losses in training and validation

    Returns
    -------
    Trained
    """
    structure = recipe.structure(data)
    shift, scale = output_scaling(data.problem)
    arrays, truth, loss = (_mse if recipe.name == "mse" else _cost)(data, recipe, structure)
    layers = structure.initial(recipe.hidden, 3, seed)
    if recipe.name != "mse":  # begin at the best fixed triple's place, and keep alpha at its bound
        layers[-1] = (0.1 * layers[-1][0], np.array([0.0, 0.5, 0.42], np.float32))
    found, test = fitted(layers, loss, arrays, truth, recipe.schedule, seed, checkpoint, watch)
    if recipe.name != "mse":
        W, b = (np.array(part) for part in found.best[-1])
        W[:, 0], b[0] = 0.0, 0.0
        found.best[-1] = (W, b)
    return Trained(structure, structure.folded(found.best, data.domain, shift, scale), found.best, found, test)


def fitted(
    layers: Layers, loss: Any, arrays: Any, truth: Any, schedule: Schedule, seed: int, checkpoint: Any, watch: Watch
) -> tuple[Fit, float]:
    """Fit on the training part of the data.

    Parameters
    ----------
    layers : to start from
    loss : (layers, batch) -> mean loss of the batch, in JAX
    arrays, truth : one row for each start; validation and test use `truth`, the arrays without blur
    schedule, seed, checkpoint, watch : as `fit` takes them

    Returns
    -------
    the fit, and the loss on the test part
    """
    training, validation, test = split(len(arrays["x"]), seed)
    schedule = replace(schedule, batch=min(schedule.batch, len(training)))
    parts = [
        {name: array[rows] for name, array in source.items()}
        for source, rows in ((arrays, training), (truth, validation), (truth, test))
    ]
    found = fit(layers, loss, parts[0], parts[1], schedule, seed, checkpoint, watch)
    return found, float(loss(found.best, parts[2]))


def _mse(data: Mixture, recipe: Recipe, structure: Structure) -> tuple[dict[str, Array], dict[str, Array], Any]:
    """Arrays and loss of the paper's recipe: mean squared error on the normalised argmin."""
    shift, scale = output_scaling(data.problem)
    arrays = {"x": data.rows(structure), "y": ((data.triples - shift) / scale).astype(np.float32)}

    def loss(layers: Layers, batch: dict[str, Any]) -> Any:
        return ((structure.apply(layers, batch["x"]) - batch["y"]) ** 2).mean()

    return arrays, arrays, loss


def _cost(data: Mixture, recipe: Recipe, structure: Structure) -> tuple[dict[str, Array], dict[str, Array], Any]:
    """Arrays and loss of recipe cost: mean regret of the answers, read from each start's table of J (ours)."""
    import jax.numpy as jnp

    regret = regrets(data, recipe.cap)
    cost = TableCost.of(data.grid, SlopeLimit(data.problem.constants))
    shift, scale = output_scaling(data.problem)
    rows, x = len(regret), data.rows(structure)
    arrays = {"x": x, "t": blurred(regret, recipe.blur).reshape(rows, -1)}

    def loss(layers: Layers, batch: dict[str, Any]) -> Any:
        y = structure.apply(layers, batch["x"])
        r, p = shift[1] + scale[1] * y[:, 1], shift[2] + scale[2] * y[:, 2]
        outside = jnp.maximum(-y[:, 1:], 0.0) + jnp.maximum(y[:, 1:] - 1.0, 0.0)
        return cost(batch["t"], r, p).mean() + 0.01 * (outside**2).sum(axis=1).mean()  # the table is flat out there

    return arrays, {"x": x, "t": regret.reshape(rows, -1)}, loss


def regrets(data: Dataset | Mixture, cap: float) -> Array:
    """Tables of regret of a data set, J/J* - 1 at each point of its grid.

    Parameters
    ----------
    data : with tables of J
    cap : the largest regret that is kept

    Returns
    -------
    (B, R, P) array

    Raises
    ------
    OfflineError : where the data set has none
    """
    if data.tables is None:
        problem = "this data set has no tables of J, which every recipe but mse needs"
        raise OfflineError(problem, "make it with tables", "no_tables")
    return regret_tables(data.tables, data.J, cap)
