"""Runs on a road: vehicles with dead time and lag, some drive themselves, measured late and with noise (ours)."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..law.cooperation import Cooperation, clearances
from ..parameters import Actuation
from .actuation import Foreign
from .delayed import Delayed, DelayedVehicles
from .road_law import Remembered, RoadLaw, Seen

Batch = NDArray[np.float64]


@dataclass(frozen=True)
class Sensing:
    """How vehicles are measured.

    Attributes
    ----------
    periods_old : age of what is measured [sampling periods]
    noise_s, noise_v : standard deviations of the errors of spacings [m] and of speeds [m/s]
    known : whether the acceleration of vehicles that drive themselves is communicated
    seed : of the errors
    """

    periods_old: int = 0
    noise_s: float = 0.0
    noise_v: float = 0.0
    known: bool = True
    seed: int = 0


@dataclass(eq=False)
class RoadRun:
    """What became of a batch of B platoons; a mutable record that `run_on_road` keeps.

    Attributes
    ----------
    least : (n-1, B) smallest clearances so far [m]
    squares : (n, B) integrals of the squared accelerations so far [m2/s3]
    largest : (n, B) largest accelerations and decelerations so far, as sizes [m/s2]
    vehicles : state of the plant
    memory : of the controller
    past : states of the plant and what the controller saw of the accelerations, the oldest first
    """

    least: Batch
    squares: Batch
    largest: Batch
    vehicles: Delayed
    memory: Remembered | None = None
    past: deque[Any] = field(default_factory=deque)

    @property
    def touched(self) -> NDArray[np.bool_]:
        """(B,) whether any two vehicles touched."""
        found: NDArray[np.bool_] = np.logical_or.reduce(self.least <= 0.0, axis=0)
        return found

    def gain(self, last: int, first: int) -> float:
        """Root mean square acceleration of one vehicle over that of another, over the whole batch [1].

        Parameters
        ----------
        last, first : their places, counted from 0
        """
        return float(np.sqrt(self.squares[last].sum() / self.squares[first].sum()))


def started(plant: DelayedVehicles, s: Batch, v: Batch) -> RoadRun:
    """A batch of platoons before its first sampling instant.

    Parameters
    ----------
    plant : the vehicles
    s, v : (n-1, B) spacings [m] and (n, B) speeds [m/s]
    """
    return RoadRun(np.full(s.shape, np.inf), np.zeros(v.shape), np.zeros(v.shape), plant.begin(0.0, s, v))


def run_on_road(
    run: RoadRun,
    law: RoadLaw,
    actuation: Actuation,
    length: Any,
    speeds: Mapping[int, Batch],
    periods: int,
    sensing: Sensing | None = None,
) -> RoadRun:
    """Go on with a batch of platoons for some sampling periods; `run` itself is changed and returned.

    Parameters
    ----------
    law : the controller, with what it believes
    actuation : what is true
    length : (n, 1) true lengths [m], None for L
    speeds : by place, counted from 0, the speeds at all sampling instants, (periods + 1,), of vehicles that drive
        themselves [m/s]
    periods : how many
    sensing : how vehicles are measured
    """
    sensing = sensing or Sensing()
    plant, rng, T = DelayedVehicles(actuation), np.random.default_rng(sensing.seed), law.T
    n = run.vehicles.v.shape[0]
    automated = np.ones((n, 1))
    automated[list(speeds)] = 0.0
    given = np.zeros((n, periods))
    for place, speed in speeds.items():
        given[place] = np.diff(speed[: periods + 1]) / T
    lengths = Cooperation(length=length)
    for k in range(periods):
        theirs = given[:, k : k + 1]
        run.past.append((run.vehicles.s, run.vehicles.v, theirs))
        while len(run.past) > sensing.periods_old + 1:
            run.past.popleft()
        s, v, a = run.past[0]
        old = (len(run.past) - 1) * T
        if sensing.noise_s or sensing.noise_v:
            s = s + sensing.noise_s * rng.standard_normal(s.shape)
            v = np.maximum(v + sensing.noise_v * rng.standard_normal(v.shape), 0.0)
        flags, told = (automated, a if sensing.known else None) if speeds else (None, None)
        run.memory, command = law.sample(run.memory, Seen(s, v, old, flags, told))
        foreign = Foreign(automated, theirs) if speeds else None
        before = run.vehicles.v
        run.vehicles, _ = plant.advance(run.vehicles, command, T, foreign)
        a = (run.vehicles.v - before) / T
        run.squares += a * a * T
        run.largest = np.maximum(run.largest, np.abs(a))
        run.least = np.minimum(run.least, clearances(run.vehicles.s, lengths, law.constants))
    return run
