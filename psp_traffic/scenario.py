"""What happens on the road: where vehicles start, who comes in by the ramp, what the leader does."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from psp_model.leader import Wave
from psp_model.state import StartDomain

LENGTH = 5.0  # [m] of every vehicle: fronts L = 5 m apart means bumper to bumper
RAMP_END, LANE_END, ROAD_END = 1000.0, 2200.0, 30_000.0  # [m] the ramp joins, its lane ends, the road ends
STOP_AND_GO = Wave(high=30.0, low=14.0, begin=10.0, period=40.0)


@dataclass(frozen=True, eq=False)
class Scenario:
    """One traffic situation.

    Attributes
    ----------
    name : for tables
    s, v : gaps (n-1,) front to front [m] and speeds (n,) [m/s] at the start, leader first
    v_star : speed that everybody wants [m/s]
    duration : [s]
    x_leader : position of the leader's front at the start [m]
    merging : start (position [m], speed [m/s]) of each vehicle on the acceleration lane
    wave : whether the leader drives the stop-and-go wave, whatever anybody commands
    """

    name: str
    s: NDArray[np.float64]
    v: NDArray[np.float64]
    v_star: float = 30.0
    duration: float = 60.0
    x_leader: float = 500.0
    merging: tuple[tuple[float, float], ...] = field(default=())
    wave: bool = False

    @property
    def vehicles(self) -> int:
        """All vehicles, those on the ramp included."""
        return self.v.size + len(self.merging)


def wave_speed(time: float) -> float:
    """Speed of the leader in the stop-and-go wave [m/s] (ours).

    Parameters
    ----------
    time : [s]
    """
    return STOP_AND_GO.speed(time)


def highway(vehicles: int = 7, seed: int = 1, duration: float = 60.0) -> Scenario:
    """A single lane, and a start drawn from the paper's ranges.

    Parameters
    ----------
    vehicles : n
    seed : of the start
    duration : [s]
    """
    s, v = StartDomain().draw(np.random.default_rng(seed), vehicles, 1)
    return Scenario("highway", s[:, 0], v[:, 0], duration=duration)


def ramp(seed: int = 1, duration: float = 60.0) -> Scenario:
    """Five vehicles pass an on-ramp from which two come in.

    Parameters
    ----------
    seed : moves the two along their lane by up to 5 m
    duration : [s]
    """
    shift = np.random.default_rng(seed).uniform(-5, 5, 2)
    gaps = np.full(4, 14.0)
    merging = ((1180.0 + shift[0], 27.0), (1150.0 + shift[1], 27.0))
    return Scenario("ramp", gaps, np.full(5, 30.0), duration=duration, x_leader=1190.0, merging=merging)


def stop_and_go(vehicles: int = 7, duration: float = 130.0) -> Scenario:
    """A leader on a stop-and-go wave of ours between 30 and 14 m/s.

    Parameters
    ----------
    vehicles : n
    duration : [s]
    """
    return Scenario("stop-and-go", np.full(vehicles - 1, 14.0), np.full(vehicles, 30.0), duration=duration, wave=True)
