"""The exact period: how long the held commands keep the vehicles apart and below the speed limit (ours)."""

from __future__ import annotations

import numpy as np

from ..errors import ModelError
from ..namespaces import Array, array_namespace, smallest
from ..parameters import PlatoonParameters
from .hold import relative
from .lemma1 import narrowest, of_commanded, period_bounds, speed_violation


def first_contact(c: Array, b: Array, a: Array) -> Array:
    """The first time at which c + b t + a t^2 / 2 falls to 0 (ours).

    Written so that no nearly equal numbers are subtracted: for b < 0 the smaller root is 2c / (sqrt(D) - b), and for
    b >= 0, a < 0 the only positive one is (b + sqrt(D)) / -a, with D = b^2 - 2 a c.

    Parameters
    ----------
    c : array, distance left [m], above 0
    b : array like c, its rate of change [m/s]
    a : array like c, its second derivative [m/s2], constant

    Returns
    -------
    array like c [s]; infinite where the distance never falls to 0
    """
    xp = array_namespace(c)
    D = b * b - 2.0 * a * c
    root = xp.sqrt(xp.maximum(D, 0.0))
    closing = b < 0.0
    braking = a < 0.0
    soon = 2.0 * c / xp.where(closing, root - b, 1.0)
    late = (b + root) / xp.where(braking, -a, 1.0)
    found = xp.where(closing, soon, xp.where(braking, late, np.inf))
    return xp.where(D < 0.0, np.inf, found)


def exact_bounds(s: Array, v: Array, a: Array, constants: PlatoonParameters) -> tuple[Array, Array]:
    """When, under the accelerations held, each spacing first falls to L and each speed leaves its bounds (ours).

    Parameters
    ----------
    s, v, a, constants : as for `exact_period`

    Returns
    -------
    of_spacings, of_speeds : (n-1, ...) and (n, ...) arrays [s]; the latter are Lemma 1's own
    """
    _, of_speeds = period_bounds(s, v, a, constants)
    return first_contact(s - constants.L, relative(v), relative(a)), of_speeds


def exact_period(s: Array, v: Array, a: Array, constants: PlatoonParameters, automated: Array | None = None) -> Array:
    """T_exact: when, under the accelerations held, a spacing first falls to L or a speed leaves its bounds.

    It takes all commands; Lemma 1 bounds each vehicle for any commands of its neighbours (ours).  The
    bounds of the speeds are Lemma 1's own.

    Parameters
    ----------
    s : (n-1, ...) array, spacings [m], above L
    v : (n, ...) array, speeds [m/s], in [0, v_max]
    a : (n, ...) array, accelerations about to be held [m/s2]
    constants : of the model
    automated : (n, ...) array, 0 for a vehicle that drives itself, whose own speed sets no bound; None for none

    Returns
    -------
    (...) array [s]; a sampling period T is certified at this instant iff T < T_exact
    """
    of_spacings, of_speeds = exact_bounds(s, v, a, constants)
    return smallest(array_namespace(of_speeds).concat([of_spacings, of_commanded(of_speeds, automated)]))


def exact_violation(
    t: float,
    T: float,
    s: Array,
    v: Array,
    a: Array,
    constants: PlatoonParameters,
    ahead: Array | None = None,
    automated: Array | None = None,
) -> ModelError:
    """The error that says which vehicle sets the exact period, with its values, bound and remedy (ours).

    Parameters
    ----------
    t, T, s, v, a, constants, ahead, automated : as for `lemma1.violation`

    Returns
    -------
    ModelError, to be raised or logged
    """
    room = s if ahead is None else s - (ahead - constants.L)
    of_spacings, of_speeds = exact_bounds(room, v, a, constants)
    i, j = narrowest(of_spacings, of_commanded(of_speeds, automated))
    if i < 0:
        return speed_violation("exact", t, T, j, v, a, constants, of_speeds[j])
    least, bound = constants.L if ahead is None else ahead[i], of_spacings[i]
    return ModelError("exact_spacing", T, bound, t, i + 2, i + 2, s[i], least, bound)
