"""What a network looks like: a chain of layers for one number of vehicles, or layers that all spacings share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..namespaces import array_namespace
from ..state import StartDomain
from .fit import Layers, apply, hidden_layers, initial_layers

Array = NDArray[Any]

CHANNELS = 4  # of a spacing: its length, the speed in front of it, the speed behind it, and 1 where there is a spacing


class Structure(Protocol):
    """How a start becomes what a network gives."""

    def rows(self, starts: Array, domain: StartDomain) -> Array:
        """What the network sees of starts in training.

        Parameters
        ----------
        starts : (B, 2n-1) array, spacings [m] then speeds [m/s]
        domain : whose bounds become -1 and 1

        Returns
        -------
        float32 array, its first axis that of the starts
        """

    def initial(self, hidden: Sequence[int], outputs: int, seed: int) -> Layers:
        """Layers to start training from.

        Parameters
        ----------
        hidden : widths of the layers before the output
        outputs : width of the output
        seed : of the random numbers
        """

    def apply(self, layers: Layers, rows: Any) -> Any:
        """The network's output, in NumPy or JAX.

        Parameters
        ----------
        layers : weights and biases
        rows : from `rows`

        Returns
        -------
        (B, outputs) array
        """

    def folded(self, layers: Layers, domain: StartDomain, out_shift: Any, out_scale: Any) -> Layers:
        """The same network on raw input and with raw output, all scaling in its weights.

        Parameters
        ----------
        layers : as trained
        domain : that `rows` scaled by
        out_shift, out_scale : (outputs,) arrays; an output y means out_shift + out_scale y

        Returns
        -------
        layers in float32
        """


def input_scaling(domain: StartDomain, vehicles: int) -> tuple[Array, Array]:
    """Shift and scale, (2n-1,) each, that map the domain's bounds to -1 and 1 for n `vehicles` (ours)."""
    low = np.r_[np.full(vehicles - 1, domain.gap_min), np.full(vehicles, domain.speed_min)]
    high = np.r_[np.full(vehicles - 1, domain.gap_max), np.full(vehicles, domain.speed_max)]
    return (low + high) / 2, (high - low) / 2


