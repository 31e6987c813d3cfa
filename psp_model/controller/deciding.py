"""The decision at a sampling instant: the extended law at the predicted state, its bounds, and what certifies T."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..law.cooperation import Cooperation, contact_spacing, is_off, model_spacing
from ..parameters import Actuation
from ..sampling.exact import first_contact
from ..sampling.hold import relative
from ..sampling.lemma1 import period_bounds
from ..sampling.policy import Certificate
from ..sampling.uncertain import uncertain_exact_period, uncertain_period
from ..selection.selectors import Selector, Trained, lies_in_domain
from ..state import seal
from ..vehicles.actuation import limited
from ..vehicles.membership import rearranged
from ..vehicles.prediction import Predicted, issue, nothing_issued
from ..vehicles.road_law import Remembered, RoadLaw, Seen
from .decision import Basis, Command, certified_period
from .measurement import Measurement, drives_itself, in_order
from .members import members_of
from .settings import ControllerSettings

Vector = NDArray[np.float64]


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
        seen = in_order(settings, measured)
    except ModelError as error:
        return Decision(_fail_safe(settings, before, measured), Verdict.BAD_MEASUREMENT, error)
    now, warning = _chosen(settings, selector, trained, before, seen, measured.resolve)
    return _regular(settings, now, time, seen, measured.resolve, warning)


def _chosen(
    settings: ControllerSettings,
    selector: Selector,
    trained: Mapping[int, Trained],
    before: Command,
    seen: Seen,
    resolve: float,
) -> tuple[Command, str | None]:
    """The last decision with the potential to use from now on, and what to warn of."""
    v, constants, asked = seen.v, settings.constants, resolve > 0.5 >= before.resolve
    if v.size == before.n_active and not asked:
        return before, None
    s = contact_spacing(seen.s, settings.of(v.size)[0], constants)
    shape, _, warning = selector.select(s, v, constants)
    in_domain = lies_in_domain(trained, s, v, constants)
    return replace(before, shape=shape, in_domain=in_domain, choices=before.choices + 1), warning


def _regular(
    settings: ControllerSettings, before: Command, time: float, seen: Seen, resolve: float, warning: str | None
) -> Decision:
    """The bounded law for vehicles that are in order; `before` has the potential to use."""
    T, n, constants = settings.sampling.T, seen.v.size, settings.constants
    cooperation, actuation = settings.of(n)
    memory = _members(settings, before, seen.s, seen.v)
    law = RoadLaw(before.shape, constants, cooperation, actuation, T, settings.oldest)
    watched, predicted, wanted = law.wanted(memory, seen)
    if seen.automated is not None:
        wanted = np.where(seen.automated > 0.5, wanted, 0.0)  # where vehicles all but touch it may be infinite
    a, saturated = np.zeros(settings.capacity), np.zeros(settings.capacity, dtype=bool)
    a[:n] = limited(wanted, actuation)
    saturated[:n] = a[:n] != wanted
    seal(a, saturated)
    T_max, T_exact = _periods(settings, (cooperation, actuation), seen, predicted, a[:n])
    certified = certified_period(settings, T_max, T_exact) > T
    if settings.predicts:
        memory = Remembered(issue(memory.issued, a[:n], T, actuation), watched)
    now = replace(
        before,
        a=a,
        saturated=saturated,
        in_order=True,
        T_max=T_max,
        T_exact=T_exact,
        violations=before.violations + (not certified),
        n_active=n,
        resolve=resolve,
        basis=_basis(seen, predicted),
        memory=memory if settings.predicts else None if watched is None else Remembered(memory.issued, watched),
    )
    if certified:
        return Decision(now, Verdict.IN_ORDER, None, warning)
    return Decision(now, Verdict.NOT_CERTIFIED, _violation(settings, time, now), warning)


def _members(settings: ControllerSettings, before: Command, s: Vector, v: Vector) -> Remembered:
    """The memory for the vehicles there are now."""
    memory = before.memory
    if memory is None:
        return Remembered(nothing_issued(np.zeros(v.size), settings.oldest))  # v may be no numbers
    rows = memory.issued.actuators.a.shape[0]
    return memory if rows == v.size else rearranged(memory, members_of(before.basis, rows, s, v), v)


def _periods(
    settings: ControllerSettings, told: tuple[Cooperation, Actuation], seen: Seen, predicted: Predicted, a: Vector
) -> tuple[float, float]:
    """T_max in the model spacings and T_exact for contact, at the predicted state with its errors [s]."""
    (cooperation, actuation), constants, foreign, automated = told, settings.constants, None, seen.automated
    errors = settings.errors.carried(seen.age + actuation.actuation_delay)
    before = None if is_off(actuation.actuator_lag) else predicted.a
    if automated is not None:
        foreign = predicted.a * (1.0 - automated)
        before = None if before is None else before * automated
    s, v = predicted.s, np.minimum(predicted.v, constants.v_max)  # which is where the law is evaluated
    spacing, contact = model_spacing(s, v, cooperation, constants), contact_spacing(s, cooperation, constants)
    if before is None and foreign is None and errors == (0.0, 0.0):  # the same, in half the time
        of_spacings, of_speeds = period_bounds(spacing, v, a, constants)
        of_contact = first_contact(contact - constants.L, relative(v), relative(a))
        slowest = of_speeds.min()
        return float(of_spacings.min(initial=slowest)), float(of_contact.min(initial=slowest))
    T_max = uncertain_period(spacing, v, a, errors, constants, before)
    return float(T_max), float(uncertain_exact_period(contact, v, a, errors, constants, before, foreign))


def _basis(seen: Seen, predicted: Predicted) -> Basis:
    """What the decision is based on, to be shown."""
    automated = np.ones(seen.v.size) if seen.automated is None else seen.automated
    basis = Basis(seen.s, seen.v, seen.age, automated, *predicted)
    seal(*basis)
    return basis


def _fail_safe(settings: ControllerSettings, before: Command, measured: Measurement) -> Command:
    """The fail-safe command: every vehicle slows down by a_safe, but not below standstill where the speed is known.

    It too is on its way from here on.  Speeds of others are watched anew from the next valid inputs on.
    """
    T, n = settings.sampling.T, measured.n_active
    known = np.where(np.isfinite(measured.v), np.maximum(measured.v, 0.0), np.inf)
    a = np.maximum(settings.a_safe, -known / T)
    active = int(n) if 1 <= n <= settings.capacity and n == int(n) else settings.capacity
    a[active:], saturated = 0.0, np.zeros(settings.capacity, dtype=bool)
    a[drives_itself(measured)] = 0.0
    seal(a, saturated)
    memory = None
    if settings.predicts:
        issued = _members(settings, replace(before, basis=None), measured.s[: active - 1], measured.v[:active]).issued
        memory = Remembered(issue(issued, a[:active], T, settings.of(active)[1]))
    return replace(
        before,
        a=a,
        saturated=saturated,
        in_order=False,
        T_max=0.0,
        T_exact=0.0,
        faults=before.faults + 1,
        memory=memory,
    )


def _violation(settings: ControllerSettings, time: float, now: Command) -> ModelError:
    """Why T is not certified: the smallest spacing, or else speeds and commands."""
    T, T_max, constants, basis = settings.sampling.T, now.T_max, settings.constants, now.basis
    assert basis is not None
    if settings.sampling.certificate == Certificate.EXACT:
        return ModelError("exact_controller", T, now.T_exact, time, now.T_exact)
    n, seen = basis.v.size, "predicted" if settings.predicts else "measured"
    s = model_spacing(basis.s_predicted, basis.v_predicted, settings.of(n)[0], constants)
    error_s = settings.errors.carried(basis.age + settings.actuation.actuation_delay).error_s
    i = int(np.argmin(s)) if s.size else 0
    if s.size and max(s[i] - error_s - constants.L, 0.0) / constants.v_max <= T_max:
        shown = basis.s_predicted[i]
        enough = constants.L + constants.v_max * T + (shown - s[i] + error_s)
        return ModelError("lemma1_controller_spacing", T, T_max, time, seen, i + 2, shown, enough, T_max)
    return ModelError("lemma1_controller", T, T_max, time, seen, T_max)
