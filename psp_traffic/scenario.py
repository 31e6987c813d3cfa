"""What happens on the road: where vehicles start, which vehicles merge from the ramp, what the leader does."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from psp_model.state import StartDomain
from psp_model.vehicles.leader import LeaderSpeed, Profile, Wave, read_profile

LENGTH = 5.0  # [m] of every vehicle: a spacing of L = 5 m means a clearance of 0
RAMP_END, LANE_END, ROAD_END = 1000.0, 2200.0, 130_000.0  # [m] the ramp joins, its lane ends, the road ends
LONGEST = 3600.0  # [s] of a run: no vehicle reaches the end of the road at v_max
STOP_AND_GO = Wave(high=30.0, low=14.0, begin=10.0, period=40.0)
WLTC_HIGH = Path(__file__).with_name("profiles") / "wltc_high.csv"
_APART = StartDomain(gap_min=38.0, gap_max=48.0)  # SUMO's drivers want 37.5 m at 30 m/s: 1 s, 2.5 m and their length
_BEHIND_A_LEADER = (12.0, 16.0)  # [m] spacings at the start


@dataclass(frozen=True, eq=False)
class Scenario:
    """One traffic situation.

    Attributes
    ----------
    name : for tables
    s, v : spacings (n-1,) [m] and speeds (n,) [m/s] at the start, leader first
    v_star : desired speed of all vehicles [m/s]
    duration : [s]
    x_leader : position of the leader's front at the start [m]
    merging : start (position [m], speed [m/s]) of each vehicle on the acceleration lane
    leader : speed of the leader, independent of all commands; None if it is controlled like the others
    """

    name: str
    s: NDArray[np.float64]
    v: NDArray[np.float64]
    v_star: float = 30.0
    duration: float = 60.0
    x_leader: float = 500.0
    merging: tuple[tuple[float, float], ...] = field(default=())
    leader: LeaderSpeed | None = None

    @property
    def vehicles(self) -> int:
        """All vehicles, those on the ramp included."""
        return self.v.size + len(self.merging)


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


def highway_apart(vehicles: int = 7, seed: int = 1, duration: float = 60.0) -> Scenario:
    """The same lane and speeds, at spacings that SUMO's drivers would keep by themselves (ours).

    Parameters
    ----------
    vehicles : n
    seed : of the start
    duration : [s]
    """
    s, v = _APART.draw(np.random.default_rng(seed), vehicles, 1)
    return Scenario("highway-apart", s[:, 0], v[:, 0], duration=duration)


def ramp(seed: int = 1, duration: float = 60.0) -> Scenario:
    """Five vehicles pass an on-ramp from which two merge.

    Parameters
    ----------
    seed : moves the two along their lane by up to 5 m
    duration : [s]
    """
    shift = np.random.default_rng(seed).uniform(-5, 5, 2)
    spacings = np.full(4, 14.0)
    merging = ((1180.0 + shift[0], 27.0), (1150.0 + shift[1], 27.0))
    return Scenario("ramp", spacings, np.full(5, 30.0), duration=duration, x_leader=1190.0, merging=merging)


def _behind(name: str, leader: LeaderSpeed, seed: int, vehicles: int, duration: float) -> Scenario:
    """Spacings drawn from a range, all vehicles as fast as the leader."""
    s = np.random.default_rng(seed).uniform(*_BEHIND_A_LEADER, vehicles - 1)
    return Scenario(name, s, np.full(vehicles, leader.speed(0.0)), duration=duration, leader=leader)


def stop_and_go(vehicles: int = 7, seed: int = 1, duration: float = 130.0) -> Scenario:
    """A leader on a stop-and-go wave of ours between 30 and 14 m/s.

    Parameters
    ----------
    vehicles : n
    seed : of the spacings at the start
    duration : [s]
    """
    return _behind("stop-and-go", STOP_AND_GO, seed, vehicles, duration)


def on_profile(
    vehicles: int = 7, seed: int = 1, duration: float | None = None, profile: Profile | None = None
) -> Scenario:
    """A leader that follows a speed profile.

    Parameters
    ----------
    vehicles : n
    seed : of the spacings at the start
    duration : [s], by default the profile's
    profile : by default phase High of the WLTC
    """
    profile = profile or read_profile(WLTC_HIGH)
    return _behind("profile", profile, seed, vehicles, duration or profile.times[-1])
