"""What a controller of measured vehicles is told once."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..law.cooperation import Cooperation
from ..parameters import NO_LIMIT, Actuation, ObjectiveWeights, PlatoonParameters
from ..sampling.policy import Sampling
from ..sampling.uncertain import Errors
from ..selection.feasible import require_feasible
from ..selection.selectors import Request
from ..validate import validate, validate_law

Vector = NDArray[np.float64]

PREDICTED_AGE = 1.0  # [s] what is measured is predicted from, if it is no older (ours)
MOST_COMMANDS = 512  # so many commands on their way are remembered (ours)


class BadMeasurement(IntEnum):
    """What happens where the inputs are stale, not finite or outside the state space (ours)."""

    ERROR = 1
    SAFE_ACTION = 2


def _no_limits() -> Actuation:
    return Actuation(a_min=-NO_LIMIT, a_max=NO_LIMIT)


@dataclass(frozen=True)
class ControllerSettings:
    """The settings of a controller.

    Attributes
    ----------
    capacity : most vehicles N
    constants, weights, sampling : of the model; policy 3 makes no sense here and counts as 2
    request : where alpha, r, p come from; its fixed triple also serves where there is no network for n vehicles
    cooperation : of the extended law; lengths are None, a number or (N,)
    actuation : what is believed of dead time and lags, and the bounds of the commands; numbers or (N,)
    errors : bounds on what is wrong with spacings and speeds
    bad_input : what bad measurements lead to
    a_safe : fail-safe command, until standstill [m/s2] (ours)
    max_age : inputs older than this are stale [s] (ours)
    """

    capacity: int
    constants: PlatoonParameters = field(default_factory=PlatoonParameters)
    weights: ObjectiveWeights = field(default_factory=ObjectiveWeights)
    sampling: Sampling = field(default_factory=Sampling)
    request: Request = field(default_factory=Request)
    cooperation: Cooperation = field(default_factory=Cooperation)
    actuation: Actuation = field(default_factory=_no_limits)
    errors: Errors = field(default_factory=Errors)
    bad_input: BadMeasurement = BadMeasurement.ERROR
    a_safe: float = -2.0
    max_age: float = 1e9

    @cached_property
    def predicts(self) -> bool:
        """Whether the law is evaluated at a predicted state: where dead time, a lag or the age of inputs is told."""
        told = self.actuation.actuation_delay > 0.0 or bool(np.any(np.asarray(self.actuation.actuator_lag) > 0.0))
        return told or self.max_age <= PREDICTED_AGE

    @cached_property
    def oldest(self) -> float:
        """The largest age that is predicted from [s]: up to PREDICTED_AGE, as far as commands are remembered."""
        if not self.predicts:
            return 0.0
        remembered = (MOST_COMMANDS - 2) * self.sampling.T - self.actuation.actuation_delay
        return min(self.max_age, PREDICTED_AGE, remembered)

    def checked(self) -> ControllerSettings:
        """The same.

        Raises
        ------
        ModelError : where bounds, a_safe or max_age make no sense, the extended law or the actuators are outside their
            domain, too many commands would have to be remembered, or the fixed triple is not feasible
        """
        if not np.isfinite(self.a_safe):
            raise ModelError("finite", "a_safe", self.a_safe, "m/s2")
        self._check_limits()
        if not self.a_safe <= 0:
            raise ModelError("a_safe_positive", self.a_safe)
        if not self.max_age > 0:
            raise ModelError("max_age", self.max_age)
        validate_law(self.cooperation, self.constants)
        validate(self.actuation)
        validate(self.errors)
        if self.predicts and not self.oldest >= 0.0:
            delay, T = self.actuation.actuation_delay, self.sampling.T
            raise ModelError("dead_time", delay, MOST_COMMANDS - 2, T)
        if not self.request.old:
            require_feasible(self.request.fixed, self.constants)
        return self

    def _check_limits(self) -> None:
        """The bounds of the commands are finite, and a_safe is inside them; ModelError else."""
        for name in ("a_min", "a_max"):
            for i, limit in enumerate(np.ravel(getattr(self.actuation, name)).tolist(), start=1):
                if not np.isfinite(limit):
                    raise ModelError("finite", f"{name}[{i}]", limit, "m/s2")
        for i, least in enumerate(np.ravel(self.actuation.a_min).tolist(), start=1):
            if least < 0 and not self.a_safe >= least:
                raise ModelError("a_safe", self.a_safe, i, least)

    def of(self, n: int) -> tuple[Cooperation, Actuation]:
        """Law and actuators of the first n vehicles.

        Parameters
        ----------
        n : how many are under control
        """
        if n == self.capacity:
            return self.cooperation, self.actuation
        cooperation, actuation, length = self.cooperation, self.actuation, self.cooperation.length
        if isinstance(length, np.ndarray):
            cooperation = replace(cooperation, length=length[:n])

        def rows(value: float | Vector) -> float | Vector:
            return value[:n] if isinstance(value, np.ndarray) else value

        lag, least, most = rows(actuation.actuator_lag), rows(actuation.a_min), rows(actuation.a_max)
        return cooperation, replace(actuation, actuator_lag=lag, a_min=least, a_max=most)
