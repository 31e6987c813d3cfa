"""Fitting small networks: ReLU layers, Adam, cosine decay, early stopping, and checkpoints to go on from."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..whole_file import read_arrays, write_whole
from .errors import OfflineError

Array = NDArray[Any]
Layers = list[tuple[Any, Any]]
Loss = Callable[[Layers, dict[str, Any]], Any]


@dataclass(frozen=True)
class Schedule:
    """How to fit.

    Attributes
    ----------
    learning_rate : of Adam, at the start
    cosine : whether it falls to 0 along a cosine over `epochs`
    epochs : most passes over the training data
    batch : rows per step
    patience : stop after this many epochs without a better validation loss
    stop_below : stop when the training loss falls below this
    """

    learning_rate: float
    cosine: bool
    epochs: int
    batch: int
    patience: int
    stop_below: float = 0.0


@dataclass
class Fit:
    """A network being fitted; everything that has to be kept to go on after an interruption.

    Attributes
    ----------
    layers, optimiser : now
    best, best_loss, best_epoch : the layers with the lowest validation loss so far
    history : (training loss, validation loss) of each epoch
    """

    layers: Any
    optimiser: Any
    best: Any
    best_loss: float
    best_epoch: int
    history: list[tuple[float, float]]


def initial_layers(sizes: Sequence[int], seed: int) -> Layers:
    """Weights for ReLU layers (He et al. 2015), biases 0.

    Parameters
    ----------
    sizes : widths from input to output
    seed : of the random numbers

    Returns
    -------
    list of (W (in, out), b (out,)) in float32
    """
    rng = np.random.default_rng(seed)
    pairs = pairwise(sizes)
    return [
        ((rng.standard_normal((i, o)) * np.sqrt(2.0 / i)).astype(np.float32), np.zeros(o, np.float32)) for i, o in pairs
    ]


def apply(layers: Sequence[tuple[Any, Any]], x: Any) -> Any:
    """The network's output: rectified linear units between the layers (paper, section IV), in NumPy or JAX.

    Parameters
    ----------
    layers : weights (inputs, outputs) and biases (outputs,) of each layer
    x : (..., inputs) array

    Returns
    -------
    (..., outputs) array
    """
    W, b = layers[-1]
    return hidden_layers(layers[:-1], x) @ W + b


def hidden_layers(layers: Sequence[tuple[Any, Any]], x: Any) -> Any:
    """Layers that are all followed by a rectified linear unit, in NumPy or JAX.

    Parameters
    ----------
    layers : weights (inputs, outputs) and biases (outputs,) of each layer
    x : (..., inputs) array

    Returns
    -------
    (..., outputs of the last layer) array, nothing below 0
    """
    for W, b in layers:
        x = x @ W + b
        x = x * (x > 0)
    return x


def fit(
    layers: Layers,
    loss: Loss,
    training: dict[str, Array],
    validation: dict[str, Array],
    schedule: Schedule,
    seed: int,
    checkpoint: Path | None = None,
    watch: Callable[[int, float, float], None] = lambda epoch, training, validation: None,
) -> Fit:
    """Minimise a loss.

    Parameters
    ----------
    layers : to start from
    loss : (layers, batch) -> mean loss of the batch, in JAX
    training, validation : arrays with one row per start; a batch has the same rows of each
    schedule : how
    seed : of the order of the batches
    checkpoint : file to save to every 25 epochs, and to go on from where it exists and belongs to the same fit
    watch : called after each epoch with its number and both losses

    Returns
    -------
    Fit
    """
    import jax
    import optax

    rows = len(next(iter(training.values())))
    batches = max(1, rows // schedule.batch)
    rate = (
        optax.cosine_decay_schedule(schedule.learning_rate, schedule.epochs * batches)
        if schedule.cosine
        else schedule.learning_rate
    )
    adam = optax.adam(rate)
    data = {name: jax.numpy.asarray(array) for name, array in training.items()}
    held = {name: jax.numpy.asarray(array) for name, array in validation.items()}

    def step(carry: Any, index: Any) -> Any:
        layers, state = carry
        value, slope = jax.value_and_grad(loss)(layers, {name: array[index] for name, array in data.items()})
        updates, state = adam.update(slope, state)
        return (optax.apply_updates(layers, updates), state), value

    epoch_of = jax.jit(lambda layers, state, order: jax.lax.scan(step, (layers, state), order))
    validate = jax.jit(loss)
    key = repr((asdict(schedule), seed, rows, [W.shape for W, _ in layers]))
    fresh = Fit(layers, adam.init(layers), layers, np.inf, -1, [])
    state = _resumed(checkpoint, key, fresh) or fresh
    while len(state.history) < schedule.epochs and len(state.history) - 1 - state.best_epoch < schedule.patience:
        epoch = len(state.history)
        order = np.random.default_rng([seed, epoch]).permutation(rows)[: batches * min(schedule.batch, rows)]
        (state.layers, state.optimiser), losses = epoch_of(state.layers, state.optimiser, order.reshape(batches, -1))
        state.history.append((float(losses.mean()), float(validate(state.layers, held))))
        if state.history[-1][1] < state.best_loss:
            state.best, state.best_loss, state.best_epoch = state.layers, state.history[-1][1], epoch
        watch(epoch, *state.history[-1])
        if checkpoint and epoch % 25 == 24:
            _save(checkpoint, key, state)
        if state.history[-1][0] < schedule.stop_below:
            break
    state.best = [(np.asarray(W), np.asarray(b)) for W, b in state.best]
    return state


def _save(path: Path, key: str, state: Fit) -> None:
    """Write a checkpoint: plain arrays, so that reading one can run no code."""
    import jax

    leaves = jax.tree.leaves((state.layers, state.optimiser, state.best))
    arrays: dict[str, Any] = {f"leaf_{place}": np.asarray(leaf) for place, leaf in enumerate(leaves)}
    arrays |= {"key": np.array(key), "best": np.array([state.best_loss, state.best_epoch])}
    arrays["history"] = np.array(state.history)
    file = io.BytesIO()
    np.savez(file, **arrays)
    write_whole(path, file.getvalue())


def _resumed(path: Path | None, key: str, fresh: Fit) -> Fit | None:
    """The fit kept in a checkpoint, if it is of the same data, schedule and seed; it has the structure of `fresh`.

    Raises
    ------
    OfflineError : where the file is no checkpoint
    """
    import jax

    if path is None or not path.exists():
        return None
    try:
        found = read_arrays(path)
        if str(found["key"]) != key:
            return None
        parts = fresh.layers, fresh.optimiser, fresh.best
        usual, structure = jax.tree.flatten(parts)
        leaves = [found[f"leaf_{place}"] for place in range(len(usual))]
        if any(np.shape(leaf) != np.shape(other) for leaf, other in zip(leaves, usual, strict=True)):
            raise ValueError
        history = [(float(training), float(validation)) for training, validation in found["history"]]
        loss, epoch = found["best"]
        now, optimiser, best = jax.tree.unflatten(structure, leaves)
        return Fit(now, optimiser, best, float(loss), int(epoch), history)
    except (KeyError, TypeError, ValueError):
        raise OfflineError(f"{path} is not a checkpoint of this training", "remove it", "no_checkpoint") from None
