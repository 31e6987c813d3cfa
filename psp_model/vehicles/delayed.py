"""A plant of vehicles with dead time, lag and limits that do not reverse, exact between commands (ours)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from ..namespaces import Array, Number
from ..parameters import Actuation
from ..sampling.hold import spacings_after
from .actuation import Actuators, Foreign, at_rest, commanded, drive


class Delayed(NamedTuple):
    """Where the vehicles are, and what their actuators do.

    Attributes
    ----------
    x : position of the leader [m]
    s, v : (n-1, ...) spacings [m] and (n, ...) speeds [m/s]
    actuators : their state, with the commands on their way
    """

    x: Number
    s: Array
    v: Array
    actuators: Actuators


@dataclass(frozen=True)
class DelayedVehicles:
    """Vehicles that act late, softly and within limits; see `sampling.hold.Plant`.

    Attributes
    ----------
    actuation : dead time, lags and limits
    """

    actuation: Actuation = field(default_factory=Actuation)

    def begin(self, x: Number, s: Array, v: Array) -> Delayed:
        """See `Plant.begin`."""
        return Delayed(x, s, v, at_rest(v))

    def advance(self, vehicles: Delayed, a: Array, tau: float, foreign: Foreign | None = None) -> tuple[Delayed, Array]:
        """The state a time tau later, and the mean accelerations until then.

        Parameters
        ----------
        vehicles : state now
        a : (n, ...) array, accelerations commanded from now on [m/s2]
        tau : time [s], a number
        foreign : vehicles that drive themselves, if any
        """
        x, s, v, actuators = vehicles
        last = actuators.queue[-1][1] if actuators.queue else actuators.command
        if last is not a:  # the same command again says nothing new
            actuators = commanded(actuators, a, self.actuation)
        then, moved, actuators = drive(v, actuators, self.actuation, tau, foreign)
        mean = (then - v) / tau if tau > 0.0 else actuators.a
        return Delayed(x + moved[0], spacings_after(s, moved), then, actuators), mean
