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
    of_gaps : (n-1, ...) array, (s_i - L) / v_max [s]
    of_speeds : (n, ...) array, (v_max - v_i) / a_i where a_i > 0, v_i / -a_i where a_i < 0, else infinite [s]
    """
    xp = array_namespace(a)
    room = xp.where(a > 0.0, constants.v_max - v, v)
    size = xp.abs(a)
    moving = size > 0.0
    of_speeds = xp.where(moving, room / xp.where(moving, size, 1.0), np.inf)
    return (s - constants.L) / constants.v_max, of_speeds


def largest_period(s: Array, v: Array, a: Array, constants: PlatoonParameters) -> Array:
    """T_max: a sampling period T is certified at this instant iff T < T_max (paper, Lemma 1, over all vehicles).

    Parameters
    ----------
    s, v, a : as for `period_bounds`

    Returns
    -------
    (...) array, T_max [s]
    """
    of_gaps, of_speeds = period_bounds(s, v, a, constants)
    return smallest(array_namespace(of_speeds).concat([of_gaps, of_speeds]))


def violation(t: float, T: float, s: Array, v: Array, a: Array, constants: PlatoonParameters) -> ModelError:
    """The error that says which vehicle keeps T from being certified, with its values, bound and remedy (ours).

    Parameters
    ----------
    t : time of the sampling instant [s]
    T : sampling period that is too long [s]
    s, v, a : (n-1,), (n,) and (n,) NumPy arrays as for `period_bounds`

    Returns
    -------
    ModelError, to be raised or logged
    """
    of_gaps, of_speeds = period_bounds(s, v, a, constants)
    j = int(np.argmin(of_speeds))
    if of_gaps.size and of_gaps.min() <= of_speeds[j]:  # a lone vehicle has no spacing
        i = int(np.argmin(of_gaps))
        bound = of_gaps[i]
        return ModelError("lemma1_gap", T, bound, t, i + 2, i + 2, s[i], constants.L, constants.v_max, bound)
    key, limit = ("lemma1_fast", constants.v_max) if a[j] > 0 else ("lemma1_slow", 0.0)
    bound = of_speeds[j]
    return ModelError(key, T, bound, t, j + 1, j + 1, v[j], j + 1, a[j], limit, bound)
