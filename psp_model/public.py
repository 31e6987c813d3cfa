"""The public functions of the model: lists, tuples and arrays in, NumPy arrays out.

Each calls the generic function of the same name, to which arrays of JAX and symbols of CasADi are passed unchanged.
"""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike

from .errors import ModelError
from .law import cooperation as of_cooperation
from .law import feedback as of_feedback
from .law.cooperation import ALL_AUTOMATED, PAPERS_LAW, Cooperation, Traffic
from .law.potential import Potential
from .namespaces import Array
from .parameters import PlatoonParameters
from .sampling import exact, lemma1, uncertain
from .sampling.uncertain import Errors
from .state import shortened
from .vehicles import braking
from .vehicles.braking import Braking

Struct = TypeVar("Struct")

PAPER = PlatoonParameters()


def numbers(values: ArrayLike) -> Array:
    """Values as an array; arrays and symbols of any library as they are (ours).

    Parameters
    ----------
    values : a number, a list, a tuple, an array or a symbol

    Raises
    ------
    ModelError : where a list or tuple does not hold numbers only
    """
    if hasattr(values, "shape"):
        return cast(Array, values)
    try:
        found = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise ModelError("numbers", shortened(repr(values))) from None
    if values is None:  # which NumPy takes for NaN
        raise ModelError("numbers", values)
    return found


def filled(struct: Struct) -> Struct:
    """A struct whose lists and tuples are arrays (ours).

    Parameters
    ----------
    struct : dataclass or named tuple
    """
    values = _values(struct)
    changed = {name: numbers(value) for name, value in values.items() if isinstance(value, list | tuple)}
    return cast(Struct, cast(Any, type(struct))(**values | changed)) if changed else struct


def _values(struct: object) -> dict[str, Any]:
    if is_dataclass(struct):
        return {field.name: getattr(struct, field.name) for field in fields(struct)}
    return cast(Any, struct)._asdict()


def _platoon(s: ArrayLike, *of_vehicles: ArrayLike) -> tuple[Array, ...]:
    """Spacings and quantities of vehicles as arrays that fit one another."""
    spacings, others = numbers(s), [numbers(one) for one in of_vehicles]
    for one in others:
        if not spacings.shape or not one.shape or spacings.shape[0] != one.shape[0] - 1:
            raise ModelError("shape", *((part.shape or (1,))[0] for part in (spacings, one)))
    return spacings, *others


def potential(s: ArrayLike, shape: Potential, constants: PlatoonParameters = PAPER) -> Array:
    """V(s) (paper, eq. of V_new).

    Parameters
    ----------
    s : array of any shape, spacings [m], all above L
    shape : potential
    constants : of the model; the paper's by default

    Returns
    -------
    array like s [m2/s2]
    """
    return shape.value(numbers(s), constants)


def potential_slope(s: ArrayLike, shape: Potential, constants: PlatoonParameters = PAPER) -> Array:
    """V'(s) (paper, used in eq. 2); below 0 it pushes two vehicles apart.

    Parameters
    ----------
    s, shape, constants : as for `potential`

    Returns
    -------
    array like s [m/s2]
    """
    return shape.slope(numbers(s), constants)


def feedback(s: ArrayLike, v: ArrayLike, shape: Potential, constants: PlatoonParameters = PAPER) -> Array:
    """F_i = -k_i (v_i - v*) + u_i, the accelerations that the paper's law commands (paper, eq. 2).

    Parameters
    ----------
    s, v : (n-1, ...) spacings [m], all above L, and (n, ...) speeds [m/s], in [0, v_max]
    shape : potential
    constants : of the model; the paper's by default

    Returns
    -------
    (n, ...) array [m/s2]
    """
    spacings, speeds = _platoon(s, v)
    return of_feedback.feedback(spacings, speeds, shape, constants)


def cooperative_command(
    s: ArrayLike,
    v: ArrayLike,
    shape: Potential,
    constants: PlatoonParameters = PAPER,
    cooperation: Cooperation = PAPERS_LAW,
    traffic: Traffic = ALL_AUTOMATED,
) -> Array:
    """The accelerations that the extended law commands (ours; docs/theory.md).

    Parameters
    ----------
    s, v : (n-1, ...) spacings [m], all clearances above 0, and (n, ...) speeds [m/s], in [0, v_max]
    shape : potential
    constants : of the model; the paper's by default
    cooperation : parameters of the law; the paper's law by default
    traffic : what is known of the road besides; all vehicles automated by default

    Returns
    -------
    (n, ...) array [m/s2]; those of vehicles that drive themselves mean nothing
    """
    s, v = _platoon(s, v)
    return of_cooperation.cooperative_command(s, v, shape, constants, filled(cooperation), filled(traffic))


def largest_period(s: ArrayLike, v: ArrayLike, a: ArrayLike, constants: PlatoonParameters = PAPER) -> Array:
    """T_max: a sampling period T is certified at this instant iff T < T_max (paper, Lemma 1, over all vehicles).

    Parameters
    ----------
    s, v : (n-1, ...) spacings [m] and (n, ...) speeds [m/s]
    a : (n, ...) accelerations about to be held [m/s2]
    constants : of the model; the paper's by default

    Returns
    -------
    (...) array [s], one number for one platoon
    """
    spacings, speeds, accelerations = _platoon(s, v, a)
    return lemma1.largest_period(spacings, speeds, accelerations, constants)


def exact_period(s: ArrayLike, v: ArrayLike, a: ArrayLike, constants: PlatoonParameters = PAPER) -> Array:
    """T_exact: the first time at which, under the held accelerations, a spacing falls to L or a speed leaves
    [0, v_max].

    Parameters
    ----------
    s, v, a, constants : as for `largest_period` (ours)

    Returns
    -------
    (...) array [s]; a sampling period T is safe at this instant iff T < T_exact
    """
    spacings, speeds, accelerations = _platoon(s, v, a)
    return exact.exact_period(spacings, speeds, accelerations, constants)


def uncertain_period(
    s: ArrayLike,
    v: ArrayLike,
    a: ArrayLike,
    errors: Errors,
    constants: PlatoonParameters = PAPER,
    a_before: ArrayLike | None = None,
) -> Array:
    """T_max for spacings and speeds that are known within bounds (ours: Lemma 1 with the worst case inside them).

    Parameters
    ----------
    s, v, a : as for `largest_period`
    errors : bounds on the errors of s and v
    constants : of the model; the paper's by default
    a_before : (n, ...) accelerations of actuators that have a lag; None for a [m/s2]

    Returns
    -------
    (...) array [s], not negative
    """
    before = () if a_before is None else (a_before,)
    s, v, a, *rest = _platoon(s, v, a, *before)
    return uncertain.uncertain_period(s, v, a, filled(errors), constants, *rest)


def brake_margin(clearance: ArrayLike, vehicles: Braking, automated: ArrayLike | None = None) -> Array:
    """The largest b so that all vehicles not automated may brake with b to standstill and those behind do not collide.

    Parameters
    ----------
    clearance : (n-1, ...) clearances, bumper to bumper [m]
    vehicles : all of them
    automated : (n, ...) array, 0 for a vehicle that drives itself, 1 else; None where all are automated

    Returns
    -------
    (...) array [m/s2] (ours; docs/theory.md)
    """
    vehicles = filled(vehicles)
    given = () if automated is None else (automated,)
    clearance, _, *rest = _platoon(clearance, vehicles.v, *given)
    return braking.brake_margin(clearance, vehicles, *rest)
