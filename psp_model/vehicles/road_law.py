"""The extended law with its predictor, as one controller (ours)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from ..errors import ModelError
from ..law.cooperation import Cooperation, Traffic, closing_speeds, is_off, model_spacing
from ..law.potential import Potential
from ..law.watching import Watched, accelerations, watch
from ..namespaces import Array, Number
from ..parameters import Actuation, PlatoonParameters
from .actuation import Foreign, limited
from .prediction import Issued, Predicted, issue, nothing_issued, predict, predictive_command


class Seen(NamedTuple):
    """What is measured and communicated at a sampling instant.

    Attributes
    ----------
    s, v : (n-1, ...) spacings [m] and (n, ...) speeds [m/s]
    age : how old they are [s]
    automated : (n, ...) array, 0 for a vehicle that drives itself, 1 else; None where all are automated
    a : (n, ...) accelerations communicated by vehicles that drive themselves [m/s2]; None for none
    known : (n, ...) 1 where they are communicated, else 0; None for everywhere
    v_desired, a_desired : desired speed of vehicles that follow none, None for v* [m/s], and its derivative [m/s2]
    """

    s: Array
    v: Array
    age: float = 0.0
    automated: Array | None = None
    a: Array | None = None
    known: Array | None = None
    v_desired: Number | None = None
    a_desired: Number = 0.0


class Remembered(NamedTuple):
    """What the controller remembers.

    Attributes
    ----------
    issued : its commands, and the modelled actuators
    watched : speeds of others, and closing up; None before the first sampling instant
    predicted : the state at which the last command was decided, None before the first
    """

    issued: Issued
    watched: Watched | None = None
    predicted: Predicted | None = None


@dataclass(frozen=True)
class RoadLaw:
    """The extended law at the predicted state; see `law.controller.Controller` (ours).

    Attributes
    ----------
    potential, constants : of the model
    cooperation : parameters of the extended law
    actuation : what the controller believes of dead time, lags and limits
    T : sampling period [s]
    oldest : largest age of a measurement [s]
    automated : (n, ...) array, 0 for a vehicle that drives itself; None where all are automated
    """

    potential: Potential
    constants: PlatoonParameters
    cooperation: Cooperation = field(default_factory=Cooperation)
    actuation: Actuation = field(default_factory=Actuation)
    T: float = 0.01
    oldest: float = 0.0
    automated: Array | None = None

    def decide(self, memory: Remembered | None, s: Array, v: Array) -> tuple[Remembered, Array]:
        """See `Controller.decide`."""
        return self.sample(memory, Seen(s, v, automated=self.automated))

    def sample(self, memory: Remembered | None, seen: Seen) -> tuple[Remembered, Array]:
        """The commands at a sampling instant, from measurements of some age.

        Parameters
        ----------
        memory : what the last call returned, None before the first
        seen : what is measured and communicated

        Returns
        -------
        what to remember, and the (n, ...) accelerations commanded [m/s2], 0 for vehicles that drive themselves

        Raises
        ------
        ModelError : where the measurement is older than `oldest`
        """
        if seen.age > self.oldest * (1.0 + 1e-9):
            raise ModelError("older", seen.age, self.oldest)
        memory = memory or Remembered(nothing_issued(seen.v, self.oldest))
        watched, predicted, wanted = self.wanted(memory, seen)
        a = limited(wanted, self.actuation)
        if seen.automated is not None:
            a = a * seen.automated
        return Remembered(issue(memory.issued, a, self.T, self.actuation), watched, predicted), a

    def wanted(self, memory: Remembered, seen: Seen) -> tuple[Watched | None, Predicted, Array]:
        """What the law asks for, before it is limited, and what it is asked for.

        Parameters
        ----------
        memory : what is remembered
        seen : what is measured and communicated

        Returns
        -------
        what is remembered of others, None where nothing is; the state at which the law is evaluated; and the (n, ...)
        accelerations [m/s2], which mean nothing for vehicles that drive themselves
        """
        watched = self._watch(memory.watched, seen)
        foreign = None
        if seen.automated is not None:
            foreign = Foreign(seen.automated, accelerations(watched, seen.a, seen.known)) if watched else None
        predicted = predict(memory.issued, seen.s, seen.v, seen.age, self.actuation, foreign)
        closing = None if watched is None or is_off(self.cooperation.closing_speed) else watched.closing
        traffic = Traffic(seen.automated, None, seen.v_desired, seen.a_desired, closing)
        lag = self.actuation.actuator_lag
        wanted = predictive_command(predicted, self.potential, self.constants, self.cooperation, traffic, lag)
        return watched, predicted, wanted

    def _watch(self, before: Watched | None, seen: Seen) -> Watched | None:
        """What is remembered of others; nothing where all are automated and none closes up."""
        idle = is_off(self.cooperation.closing_speed)
        if seen.automated is None and idle:
            return None
        wanted = 0.0 * seen.v
        if not idle:
            spacing = model_spacing(seen.s, seen.v, self.cooperation, self.constants)
            wanted = closing_speeds(spacing, self.cooperation, seen.automated)
        return watch(before, seen.v, wanted, self.T)
