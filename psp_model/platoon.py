"""The closed loop under one of the policies of Lemma 1, observable at any time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import ArrayLike

from .callbacks import Warns, silent
from .errors import ModelError
from .law.controller import Controller, MakeController, Memory, PaperLaw
from .law.cooperation import PAPERS_LAW
from .law.potential import Potential
from .parameters import ObjectiveWeights, PlatoonParameters
from .sampling.hold import IDEAL, Moving, Plant, Vehicles
from .sampling.loop import (
    SHORTEST,
    Instant,
    Loop,
    Vector,
    Verdict,
    after,
    begin,
    redecide,
    refusal,
    resample,
    step,
    with_potential,
)
from .sampling.policy import Certificate, Lemma1Policy, Sampling
from .state import PlatoonState, read_only
from .validate import validate, validate_start


class Observation(NamedTuple):
    """The platoon at some time, as the FMU puts it out.

    Attributes
    ----------
    x, v, a : (n,) positions [m], speeds [m/s], accelerations held [m/s2]
    s : (n-1,) spacings [m]
    cost : (2,) running terms of J, of acceleration and of spacings
    """

    x: Vector
    s: Vector
    v: Vector
    a: Vector
    cost: Vector


def loop_of(
    shape: Potential,
    constants: PlatoonParameters,
    weights: ObjectiveWeights,
    sampling: Sampling,
    controller: MakeController[Memory] | None = None,
    plant: Plant[Vehicles] | None = None,
) -> Loop:
    """The pure loop that a platoon drives (ours).

    Parameters
    ----------
    shape, constants, weights, sampling, controller, plant : as `SampledPlatoon.begin` takes them
    """
    shorten = sampling.policy == Lemma1Policy.SHORTEN
    law: object = PaperLaw(shape, constants) if controller is None else controller(shape, constants)
    # the loop hands controller and plant what they have returned, and nothing else: it need not know those types
    driven = cast(Plant[Moving], IDEAL if plant is None else plant)
    made, exact = cast(Controller[object], law), sampling.certificate == Certificate.EXACT
    return Loop(made, weights, sampling.T, driven, shorten, exact, hasattr(law, "decide_after"))


@dataclass(eq=False)
class SampledPlatoon(Warns):
    """n vehicles under sampled-data feedback; the sampling instants are independent of the communication step.

    A shell around the pure loop: it keeps the last instant, and acts on verdicts as the policy says.  `begin` makes one
    from an initial state; made from an instant of an earlier run, its future is that run's, bit for bit.

    Attributes
    ----------
    loop : controller with potential and constants, weights, period and plant
    sampling : period and policy
    now : the last sampling instant
    warn : called with the sentence when policy 2 meets the first uncertified instant of a stretch; a pickle keeps it
        where pickle can
    partway : where `advance_to` raised after it had passed an instant, the last instant that was certified
    """

    loop: Loop
    sampling: Sampling
    now: Instant
    warn: Callable[[str], None] = silent
    partway: Instant | None = field(init=False, default=None)

    @classmethod
    def begin(
        cls,
        start: PlatoonState,
        shape: Potential,
        weights: ObjectiveWeights | None = None,
        sampling: Sampling | None = None,
        warn: Callable[[str], None] = silent,
        *,
        controller: MakeController[Memory] | None = None,
        plant: Plant[Vehicles] | None = None,
    ) -> SampledPlatoon:
        """A platoon at its first sampling instant.

        Parameters
        ----------
        start : initial state
        shape : the potential
        weights : of the objective; the paper's by default
        sampling : period and policy; T = 0.01 s and errors by default
        warn : as the attribute
        controller : makes the controller from potential and constants; the paper's law by default
        plant : what is driven; double integrators by default

        Raises
        ------
        ModelError : where a value is outside the model's domain, or the first instant not certified under policy 1
        """
        weights, sampling = validate(weights or ObjectiveWeights()), validate(sampling or Sampling())
        validate(start if controller is None else start.constants), validate(shape)
        loop = loop_of(shape, start.constants, weights, sampling, controller, plant)
        validate_start(start, getattr(loop.controller, "cooperation", PAPERS_LAW))
        now, verdict = begin(loop, start.x_leader, start.s, start.v)
        platoon = cls(loop, sampling, now, warn)
        platoon._act(None, now, verdict)
        return platoon

    @property
    def constants(self) -> PlatoonParameters:
        """The constants of the model."""
        return self.loop.controller.constants

    @property
    def shape(self) -> Potential:
        """The potential in use."""
        return self.loop.controller.potential

    @property
    def weights(self) -> ObjectiveWeights:
        """Weights of the objective."""
        return self.loop.weights

    def _act(self, before: Instant | None, now: Instant, verdict: Verdict) -> None:
        """What the policy has done about a verdict.

        Raises
        ------
        ModelError : under policy 1 where T is not certified, under any where a spacing has fallen to L
        """
        if verdict is Verdict.CERTIFIED:
            return
        if verdict is Verdict.OUTSIDE or self.sampling.policy == Lemma1Policy.ERROR:
            raise refusal(self.loop, now, verdict)
        begins = before is None or now.violations == 1 or before.bound > self.loop.T
        if self.sampling.policy == Lemma1Policy.WARN and begins:
            self.warn(str(refusal(self.loop, now, verdict)))

    def take_over(
        self,
        period: int,
        fraction: float,
        x: float,
        s: ArrayLike,
        v: ArrayLike,
        shape: Potential,
        *,
        loop: Loop | None = None,
        memory: object = None,
    ) -> SampledPlatoon:
        """The platoon sampled once more, between or at the clock's instants, with other vehicles and potential (ours).

        Parameters
        ----------
        period, fraction : the time, between the last sampling instant and the next
        x, s, v : position of the leader [m], spacings (m-1,) [m] and speeds (m,) [m/s] of the vehicles from here on
        shape : the potential from here on
        loop : what it is made of from here on, but for the potential; as it was by default
        memory : what the controller remembers of these vehicles

        Returns
        -------
        another platoon; this one is unchanged

        Raises
        ------
        ModelError : as `advance_to` does
        """
        loop = with_potential(loop or self.loop, shape)
        now, verdict = resample(loop, self.now, (period, fraction), (x, read_only(s), read_only(v)), memory)
        changed = SampledPlatoon(loop, self.sampling, now, self.warn)
        changed._act(self.now, now, verdict)
        return changed

    def redecide(self, loop: Loop) -> None:
        """Decide anew at the last sampling instant, because what the controller is told has changed (ours).

        Parameters
        ----------
        loop : what the platoon is made of from here on

        Raises
        ------
        ModelError : as `advance_to` does
        """
        before = self.now
        self.loop = loop
        self.now, verdict = redecide(loop, before)
        self._act(before, self.now, verdict)

    def advance_to(self, period: int, fraction: float) -> None:
        """Pass all sampling instants up to and including a time.

        Parameters
        ----------
        period, fraction : the time, as `locate` gives it

        Raises
        ------
        ModelError : under policy 1 where T is not certified, under policy 2 where a spacing has fallen to L (`now` is
            that instant), under policy 3 where more than max_short_periods are needed; `partway` then is the instant
            to go back to, None if none was passed
        """
        short, to, self.partway = 0, (period, fraction), None
        while (ends := (now := self.now).ends) <= to:
            if ends[1] > 0.0:
                short += 1
                if short > self.sampling.max_short_periods or now.span <= SHORTEST:
                    time = (now.period + now.fraction) * self.loop.T
                    key = "short_periods_exact" if self.loop.exact else "short_periods"
                    raise ModelError(key, self.sampling.max_short_periods, time, now.bound)
            self.now, verdict = step(self.loop, now)
            if verdict is not Verdict.CERTIFIED:
                self._act(now, self.now, verdict)
            self.partway = self.now

    def observe(self, period: int, fraction: float) -> Observation:
        """The platoon at a time between the last sampling instant and the next, by the exact polynomial.

        Parameters
        ----------
        period, fraction : the time; period is that of `now`, fraction up to 1
        """
        now = self.now
        tau = (period - now.period + (fraction - now.fraction)) * self.loop.T
        vehicles, cost = (now.vehicles, now.cost) if tau == 0.0 else after(self.loop, now, tau)
        behind = np.empty(vehicles.v.size)
        behind[0], behind[1:] = vehicles.x, vehicles.s
        return Observation(np.subtract.accumulate(behind), vehicles.s, vehicles.v, now.a, np.array(cost))
