"""Ideal vehicles on one lane, the plant of the controller where there is no other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..sampling.hold import DoubleIntegrators, Motion, spacings_after, travelled
from ..sampling.loop import Vector
from ..state import PlatoonState, seal


@dataclass(frozen=True)
class StoppingIntegrators(DoubleIntegrators):
    """Double integrators that do not reverse: a vehicle that stops stays at standstill, exactly (ours).

    In certified periods no vehicle stops, and these are the paper's vehicles.
    """

    def advance(self, vehicles: Motion, a: Vector, tau: float) -> tuple[Motion, Vector]:
        """See `Plant.advance`."""
        v = vehicles.v + tau * a
        stops = v < 0
        until = np.where(stops, vehicles.v / np.where(stops, -a, 1.0), tau)
        moved, v = travelled(vehicles.v, a, until), np.where(stops, 0.0, v)
        after = Motion(vehicles.x + moved[0], spacings_after(vehicles.s, moved), v)
        return after, np.where(stops, (v - vehicles.v) / tau, a) if tau > 0.0 else a


STOPPING = StoppingIntegrators()


@dataclass(frozen=True, eq=False)
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

    def advanced_to(self, period: int, a: ArrayLike) -> IdealPlant:
        """The plant at the beginning of a period, the accelerations held until then; this one where that is past.

        Parameters
        ----------
        period : its number
        a : (n,) accelerations [m/s2]
        """
        now, held = self.now, np.asarray(a, dtype=np.float64)
        for _ in range(self.period, period):
            now = STOPPING.advance(now, held, self.T)[0]
        seal(now.s, now.v)
        return IdealPlant(now, self.T, max(self.period, period))
