"""Ideal vehicles on one lane: what a controller of ours drives where no other plant is at hand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..platoon import Vector
from ..sampling.hold import gaps_after, travelled
from ..state import PlatoonState


@dataclass(frozen=True, eq=False)
class Motion:
    """Where the vehicles are.

    Attributes
    ----------
    x : position of the leader [m]
    s, v : gaps (n-1,) [m] and speeds (n,) [m/s]
    """

    x: float
    s: Vector
    v: Vector

    def after(self, a: Vector, tau: float) -> Motion:
        """The motion a time tau later, exactly (paper, eq. 10); who comes to a stop on the way stands from there on.

        Parameters
        ----------
        a : (n,) accelerations held [m/s2]
        tau : time [s]
        """
        v = self.v + tau * a
        stops = v < 0  # vehicles do not reverse (ours): certified periods end before that
        until = np.where(stops, self.v / np.where(stops, -a, 1.0), tau)
        moved = travelled(self.v, a, until)
        return Motion(self.x + float(moved[0]), gaps_after(self.s, moved), np.where(stops, 0.0, v))

    def positions(self) -> Vector:
        """Positions of all vehicles, (n,) [m]."""
        return np.subtract.accumulate(np.concatenate([[self.x], self.s]))


@dataclass
class IdealPlant:
    """Double integrators that do not reverse, driven period by period (ours).

    The acceleration known at the end of a period counts for all of it.  A command that a co-simulation master passes
    on late, but within the period it belongs to, so does what it would have done without the delay.  What is seen is
    the motion at the beginning of the current period, as by sensors that sample once a period.

    Attributes
    ----------
    now : motion at the beginning of the current period
    T : length of a period [s]
    period : number of the current period
    """

    now: Motion
    T: float
    period: int = 0

    @classmethod
    def begin(cls, start: PlatoonState, T: float) -> IdealPlant:
        """The plant at its initial state.

        Parameters
        ----------
        start : initial state
        T : length of a period [s]
        """
        return cls(Motion(start.x_leader, start.s, start.v), T)

    def advance_to(self, period: int, a: Vector) -> None:
        """Go to the beginning of a period with the accelerations held.

        Parameters
        ----------
        period : its number
        a : (n,) accelerations [m/s2]
        """
        while self.period < period:
            self.now, self.period = self.now.after(a, self.T), self.period + 1
