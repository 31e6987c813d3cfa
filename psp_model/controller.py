"""The feedback law as a controller of measured vehicles: spacings and speeds in, accelerations out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum, IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .callbacks import Warns, silent
from .errors import ModelError
from .law.feedback import feedback, feedback_towards
from .law.potential import V_OLD, PotentialParameters
from .parameters import NO_LIMIT, ObjectiveWeights, PlatoonParameters
from .sampling.lemma1 import largest_period
from .sampling.policy import Lemma1Policy, Sampling
from .selection.feasible import require_feasible
from .selection.network import ParameterNetwork
from .selection.selectors import Request, Selector, Trained, lies_in_domain, selector_for
from .state import read_only, seal

Vector = NDArray[np.float64]

ROUNDING = 1e-6  # [1] of L or v_max: what is measured so little outside the state space is taken as its bound (ours)


class BadMeasurement(IntEnum):
    """What happens where the inputs are stale, not finite or outside the state space (ours)."""

    ERROR = 1
    SAFE_ACTION = 2


@dataclass(frozen=True)
class ControllerSettings:
    """The settings of a controller.

    Attributes
    ----------
    capacity : most vehicles N
    constants, weights, sampling : of the model; policy 3 makes no sense here and counts as 2
    request : where alpha, r, p come from; its fixed triple also serves where there is no network for n vehicles
    a_min, a_max : bounds of the command [m/s2] (ours)
    bad_input : what bad measurements lead to
    a_safe : fail-safe command, until standstill [m/s2] (ours)
    max_age : inputs older than this are stale [s] (ours)
    """

    capacity: int
    constants: PlatoonParameters = field(default_factory=PlatoonParameters)
    weights: ObjectiveWeights = field(default_factory=ObjectiveWeights)
    sampling: Sampling = field(default_factory=Sampling)
    request: Request = field(default_factory=Request)
    a_min: float = -NO_LIMIT
    a_max: float = NO_LIMIT
    bad_input: BadMeasurement = BadMeasurement.ERROR
    a_safe: float = -2.0
    max_age: float = 1e9

    def checked(self) -> ControllerSettings:
        """The same.

        Raises
        ------
        ModelError : where the bounds, a_safe or max_age make no sense, or the fixed triple is not feasible
        """
        for name in ("a_min", "a_max", "a_safe"):
            if not np.isfinite(getattr(self, name)):
                raise ModelError("finite", name, getattr(self, name), "m/s2")
        if not self.a_min < 0:
            raise ModelError("a_min", self.a_min)
        if not self.a_max > 0:
            raise ModelError("a_max", self.a_max)
        if not self.a_safe <= 0:
            raise ModelError("a_safe_positive", self.a_safe)
        if not self.a_safe >= self.a_min:
            raise ModelError("a_safe", self.a_safe, self.a_min)
        if not self.max_age > 0:
            raise ModelError("max_age", self.max_age)
        if not self.request.old:
            require_feasible(self.request.fixed, self.constants)
        return self


@dataclass(frozen=True, eq=False, init=False)
class Measurement:
    """The inputs at a sampling instant; lists and tuples are accepted.

    Attributes
    ----------
    s, v : (N-1,) spacings [m] and (N,) speeds [m/s], leader first; only the first n_active vehicles count
    n_active : vehicles under control
    resolve : replan, that is select alpha, r, p again, where this rises above 0.5
    age : time since spacings and speeds were measured [s]
    age_rounding : how far the age may be off because clocks are rounded [s]
    v_desired : desired speed instead of v_star, 0 to stand, None for v_star [m/s] (ours: the paper has one v_star for
        good)
    """

    s: Vector
    v: Vector
    n_active: float
    resolve: float = 0.0
    age: float = 0.0
    age_rounding: float = 0.0
    v_desired: float | None = None

    def __init__(
        self,
        s: ArrayLike,
        v: ArrayLike,
        n_active: float,
        resolve: float = 0.0,
        age: float = 0.0,
        age_rounding: float = 0.0,
        v_desired: float | None = None,
    ) -> None:
        object.__setattr__(self, "s", np.asarray(s, dtype=np.float64))
        object.__setattr__(self, "v", np.asarray(v, dtype=np.float64))
        object.__setattr__(self, "n_active", n_active)
        object.__setattr__(self, "resolve", resolve)
        object.__setattr__(self, "age", age)
        object.__setattr__(self, "age_rounding", age_rounding)
        object.__setattr__(self, "v_desired", v_desired)


@dataclass(frozen=True, eq=False)
class Command:
    """What the controller decided at a sampling instant, and all that it remembers of the past.

    Attributes
    ----------
    a : (N,) commanded accelerations [m/s2], 0 for vehicles that are not active
    saturated : (N,) whether a_min or a_max cut the feedback, so that Lemma 1's argument does not cover the vehicle
    in_order : whether the inputs were valid; if not, this is the fail-safe command
    T_max : Lemma 1's bound for the command [s], 0 with the fail-safe command
    violations, faults : sampling instants so far with T >= T_max, and with invalid inputs
    choices : how often alpha, r, p were selected
    n_active : vehicles under control at the last selection
    in_domain : whether the vehicles were in a network's training domain at the last selection
    resolve : the input at the last sampling instant
    shape : the potential in use
    """

    a: Vector
    saturated: NDArray[np.bool_]
    in_order: bool
    T_max: float
    violations: int
    faults: int
    choices: int
    n_active: int
    in_domain: bool
    resolve: float
    shape: PotentialParameters


class Verdict(Enum):
    """What is to be said of a decision."""

    IN_ORDER = 1
    NOT_CERTIFIED = 2
    BAD_MEASUREMENT = 3  # the command is the fail-safe one


class Decision(NamedTuple):
    """What was decided, and what is to be said of it.

    Attributes
    ----------
    command : the command, and the new state of the controller
    verdict : what is to be said of it
    why : the sentence, None where all is in order
    warning : why the potential is not the one asked for, None where it is
    """

    command: Command
    verdict: Verdict
    why: ModelError | None = None
    warning: str | None = None


def no_command(settings: ControllerSettings) -> Command:
    """The state before the first sampling instant: nothing is commanded.

    Parameters
    ----------
    settings : of the controller
    """
    nobody, request = read_only(np.zeros(settings.capacity)), settings.request
    shape = V_OLD if request.old else request.fixed
    return Command(nobody, nobody > 0, True, 0.0, 0, 0, 0, 0, False, 0.0, shape)


def decide(
    settings: ControllerSettings,
    selector: Selector,
    trained: Mapping[int, Trained],
    before: Command,
    time: float,
    measured: Measurement,
) -> Decision:
    """The decision at a sampling instant; pure (ours, except the law).

    Parameters
    ----------
    settings : of the controller
    selector : selects alpha, r, p
    trained : what networks were trained on, by number of vehicles
    before : the last decision
    time : of the instant [s], for messages
    measured : the inputs

    Raises
    ------
    ModelError : where a network file is at fault
    """
    try:
        taken = _in_order(settings, measured)
    except ModelError as error:
        return Decision(_fail_safe(settings, before, measured), Verdict.BAD_MEASUREMENT, error)
    now, warning = _chosen(settings, selector, trained, before, taken)
    return _regular(settings, now, time, taken)._replace(warning=warning)


def _in_order(settings: ControllerSettings, measured: Measurement) -> Measurement:
    """The inputs of the active vehicles, inside the state space; ModelError where an input is not in order.

    What lies outside by no more than ROUNDING is taken as the bound, a spacing as the next number above L: vehicles
    that stand have speeds and spacings such as -1e-18 m/s and L - 1e-12 m.  Under policy 1, which asks for spacings
    above L + v_max T, a spacing of L or less is rejected all the same.
    """
    n = measured.n_active
    L, v_max = settings.constants.L, settings.constants.v_max
    above_L = np.nextafter(L, np.inf)
    least = above_L if settings.sampling.policy == Lemma1Policy.ERROR else L - ROUNDING * L
    if not (1 <= n <= settings.capacity and n == int(n)):
        raise ModelError("active", n, settings.capacity)
    if not np.isfinite(measured.age):
        raise ModelError("age", measured.age)
    if not measured.age <= settings.max_age + measured.age_rounding:
        raise ModelError("stale", measured.age, settings.max_age)
    if not np.isfinite(measured.resolve):
        raise ModelError("finite", "resolve", measured.resolve, "1")
    desired = measured.v_desired
    if desired is not None:
        _require_desired(desired, v_max)
        desired = min(max(desired, 0.0), v_max)
    s, v = measured.s[: int(n) - 1], measured.v[: int(n)]
    for i in np.flatnonzero(~((s >= least) & (s < np.inf))).tolist():
        raise _bad_gap(i + 2, s[i], L)
    for i in np.flatnonzero(~((v >= -ROUNDING * v_max) & (v <= v_max + ROUNDING * v_max))).tolist():
        raise _bad_speed(i + 1, v[i], v_max)
    s, v = np.maximum(s, above_L), np.clip(v, 0.0, v_max)
    return replace(measured, s=s, v=v, v_desired=desired)


def _chosen(
    settings: ControllerSettings,
    selector: Selector,
    trained: Mapping[int, Trained],
    before: Command,
    measured: Measurement,
) -> tuple[Command, str | None]:
    """The last decision with the potential to use from now on, and what to warn of."""
    s, v, constants = measured.s, measured.v, settings.constants
    if not (v.size != before.n_active or measured.resolve > 0.5 >= before.resolve):
        return before, None
    shape, _, warning = selector.select(s, v, constants)
    in_domain = lies_in_domain(trained, s, v, constants)
    return replace(before, shape=shape, in_domain=in_domain, choices=before.choices + 1), warning


def _regular(settings: ControllerSettings, before: Command, time: float, measured: Measurement) -> Decision:
    """The bounded feedback for vehicles that are in order; `before` has the potential to use."""
    constants, T, shape = settings.constants, settings.sampling.T, before.shape
    s, v, n = measured.s, measured.v, measured.v.size
    if measured.v_desired is None:
        wanted = feedback(s, v, shape, constants)
    else:
        wanted = feedback_towards(s, v, shape, constants, measured.v_desired)
    a, saturated = np.zeros(settings.capacity), np.zeros(settings.capacity, dtype=bool)
    a[:n] = np.clip(wanted, settings.a_min, settings.a_max)
    saturated[:n] = a[:n] != wanted
    seal(a, saturated)
    T_max = float(largest_period(s, v, a[:n], constants))
    certified = T_max > T
    counts = (before.violations + (not certified), before.faults, before.choices)
    now = Command(a, saturated, True, T_max, *counts, n, before.in_domain, measured.resolve, shape)
    if certified:
        return Decision(now, Verdict.IN_ORDER)
    return Decision(now, Verdict.NOT_CERTIFIED, _violation(time, T, T_max, s, constants))


def _fail_safe(settings: ControllerSettings, before: Command, measured: Measurement) -> Command:
    """The fail-safe command: every vehicle slows down by a_safe, but not below standstill where the speed is known."""
    known = np.where(np.isfinite(measured.v), np.maximum(measured.v, 0.0), np.inf)
    a = np.maximum(settings.a_safe, -known / settings.sampling.T)
    n = measured.n_active
    active = int(n) if 1 <= n <= settings.capacity and n == int(n) else settings.capacity
    a[active:], saturated = 0.0, np.zeros(settings.capacity, dtype=bool)
    seal(a, saturated)
    return replace(
        before,
        a=a,
        saturated=saturated,
        in_order=False,
        T_max=0.0,
        faults=before.faults + 1,
    )


@dataclass
class SampledController(Warns):
    """The feedback law for measured vehicles: a shell around `decide` that acts on its verdicts as the policies say.

    Attributes
    ----------
    settings : of the controller
    selector : selects alpha, r, p
    trained : what networks were trained on, by number of vehicles
    now : the command held, all zeros before the first sampling instant
    warn : called with one sentence for each thing to be warned of
    """

    settings: ControllerSettings
    selector: Selector
    trained: Mapping[int, Trained]
    now: Command
    warn: Callable[[str], None] = silent

    @classmethod
    def begin(
        cls,
        settings: ControllerSettings,
        networks: Mapping[int, ParameterNetwork] | None = None,
        warn: Callable[[str], None] = silent,
        trained: Mapping[int, Trained] | None = None,
    ) -> SampledController:
        """A controller before its first sampling instant.

        Parameters
        ----------
        settings : of the controller
        networks : by number of vehicles
        warn : as the attribute
        trained : as the attribute, where it is known without opening the networks

        Raises
        ------
        ModelError : where the settings make no sense
        """
        settings.checked()
        selector = selector_for(settings.request, networks or {}, settings.weights, settings.sampling)
        known = (networks or {}) if trained is None else trained
        return cls(settings, selector, known, no_command(settings), warn)

    def sample(self, time: float, measured: Measurement) -> None:
        """Decide at a sampling instant and make the decision `now`.

        Parameters
        ----------
        time : of the instant [s], for messages
        measured : the inputs

        Raises
        ------
        ModelError : with bad_input 1 where the inputs are not in order; under policy 1 where T is not certified; where
            a network file is at fault
        """
        before, settings = self.now, self.settings
        decision = decide(settings, self.selector, self.trained, before, time, measured)
        if decision.warning:
            self.warn(decision.warning)
        if decision.verdict is Verdict.BAD_MEASUREMENT:
            assert decision.why is not None
            if settings.bad_input == BadMeasurement.ERROR:
                raise decision.why
            if before.in_order:
                self.warn(str(ModelError("safe_action", time, decision.why)))
        if decision.verdict is Verdict.NOT_CERTIFIED:
            assert decision.why is not None
            if settings.sampling.policy == Lemma1Policy.ERROR:
                raise decision.why
            if before.violations == 0 or before.T_max > settings.sampling.T:
                self.warn(str(decision.why))
        self.now = decision.command


def _violation(time: float, T: float, T_max: float, s: Vector, constants: PlatoonParameters) -> ModelError:
    """Why T is not certified: the smallest spacing, or else speeds and commands."""
    i = int(np.argmin(s)) if s.size else 0
    if s.size and (s[i] - constants.L) / constants.v_max <= T_max:
        enough = constants.L + constants.v_max * T
        return ModelError("lemma1_controller_gap", T, T_max, time, i + 2, s[i], enough, T_max)
    return ModelError("lemma1_controller", T, T_max, time, T_max)


def _require_desired(desired: float, v_max: float) -> None:
    """Raise ModelError where a desired speed lies outside [0, v_max], rounding aside."""
    if not np.isfinite(desired):
        raise ModelError("v_desired_finite", desired, v_max)
    if desired < -ROUNDING * v_max:
        raise ModelError("v_desired_backwards", desired)
    if desired > v_max + ROUNDING * v_max:
        raise ModelError("v_desired", desired, v_max)


def _bad_gap(vehicle: int, gap: float, L: float) -> ModelError:
    """What to say of a measured spacing that is not in order."""
    if not np.isfinite(gap):
        return ModelError("finite", f"s[{vehicle}]", gap, "m")
    if gap <= 0:
        return ModelError("measured_order", vehicle, gap, vehicle, vehicle - 1)
    return ModelError("measured_gap", vehicle, gap, L)


def _bad_speed(vehicle: int, speed: float, v_max: float) -> ModelError:
    """What to say of a measured speed that is not in order."""
    if not np.isfinite(speed):
        return ModelError("finite", f"v[{vehicle}]", speed, "m/s")
    if speed < 0:
        return ModelError("measured_backwards", vehicle, speed)
    return ModelError("measured_speed", vehicle, speed, v_max)