def _scaled(starts: Array, domain: StartDomain) -> Array:
    shift, scale = input_scaling(domain, (starts.shape[1] + 1) // 2)
    return ((starts - shift) / scale).astype(np.float32)


@dataclass(frozen=True)
class Layered:
    """The 2n-1 numbers of a start through a chain of layers, for n `vehicles` (paper, section IV).

    Attributes
    ----------
    vehicles : n
    """

    vehicles: int

    def rows(self, starts: Array, domain: StartDomain) -> Array:
        """The numbers of the `starts`, (B, 2n-1), between -1 and 1."""
        return _scaled(starts, domain)

    def initial(self, hidden: Sequence[int], outputs: int, seed: int) -> Layers:
        """Layers of the widths 2n-1, `hidden` and `outputs` to start training from, random by `seed`."""
        return initial_layers([2 * self.vehicles - 1, *hidden, outputs], seed)

    def apply(self, layers: Layers, rows: Any) -> Any:
        """The output, (B, outputs), of a chain of `layers` for `rows`."""
        return apply(layers, rows)

    def folded(self, layers: Layers, domain: StartDomain, out_shift: Any, out_scale: Any) -> Layers:
        """The `layers` on raw input; an output y becomes out_shift + out_scale y."""
        return fold_scaling(layers, *input_scaling(domain, self.vehicles), out_shift, out_scale)


@dataclass(frozen=True)
class PerSpacing:
    """Layers shared by all spacings, then mean and maximum over the spacings, then a chain of layers (ours).

    A spacing is seen with its neighbours up to `radius` away.  Where the platoon ends there are no neighbours: all
    four channels are 0 there, and the fourth says so.

    Attributes
    ----------
    longest : spacings of the longest platoon in training; shorter ones are filled up with spacings that are not there
    widths : of the layers shared by all spacings
    radius : how many neighbours on each side a spacing is seen with
    """

    longest: int
    widths: tuple[int, ...]
    radius: int = 2

    def rows(self, starts: Array, domain: StartDomain) -> Array:
        """The channels of each spacing of the `starts`, (B, longest, 4)."""
        scaled = _scaled(starts, domain)
        spacings = (starts.shape[1] - 1) // 2
        speeds = scaled[:, spacings:]
        found = np.zeros((len(starts), self.longest, CHANNELS), np.float32)
        found[:, :spacings, 0] = scaled[:, :spacings]
        found[:, :spacings, 1], found[:, :spacings, 2] = speeds[:, :-1], speeds[:, 1:]
        found[:, :spacings, 3] = 1.0
        return found

    def initial(self, hidden: Sequence[int], outputs: int, seed: int) -> Layers:
        """Layers of the spacings, then those behind the pooling, `hidden` and `outputs` wide, random by `seed`."""
        shared = initial_layers([CHANNELS * (2 * self.radius + 1), *self.widths], seed)
        return shared + initial_layers([2 * self.widths[-1], *hidden, outputs], seed + 1)

    def apply(self, layers: Layers, rows: Any) -> Any:
        """The output, (B, outputs), of `layers` for `rows`."""
        there = rows[:, :, 3:]
        shared = hidden_layers(layers[: len(self.widths)], self._windows(rows)) * there
        pooled = (shared.sum(axis=1) / there.sum(axis=1), shared.max(axis=1))  # nothing shared is below 0
        return apply(layers[len(self.widths) :], array_namespace(rows).concatenate(pooled, axis=1))

    def _windows(self, rows: Any) -> Any:
        """(B, longest, 4 (2 radius + 1)) array, each spacing with its neighbours."""
        xp, spacings = array_namespace(rows), rows.shape[1]
        padded = xp.pad(rows, ((0, 0), (self.radius, self.radius), (0, 0)))
        return xp.concatenate([padded[:, k : k + spacings] for k in range(2 * self.radius + 1)], axis=2)

    def folded(self, layers: Layers, domain: StartDomain, out_shift: Any, out_scale: Any) -> Layers:
        """The `layers` on raw input; an output y becomes out_shift + out_scale y.

        The shift of the input goes to the channel that says whether there is a spacing: elsewhere nothing is added.
        """
        (spacing, front, rear), (wide, fast, fast_too) = (part[[0, 1, 1]] for part in input_scaling(domain, 2))
        raw = np.diag([1 / wide, 1 / fast, 1 / fast_too, 1.0])
        raw[3, :3] = -spacing / wide, -front / fast, -rear / fast_too
        W, b = layers[0]
        first = raw @ np.asarray(W, dtype=float).reshape(-1, CHANNELS, W.shape[1])
        return fold_scaling([(first.reshape(W.shape), b), *layers[1:]], 0.0, np.ones(len(W)), out_shift, out_scale)


def fold_scaling(layers: Layers, shift: Any, scale: Any, out_shift: Any, out_scale: Any) -> Layers:
    """The same network on raw input and with raw output, so that no scaling is left outside its weights (ours).

    Parameters
    ----------
    layers : (W (in, out), b (out,)) of a network on (x - shift) / scale whose output y means out_shift + out_scale y
    shift, scale : (in,) arrays
    out_shift, out_scale : (out,) arrays

    Returns
    -------
    layers in float32
    """
    folded = [(np.asarray(W, dtype=float), np.asarray(b, dtype=float)) for W, b in layers]
    W, b = folded[0]
    folded[0] = (W / np.asarray(scale)[:, None], b - (np.asarray(shift) / scale) @ W)
    W, b = folded[-1]
    folded[-1] = (W * out_scale, b * out_scale + out_shift)
    return [(W.astype(np.float32), b.astype(np.float32)) for W, b in folded]
