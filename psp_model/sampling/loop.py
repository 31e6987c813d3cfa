"""The closed loop on its sampling clock, as pure functions of explicit state (ours, except the equations they call).

`begin` samples for the first time, `step` goes to the next sampling instant; both return the new instant and a verdict.
Policies act on the verdict elsewhere (`platoon.py`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..law.controller import Controller, TimedController
from ..law.potential import Potential
from ..parameters import ObjectiveWeights
from ..state import read_only, seal
from .exact import exact_violation
from .hold import DoubleIntegrators, Moving, Plant
from .lemma1 import violation
from .period import automated, exact_period_of, hold, lemma1_period, room

Vector = NDArray[np.float64]
Cost = tuple[float, float]

SHORTEST = 2.0**-60  # [sampling periods] no period is cut further than this


class Verdict(Enum):
    """What the chosen certificate says of a sampling instant."""

    CERTIFIED = 1
    NOT_CERTIFIED = 2
    OUTSIDE = 3  # vehicles touch, where the law is not defined


@dataclass(frozen=True)
class Loop:
    """What the loop is made of.

    Attributes
    ----------
    controller : with potential and constants
    weights : of the objective
    T : sampling period [s]
    plant : what is driven
    shorten : whether a period that is not certified is cut in halves until it is
    exact : whether the exact period certifies T, instead of Lemma 1
    timed : whether the controller is told when it decides (`TimedController`)
    """

    controller: Controller[object]
    weights: ObjectiveWeights
    T: float
    plant: Plant[Moving]
    shorten: bool = False
    exact: bool = False
    timed: bool = False


class Instant(NamedTuple):
    """Everything the loop knows at a sampling instant, just after sampling; the whole state of a run.

    s, v and a are read-only.  What controller and plant keep besides (memory, actuators) is theirs, and is not looked
    into.

    Attributes
    ----------
    period, fraction : time since the start is (period + fraction) T; fraction is in [0, 1), not 0 in cut periods only
    vehicles : state of the plant
    a : (n,) accelerations held from here on [m/s2]
    T_max : Lemma 1's bound [s]
    span : how long a is held [sampling periods]
    violations : sampling instants so far at which T was not certified
    cost : the two terms of J so far, of acceleration and of spacings
    memory : what the controller remembers
    T_exact : the exact period [s], None where Lemma 1 certifies
    """

    period: int
    fraction: float
    vehicles: Moving
    a: Vector
    T_max: float
    span: float
    violations: int
    cost: Cost
    memory: object = None
    T_exact: float | None = None

    @property
    def bound(self) -> float:
        """What T has to be below, by the chosen certificate [s]."""
        return self.T_max if self.T_exact is None else self.T_exact

    @property
    def x(self) -> float:
        """Position of the leader [m]."""
        return float(self.vehicles.x)

    @property
    def s(self) -> Vector:
        """Spacings, (n-1,) [m]."""
        return self.vehicles.s

    @property
    def v(self) -> Vector:
        """Speeds, (n,) [m/s]."""
        return self.vehicles.v

    @property
    def ends(self) -> tuple[int, float]:
        """When the next sampling instant is, as period and fraction."""
        end = self.fraction + self.span
        return (self.period + 1, 0.0) if end >= 1.0 else (self.period, end)


def begin(loop: Loop, x: float, s: Vector, v: Vector) -> tuple[Instant, Verdict]:
    """The first sampling instant of a run (ours).

    Parameters
    ----------
    loop : what it is made of
    x, s, v : position of the leader [m], (n-1,) spacings [m], all above L, and (n,) speeds [m/s]
    """
    return _sampled(loop, (0, 0.0), loop.plant.begin(x, read_only(s), read_only(v)), None, 0, (0.0, 0.0), 0.0)


def step(loop: Loop, now: Instant) -> tuple[Instant, Verdict]:
    """The next sampling instant (ours).

    Parameters
    ----------
    loop : what it is made of
    now : the last sampling instant

    Returns
    -------
    the instant and what the certificate says of it; with OUTSIDE its accelerations and T_max are still those of `now`
    """
    tau = now.span * loop.T
    vehicles, cost = after(loop, now, tau)
    # Lemma 1 keeps ideal vehicles inside; the exact period may be met so closely that rounding does not
    may_leave = now.violations > 0 or loop.exact or not isinstance(loop.plant, DoubleIntegrators)
    if may_leave and _is_outside(loop, vehicles):
        return _outside(now, now.ends, vehicles, cost)
    return _sampled(loop, now.ends, vehicles, now.memory, now.violations, cost, tau)


def resample(
    loop: Loop, now: Instant, at: tuple[int, float], motion: tuple[float, Vector, Vector], memory: object = None
) -> tuple[Instant, Verdict]:
    """Sample once more, between or at the clock's instants, because the vehicles or the potential have changed (ours).

    Parameters
    ----------
    loop : what it is made of from here on
    now : the last sampling instant; its weights and its T were those of `loop`
    at : the time, between `now` and the next instant, as period and fraction
    motion : position of the leader [m], (m-1,) spacings [m] and (m,) speeds [m/s] from here on, m >= 1
    memory : what the controller remembered at `now`, of these vehicles

    Returns
    -------
    the instant and what the certificate says of it, as `step` does; where it is at the time of `now`, the verdict on
    `now` no longer counts
    """
    tau = (at[0] - now.period + (at[1] - now.fraction)) * loop.T
    cost = now.cost if tau == 0.0 else after(loop, now, tau)[1]
    again = at == (now.period, now.fraction)
    violations, (x, s, v) = now.violations - (again and now.bound <= loop.T), motion
    vehicles = loop.plant.begin(x, read_only(s), read_only(v))
    if _is_outside(loop, vehicles):
        return _outside(now, at, vehicles, cost)
    return _sampled(loop, at, vehicles, memory, violations, cost, tau)


def redecide(loop: Loop, now: Instant) -> tuple[Instant, Verdict]:
    """Sample once more at the time of the last instant, because what the controller is told has changed (ours).

    Parameters
    ----------
    loop : what it is made of from here on
    now : the last sampling instant, whose verdict no longer counts
    """
    violations = now.violations - (now.bound <= loop.T)
    return _sampled(loop, (now.period, now.fraction), now.vehicles, now.memory, violations, now.cost, 0.0)


def after(loop: Loop, now: Instant, tau: float) -> tuple[Moving, Cost]:
    """State of the plant and terms of J a time tau after a sampling instant (ours).

    Parameters
    ----------
    loop, now : as for `step`
    tau : time [s]
    """
    vehicles, added = hold(loop.plant, now.vehicles, now.a, tau, loop.weights)
    return vehicles, (now.cost[0] + float(added[0]), now.cost[1] + float(added[1]))


def refusal(loop: Loop, now: Instant, verdict: Verdict) -> ModelError:
    """The error for an instant that is not certified, with its values, bound and remedy (ours).

    Parameters
    ----------
    loop, now : as `step` returned it
    verdict : NOT_CERTIFIED or OUTSIDE
    """
    constants, time = loop.controller.constants, (now.period + now.fraction) * loop.T
    length = getattr(getattr(loop.controller, "cooperation", None), "length", None)
    ahead = None if length is None else np.broadcast_to(length, now.v.shape)[:-1]
    if verdict is Verdict.OUTSIDE:
        i = int(np.argmin(room(loop.controller, now.s)))
        least = constants.L if ahead is None else ahead[i]
        return ModelError("left_spacing" if least == constants.L else "left_length", i + 2, now.s[i], least, time)
    say = exact_violation if loop.exact else violation
    return say(time, loop.T, now.s, now.v, now.a, constants, ahead, automated(loop.controller, now.a))


def with_potential(loop: Loop, potential: Potential) -> Loop:
    """The same loop with another potential (ours).

    Parameters
    ----------
    loop : what it is made of
    potential : the other one
    """
    return replace(loop, controller=replace(loop.controller, potential=potential))  # type: ignore[type-var]


def _is_outside(loop: Loop, vehicles: Moving) -> bool:
    """Whether vehicles touch; ideal ones cannot where periods are cut until Lemma 1 certifies them."""
    kept = loop.shorten and not loop.exact and isinstance(loop.plant, DoubleIntegrators)
    return not kept and not (room(loop.controller, vehicles.s) > loop.controller.constants.L).all()


def _outside(now: Instant, at: tuple[int, float], vehicles: Moving, cost: Cost) -> tuple[Instant, Verdict]:
    """The instant at which the law is not defined: nothing is decided anew."""
    seal(vehicles.s, vehicles.v)
    return now._replace(period=at[0], fraction=at[1], vehicles=vehicles, cost=cost), Verdict.OUTSIDE


def _sampled(
    loop: Loop, at: tuple[int, float], vehicles: Moving, memory: object, violations: int, cost: Cost, since: float
) -> tuple[Instant, Verdict]:
    """The sampling instant at a time: commands, T_max, and how long the commands are held."""
    memory, a = _decided(loop, at, vehicles, memory, since)
    T_exact, bound = None, (T_max := float(lemma1_period(loop.controller, vehicles, a)))
    if loop.exact:
        bound = T_exact = float(exact_period_of(loop.controller, vehicles, a, memory))
    certified, span = bound > loop.T, 1.0
    if loop.shorten:
        while not span * loop.T < bound and span > SHORTEST:
            span *= 0.5
    span = min(span, 1.0 - at[1])  # the next nominal instant is one in any case
    count = violations + (not certified)
    seal(vehicles.s, vehicles.v, a)
    now = Instant(*at, vehicles, a, T_max, span, count, cost, memory, T_exact)
    return now, Verdict.CERTIFIED if certified else Verdict.NOT_CERTIFIED


def _decided(
    loop: Loop, at: tuple[int, float], vehicles: Moving, memory: object, since: float
) -> tuple[object, Vector]:
    """What the controller remembers and commands at a time."""
    if not loop.timed:
        return loop.controller.decide(memory, vehicles.s, vehicles.v)
    law = cast(TimedController[object], loop.controller)
    return law.decide_after(memory, vehicles.s, vehicles.v, since, at[1] == 0.0)
