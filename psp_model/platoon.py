"""The closed loop under sampled-data feedback, on a sampling clock of its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from enum import IntEnum
from math import floor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .callbacks import Warns, silent
from .errors import ModelError
from .law.feedback import feedback
from .objective import running_cost
from .parameters import ObjectiveWeights, PotentialParameters
from .sampling.hold import advance, travelled
from .sampling.lemma1 import largest_period, violation
from .state import PlatoonState

Vector = NDArray[np.float64]

MOST_PERIODS = 9e15  # more cannot be told apart in double precision
TIME_TOLERANCE = 1e-6  # [sampling periods] a time this close to a nominal sampling instant is that instant
_SHORTEST = 2.0**-60  # [sampling periods] no period is cut further than this


class Lemma1Policy(IntEnum):
    """What happens at a sampling instant with T >= T_max (ours)."""

    ERROR = 1
    WARN = 2
    SHORTEN = 3


@dataclass(frozen=True)
class Sampling:
    """How the loop is sampled (ours, except T).

    Attributes
    ----------
    T : sampling period [s]
    policy : what happens where Lemma 1 does not certify T
    max_short_periods : most shortened periods in one call of `SampledPlatoon.advance_to`

    Raises
    ------
    ModelError : where T is not positive and finite, the policy is none of the three, or no short period is allowed
    """

    T: float = 0.01
    policy: Lemma1Policy = Lemma1Policy.ERROR
    max_short_periods: int = 100_000

    def __post_init__(self) -> None:
        if not np.isfinite(self.T):
            raise ModelError("finite", "T", self.T, "s")
        if not self.T > 0:
            raise ModelError("T", self.T)
        if self.policy not in list(Lemma1Policy):
            raise ModelError("choice", "lemma1_policy", self.policy, min(Lemma1Policy), max(Lemma1Policy))
        object.__setattr__(self, "policy", Lemma1Policy(self.policy))  # a plain 1, 2 or 3 will do
        if self.max_short_periods < 1:
            raise ModelError("count", "max_short_periods", self.max_short_periods)


@dataclass(frozen=True, eq=False)
class Instant:
    """Everything the loop knows at a sampling instant, just after sampling; the whole state of a run.

    Attributes
    ----------
    period, fraction : time since the start is (period + fraction) T; fraction is in [0, 1), not 0 for policy 3 only
    x, s, v : position of the leader [m], gaps (n-1,) [m], speeds (n,) [m/s]
    a : (n,) accelerations held from here on [m/s2]
    T_max : Lemma 1's bound [s]
    span : how long a is held [sampling periods]
    violations : sampling instants so far at which T >= T_max
    cost : (2,) the two terms of J so far, of acceleration and of gaps
    """

    period: int
    fraction: float
    x: float
    s: Vector
    v: Vector
    a: Vector
    T_max: float
    span: float
    violations: int
    cost: Vector


@dataclass(frozen=True, eq=False)
class Observation:
    """The platoon at some time, as the FMU puts it out.

    Attributes
    ----------
    x, v, a : (n,) positions [m], speeds [m/s], accelerations held [m/s2]
    s : (n-1,) gaps [m]
    cost : (2,) running terms of J, of acceleration and of gaps
    """

    x: Vector
    s: Vector
    v: Vector
    a: Vector
    cost: Vector


def locate(time: float, T: float) -> tuple[int, float]:
    """Time as whole sampling periods and a fraction in [0, 1), rounded to a nominal instant within TIME_TOLERANCE.

    Ours, because masters add their steps up and arrive at a sampling instant with rounding errors.

    Parameters
    ----------
    time : time since the start [s]
    T : sampling period [s]

    Raises
    ------
    ModelError : where that is more sampling periods than can be counted
    """
    periods = time / T
    if not abs(periods) < MOST_PERIODS:
        raise ModelError("periods", time, T)
    nearest = round(periods)
    if abs(periods - nearest) <= TIME_TOLERANCE:
        return nearest, 0.0
    return floor(periods), periods - floor(periods)


@dataclass
class SampledPlatoon(Warns):
    """n vehicles under sampled-data feedback; what happens at the sampling instants does not depend on who looks when.

    Attributes
    ----------
    start : initial state
    shape : the potential in use
    weights : of the objective
    sampling : period and policy
    warn : called with the sentence when policy 2 meets the first uncertified instant of a stretch; a pickle keeps it
        where pickle can
    now : the last sampling instant
    partway : where `advance_to` was refused behind another instant that it had passed, the last one that was in order

    Raises
    ------
    ModelError : at once, if the first instant is not certified under policy 1
    """

    start: PlatoonState
    shape: PotentialParameters
    weights: ObjectiveWeights = field(default_factory=ObjectiveWeights)
    sampling: Sampling = field(default_factory=Sampling)
    warn: Callable[[str], None] = silent
    now: Instant = field(init=False)
    partway: Instant | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        start = self.start
        self._sample(0, 0.0, start.x_leader, start.s, start.v, 0, np.zeros(2))

    @classmethod
    def resume(
        cls,
        start: PlatoonState,
        shape: PotentialParameters,
        weights: ObjectiveWeights,
        sampling: Sampling,
        now: Instant,
    ) -> SampledPlatoon:
        """The platoon that had come to the instant `now`; its future is that of the original, bit for bit (ours).

        Parameters
        ----------
        start, shape, weights, sampling, now : the attributes of the original; `warn` has to be set again
        """
        platoon = cls.__new__(cls)
        platoon.start, platoon.shape, platoon.weights, platoon.sampling = start, shape, weights, sampling
        platoon.warn = silent
        platoon.now = now
        return platoon

    def _sample(self, period: int, fraction: float, x: float, s: Vector, v: Vector, violations: int, cost: Any) -> None:
        """Compute the feedback and Lemma 1 at a sampling instant and make it `now`."""
        constants, T, policy = self.start.constants, self.sampling.T, self.sampling.policy
        if policy is Lemma1Policy.WARN and not (s > constants.L).all():  # the others keep every gap above L
            i = int(np.argmin(s))
            self.now = replace(self.now, period=period, fraction=fraction, x=x, s=s, v=v, cost=cost)
            raise ModelError("left_gap", i + 2, s[i], constants.L, (period + fraction) * T)
        a = feedback(s, v, self.shape, constants)
        T_max = float(largest_period(s, v, a, constants))
        certified = T_max > T
        span = 1.0
        if policy is Lemma1Policy.SHORTEN:
            while not span * T < T_max and span > _SHORTEST:
                span *= 0.5
        span = min(span, 1.0 - fraction)  # the next nominal instant is one in any case
        begins = not certified and (violations == 0 or self.now.T_max > T)
        self.now = Instant(period, fraction, x, s, v, a, T_max, span, violations + (not certified), cost)
        if certified or policy is Lemma1Policy.SHORTEN:
            return
        error = violation((period + fraction) * T, T, s, v, a, constants)
        if policy is Lemma1Policy.ERROR:
            raise error
        if begins:
            self.warn(str(error))

    def take_over(
        self, period: int, fraction: float, x: float, s: Vector, v: Vector, shape: PotentialParameters
    ) -> None:
        """Sample once more, between or at the clock's instants, with other vehicles and another potential (ours).

        Parameters
        ----------
        period, fraction : the time, between the last sampling instant and the next
        x, s, v : position of the leader [m], gaps (m-1,) [m] and speeds (m,) [m/s] of the vehicles from here on, m >= 1
        shape : the potential from here on

        Raises
        ------
        ModelError : as `advance_to` does; the platoon is then as it was
        """
        before, old = self.now, self.shape
        cost = self.observe(period, fraction).cost
        again = (period, fraction) == (before.period, before.fraction)
        violations = before.violations - (again and before.T_max <= self.sampling.T)  # the earlier verdict is void
        self.shape = shape
        try:
            self._sample(period, fraction, x, s, v, violations, cost)
        except ModelError:
            self.now, self.shape = before, old
            raise

    def advance_to(self, period: int, fraction: float) -> None:
        """Pass all sampling instants up to and including a time.

        Parameters
        ----------
        period, fraction : the time, as `locate` gives it

        Raises
        ------
        ModelError : under policy 1 where T is not certified, under policy 2 where a gap has fallen to L (`now` is that
            instant), under policy 3 where more than max_short_periods are needed; `partway` then is the instant to
            go back to, None if none was passed
        """
        short, self.partway = 0, None
        while True:
            now = self.now
            ends = now.fraction + now.span
            if (now.period + 1, 0.0) > (period, fraction) if ends >= 1.0 else (now.period, ends) > (period, fraction):
                return
            if now.span < 1.0 and ends < 1.0:
                short += 1
                if short > self.sampling.max_short_periods or now.span <= _SHORTEST:
                    time = (now.period + now.fraction) * self.sampling.T
                    raise ModelError("short_periods", self.sampling.max_short_periods, time, now.T_max)
            x, s, v, cost = self._after(now.span * self.sampling.T)
            at = (now.period + 1, 0.0) if ends >= 1.0 else (now.period, ends)
            self._sample(*at, x, s, v, now.violations, cost)
            self.partway = self.now

    def _after(self, tau: float) -> tuple[float, Vector, Vector, Vector]:
        """Position of the leader, gaps, speeds and terms of J a time tau [s] after the last sampling instant."""
        now = self.now
        s, v = advance(now.s, now.v, now.a, tau)
        x = now.x + float(travelled(now.v[0], now.a[0], tau))
        return x, s, v, now.cost + np.array(running_cost(now.s, now.v, now.a, tau, self.weights))

    def observe(self, period: int, fraction: float) -> Observation:
        """The platoon at a time between the last sampling instant and the next, by the exact polynomial.

        Parameters
        ----------
        period, fraction : the time; period is that of `now`, fraction up to 1
        """
        now = self.now
        tau = (period - now.period + (fraction - now.fraction)) * self.sampling.T
        x, s, v, cost = (now.x, now.s, now.v, now.cost) if tau == 0.0 else self._after(tau)
        behind = np.empty(v.size)
        behind[0], behind[1:] = x, s
        return Observation(np.subtract.accumulate(behind), s, v, now.a, cost)
