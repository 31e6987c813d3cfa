"""The checks of values from outside: a value outside the model's domain raises an error of one sentence (ours).

The model's structs hold numbers, arrays or symbols and check nothing; code that takes numbers from outside
calls `validate` on the structs it makes of them.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import singledispatch
from math import isfinite
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from .errors import ModelError
from .law.cooperation import Cooperation
from .law.following import NEAREST, PREDECESSOR
from .law.potential import PotentialParameters
from .parameters import HILL_WIDTH, Actuation, ObjectiveWeights, PlatoonParameters
from .quantities import quantity_of
from .sampling.policy import Certificate, Lemma1Policy, Sampling
from .sampling.uncertain import Errors
from .state import PlatoonState

Struct = TypeVar("Struct")


def validate(struct: Struct) -> Struct:
    """Check a struct of the model.

    Parameters
    ----------
    struct : PlatoonParameters, ObjectiveWeights, PotentialParameters, Sampling, Cooperation, Actuation, Errors, or a
        PlatoonState with its constants

    Returns
    -------
    the same

    Raises
    ------
    ModelError : where a value is not finite or not in the model's domain, naming it
    """
    _check(struct)
    return struct


def validate_law(cooperation: Cooperation, constants: PlatoonParameters) -> None:
    """Check the parameters of the extended law for given constants.

    Parameters
    ----------
    cooperation, constants : of the law

    Raises
    ------
    ModelError : where a value is not finite or not in the model's domain, naming it
    """
    validate(cooperation)
    reach = cooperation.kappa_reach
    if cooperation.kappa > 0:
        _require(bool(reach > constants.L), "reach", "kappa_reach", reach, "L", constants.L)


def validate_start(state: PlatoonState, cooperation: Cooperation) -> PlatoonState:
    """Check an initial state of vehicles with lengths: no two may touch (ours).

    Parameters
    ----------
    state : with its constants
    cooperation : with the lengths

    Returns
    -------
    the state

    Raises
    ------
    ModelError : where a value is not finite or not in the state space, naming it
    """
    length = cooperation.length
    _check_start(state, None if length is None else np.broadcast_to(np.asarray(length, dtype=float), state.v.shape))
    return state


@singledispatch
def _check(struct: object) -> None:
    """Other types, user-defined potentials for example, are not checked."""


def _require(holds: bool | np.bool_, key: str, *values: object) -> None:
    if not holds:
        raise ModelError(key, *values)


def _require_finite(struct: object, names: Iterable[str]) -> None:
    for name in names:
        value, quantity = getattr(struct, name), quantity_of(name)
        _require(isfinite(value), "finite", quantity.name, value, quantity.unit)


@_check.register
def _(constants: PlatoonParameters) -> None:
    _require_finite(constants, ("L", "lam", "v_star", "v_max", "epsilon", "mu", "z"))
    _require(constants.L > 0, "L", constants.L)
    _require(constants.lam > constants.L + HILL_WIDTH, "lambda", constants.lam, constants.L + HILL_WIDTH)
    _require(constants.v_max > 0, "v_max", constants.v_max)
    _require(constants.v_star > 0, "v_star_backwards", constants.v_star, constants.v_max)
    _require(constants.v_star < constants.v_max, "v_star", constants.v_star, constants.v_max)
    for name in ("epsilon", "mu", "z"):
        _require(getattr(constants, name) > 0, name, getattr(constants, name))


@_check.register
def _(weights: ObjectiveWeights) -> None:
    _require_finite(weights, ("w1", "w2", "a_ref", "s_ref"))
    for name in ("w1", "w2"):
        _require(getattr(weights, name) >= 0, name, getattr(weights, name))
    for name in ("a_ref", "s_ref"):
        _require(getattr(weights, name) > 0, name, getattr(weights, name))


@_check.register
def _(shape: PotentialParameters) -> None:
    _require_finite(shape, ("alpha", "r", "p"))


@_check.register
def _(cooperation: Cooperation) -> None:
    scalars = ("kappa", "kappa_reach", "time_gap", "feedforward", "closing_speed", "closing_spacing", "closing_reach")
    _require_finite(cooperation, scalars)
    for name in ("kappa", "time_gap", "closing_speed"):
        value, unit = getattr(cooperation, name), quantity_of(name).unit
        _require(value >= 0, "not_negative", name, value, unit, unit)
    _require(bool(0 <= cooperation.feedforward <= 1), "feedforward", cooperation.feedforward)
    _require(cooperation.following in (NEAREST, PREDECESSOR), "following", cooperation.following)
    spacing, reach = cooperation.closing_spacing, cooperation.closing_reach
    _require(bool(reach > spacing), "reach", "closing_reach", reach, "closing_spacing", spacing)
    for i, length in enumerate(np.ravel([] if cooperation.length is None else cooperation.length).tolist(), start=1):
        _require(isfinite(length), "finite", f"length[{i}]", length, "m")
        _require(length > 0, "length", i, length, i)


@_check.register
def _(actuation: Actuation) -> None:
    delay = actuation.actuation_delay
    _require(isfinite(delay), "finite", "actuation_delay", delay, "s")
    _require(delay >= 0, "not_negative", "actuation_delay", delay, "s", "s")
    for i, lag in enumerate(np.ravel(actuation.actuator_lag).tolist(), start=1):
        _require(isfinite(lag), "finite", f"actuator_lag[{i}]", lag, "s")
        _require(lag >= 0, "not_negative", f"actuator_lag[{i}]", lag, "s", "s")
    limits = np.broadcast_arrays(np.ravel(actuation.a_min), np.ravel(actuation.a_max))
    for i, (least, most) in enumerate(zip(*(one.tolist() for one in limits), strict=True), start=1):
        _require(least < 0 < most, "command_limits", i, least, i, most)


@_check.register
def _(errors: Errors) -> None:
    for name, unit in (("error_s", "m"), ("error_v", "m/s")):
        value = getattr(errors, name)
        _require(isfinite(value), "finite", name, value, unit)
        _require(value >= 0, "not_negative", name, value, unit, unit)


@_check.register
def _(sampling: Sampling) -> None:
    _require(isfinite(sampling.T), "finite", "T", sampling.T, "s")
    _require(sampling.T > 0, "T", sampling.T)
    policies = list(Lemma1Policy)
    _require(sampling.policy in policies, "choice", "lemma1_policy", sampling.policy, min(policies), max(policies))
    _require(sampling.max_short_periods >= 1, "count", "max_short_periods", sampling.max_short_periods)
    known = list(Certificate)
    _require(sampling.certificate in known, "choice", "certificate", sampling.certificate, min(known), max(known))


@_check.register
def _(state: PlatoonState) -> None:
    _check_start(state, None)


def _check_start(state: PlatoonState, lengths: NDArray[np.float64] | None) -> None:
    s, v, constants = state.s, state.v, validate(state.constants)
    _require(s.ndim == 1 and v.ndim == 1 and s.size == v.size - 1, "shape", s.size, v.size)
    _require(isfinite(state.x_leader), "finite", "x_start", state.x_leader, "m")
    for i, spacing in enumerate(s.tolist(), start=2):
        _require(isfinite(spacing), "finite", f"s_start[{i}]", spacing, "m")
        _require(spacing > 0, "spacing_order", i, spacing, i, i - 1)
        if lengths is None or lengths[i - 2] == constants.L:
            _require(spacing > constants.L, "spacing", i, spacing, constants.L)
        else:
            _require(bool(spacing > lengths[i - 2]), "spacing_length", i, spacing, i - 1, lengths[i - 2])
    for i, speed in enumerate(v.tolist(), start=1):
        _require(isfinite(speed), "finite", f"v_start[{i}]", speed, "m/s")
        _require(speed >= 0, "speed_backwards", i, speed, constants.v_max, i)
        _require(speed <= constants.v_max, "speed", i, speed, constants.v_max, i)
