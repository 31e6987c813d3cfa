"""Vehicles as they are on a road, driven period by period: the plant of the controller for real vehicles (ours)."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import inf
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import ModelError
from ..law.cooperation import is_off
from ..parameters import Actuation, PlatoonParameters
from ..sampling.hold import Motion
from ..sampling.loop import Vector
from ..state import PlatoonState, read_only, seal
from .actuation import Actuators, Foreign
from .delayed import Delayed, DelayedVehicles
from .ideal import STOPPING
from .ride import unless_standing

LONGEST_DEAD_TIME = 510  # [periods]: as many commands are on their way, and each is remembered (ours)


@dataclass(frozen=True, eq=False)
class RoadPlant:
    """Vehicles with dead time, lag, limits and lengths that do not reverse, driven period by period (ours).

    The accelerations known at the end of a period count for all of it, as for `IdealPlant`; with the defaults it is
    that plant, bit for bit.  A vehicle that drives itself has its acceleration at once, and nothing is commanded to it.

    Attributes
    ----------
    now : motion and actuators at the beginning of the current period
    T : length of a period [s]
    actuation : dead time, lags and limits of the vehicles
    length : (n,) lengths of the vehicles, or one number for all [m]
    period : number of the current period
    """

    now: Delayed
    T: float
    actuation: Actuation = field(default_factory=Actuation)
    length: Vector | float = PlatoonParameters.L
    period: int = 0

    @classmethod
    def begin(
        cls,
        start: PlatoonState,
        T: float,
        actuation: Actuation | None = None,
        length: ArrayLike = PlatoonParameters.L,
    ) -> RoadPlant:
        """The plant at its initial state; the actuators hold 0.

        Parameters
        ----------
        start : initial state
        T : length of a period [s]
        actuation : dead time, lags and limits, (n,) arrays or numbers; None for none
        length : (n,) lengths, or one for all [m]

        Raises
        ------
        ModelError : where the dead time lasts more than LONGEST_DEAD_TIME periods
        """
        told = _without_what_is_off(actuation or Actuation())
        if told.actuation_delay > LONGEST_DEAD_TIME * T:
            raise ModelError("dead_time", told.actuation_delay, LONGEST_DEAD_TIME, T)
        vehicles = DelayedVehicles(told).begin(start.x_leader, start.s, start.v)
        return cls(vehicles, T, told, read_only(np.broadcast_to(length, start.v.shape)))

    @property
    def is_ideal(self) -> bool:
        """Whether the vehicles follow any command at once."""
        told = self.actuation
        free = isinstance(told.a_min, float) and isinstance(told.a_max, float) and -told.a_min == told.a_max == inf
        return free and is_off(told.actuation_delay) and is_off(told.actuator_lag)

    def advanced_to(self, period: int, a: ArrayLike, automated: ArrayLike | None = None) -> RoadPlant:
        """The plant at the beginning of a period, the accelerations held until then; this one where that is past.

        Parameters
        ----------
        period : its number
        a : (n,) accelerations, commanded or, of vehicles that drive themselves, true ones [m/s2]
        automated : (n,) 0 for vehicles that drive themselves, 1 for the others; None for 1
        """
        now, held = self.now, np.array(a, dtype=np.float64)
        driven = np.ones(held.shape) if automated is None else np.asarray(automated, dtype=np.float64)
        for _ in range(self.period, period):
            now = self._followed(now, held) if self.is_ideal else self._driven(now, held, driven)
        seal(now.s, now.v, *now.actuators[:2])
        return replace(self, now=now, period=max(self.period, period))

    def _followed(self, now: Delayed, a: Vector) -> Delayed:
        """One period later, of ideal vehicles."""
        then, _ = STOPPING.advance(Motion(now.x, now.s, now.v), a, self.T)
        return Delayed(*then, Actuators(a, a))

    def _driven(self, now: Delayed, a: Vector, automated: Vector) -> Delayed:
        """One period later, of any vehicles; a command that repeats the last one takes no room in the queue."""
        asked = np.where(automated > 0.5, a, 0.0)
        last = now.actuators.queue[-1][1] if now.actuators.queue else now.actuators.command
        if np.array_equal(asked, last):
            asked = last
        foreign = None if (automated > 0.5).all() else Foreign(automated, a)
        return DelayedVehicles(self.actuation).advance(now, asked, self.T, foreign)[0]

    def positions(self) -> Vector:
        """Positions of all vehicles at the beginning of the current period, (n,) array [m]."""
        found: Vector = np.subtract.accumulate(np.concatenate([[self.now.x], self.now.s]))
        return found

    def clearances(self) -> Vector:
        """s_i - length[i-1], bumper to bumper, at the beginning of the current period, (n-1,) array [m]."""
        clear: Vector = self.now.s - np.broadcast_to(self.length, self.now.v.shape)[:-1]
        return clear

    def accelerations(self) -> Vector:
        """Those in which the last period ended, (n,) array [m/s2]; 0 where a vehicle stands and brakes."""
        found: Vector = unless_standing(self.now.v, self.now.actuators.a)
        return found


def _without_what_is_off(told: Actuation) -> Actuation:
    """Numbers for arrays of lags and limits that are none, which cost more."""

    def plain(values: Any, none: float) -> Any:
        return none if np.all(np.equal(values, none)) else values

    lag, least, most = plain(told.actuator_lag, 0.0), plain(told.a_min, -inf), plain(told.a_max, inf)
    return Actuation(told.actuation_delay, lag, least, most)
