"""Lemma 1: which sampling period keeps the vehicles apart and below the speed limit."""

from __future__ import annotations

import numpy as np

from ..errors import ModelError
from ..namespaces import Array, array_namespace, smallest
from ..parameters import PlatoonParameters


def period_bounds(s: Array, v: Array, a: Array, constants: PlatoonParameters) -> tuple[Array, Array]:
    """The bounds on the sampling period that each spacing and each speed sets at a sampling instant (paper, Lemma 1).

    Parameters
    ----------
    s : (n-1, ...) array, spacings [m]
    v : (n, ...) array, speeds [m/s]
    a : (n, ...) array, accelerations about to be held [m/s2]

    Returns
    -------
    of_spacings : (n-1, ...) array, (s_i - L) / v_max [s]
    of_speeds : (n, ...) array, (v_max - v_i) / a_i where a_i > 0, v_i / -a_i where a_i < 0, else infinite [s]
    """
    xp = array_namespace(a)
    room = xp.where(a > 0.0, constants.v_max - v, v)
    size = xp.abs(a)
    moving = size > 0.0
    of_speeds = xp.where(moving, room / xp.where(moving, size, 1.0), np.inf)
    return (s - constants.L) / constants.v_max, of_speeds


def largest_period(s: Array, v: Array, a: Array, constants: PlatoonParameters, automated: Array | None = None) -> Array:
    """T_max: a sampling period T is certified at this instant iff T < T_max (paper, Lemma 1, over all vehicles).

    Parameters
    ----------
    s, v, a : as for `period_bounds`
    automated : (n, ...) array, 0 for a vehicle that drives itself, whose own speed sets no bound (ours); None for none

    Returns
    -------
    (...) array, T_max [s]
    """
    of_spacings, of_speeds = period_bounds(s, v, a, constants)
    return smallest(array_namespace(of_speeds).concat([of_spacings, of_commanded(of_speeds, automated)]))


def of_commanded(of_speeds: Array, automated: Array | None) -> Array:
    """The bounds that speeds set, infinite for vehicles that drive themselves (ours).

    Parameters
    ----------
    of_speeds : (n, ...) array [s]
    automated : as for `largest_period`

    Returns
    -------
    array like of_speeds [s]
    """
    return of_speeds if automated is None else array_namespace(of_speeds).where(automated > 0.5, of_speeds, np.inf)


def violation(
    t: float,
    T: float,
    s: Array,
    v: Array,
    a: Array,
    constants: PlatoonParameters,
    ahead: Array | None = None,
    automated: Array | None = None,
) -> ModelError:
    """The error that says which vehicle keeps T from being certified, with its values, bound and remedy (ours).

    Parameters
    ----------
    t : time of the sampling instant [s]
    T : sampling period that is too long [s]
    s, v, a : (n-1,), (n,) and (n,) NumPy arrays as for `period_bounds`
    ahead : (n-1,) lengths of the vehicles ahead [m]; None for L
    automated : as for `largest_period`

    Returns
    -------
    ModelError, to be raised or logged
    """
    room = s if ahead is None else s - (ahead - constants.L)
    of_spacings, of_speeds = period_bounds(room, v, a, constants)
    i, j = narrowest(of_spacings, of_commanded(of_speeds, automated))
    if i < 0:
        return speed_violation("lemma1", t, T, j, v, a, constants, of_speeds[j])
    least, bound = constants.L if ahead is None else ahead[i], of_spacings[i]
    key = "lemma1_spacing" if least == constants.L else "lemma1_length"
    return ModelError(key, T, bound, t, i + 2, i + 2, s[i], least, constants.v_max, bound)


def narrowest(of_spacings: Array, of_speeds: Array) -> tuple[int, int]:
    """Which spacing sets the least bound, -1 if a speed does; and which speed sets the least of the speeds (ours).

    Parameters
    ----------
    of_spacings, of_speeds : (n-1,) and (n,) NumPy arrays [s]
    """
    j = int(np.argmin(of_speeds))
    by_spacing = of_spacings.size and of_spacings.min() <= of_speeds[j]  # a lone vehicle has no spacing
    return (int(np.argmin(of_spacings)) if by_spacing else -1), j


def speed_violation(
    certificate: str, t: float, T: float, j: int, v: Array, a: Array, constants: PlatoonParameters, bound: float
) -> ModelError:
    """The error for a speed that would reach v_max or 0 (ours).

    Parameters
    ----------
    certificate : first part of the sentences' keys
    t, T, v, a : as for `violation`
    j : index of the vehicle
    bound : that its speed sets [s]
    """
    key, limit = ("fast", constants.v_max) if a[j] > 0 else ("slow", 0.0)
    return ModelError(f"{certificate}_{key}", T, bound, t, j + 1, j + 1, v[j], j + 1, a[j], limit, bound)
