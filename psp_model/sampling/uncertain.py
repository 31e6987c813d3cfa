"""Lemma 1 and the exact period for what is measured late and with bounded errors: the worst case (ours)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..namespaces import Array, Number, array_namespace, smallest
from ..parameters import PlatoonParameters
from .exact import first_contact
from .hold import relative


class Errors(NamedTuple):
    """Bounds on what is wrong with measurements or predictions.

    Attributes
    ----------
    error_s, error_v : of spacings [m] and of speeds [m/s], numbers or arrays that broadcast with them
    """

    error_s: Number = 0.0
    error_v: Number = 0.0

    def carried(self, horizon: Number) -> Errors:
        """The bounds a time later, where all accelerations are known: spacings also drift with the speeds' errors.

        Parameters
        ----------
        horizon : time [s]
        """
        return Errors(self.error_s + 2.0 * horizon * self.error_v, self.error_v)


def uncertain_period(
    s: Array, v: Array, a: Array, errors: Errors, constants: PlatoonParameters, a_before: Array | None = None
) -> Array:
    """T_max for spacings and speeds that are known within bounds (ours: Lemma 1 with the worst case inside them).

    Parameters
    ----------
    s, v : (n-1, ...) spacings [m] and (n, ...) speeds [m/s], predicted for the time at which the command takes effect
    a : (n, ...) array, accelerations commanded [m/s2]
    errors : of s and v, carried through the prediction
    a_before : (n, ...) array, accelerations of the actuators at that time, where they have a lag; None for a [m/s2]

    Returns
    -------
    (...) array [s], not negative; a sampling period T is certified iff T < T_max.  Without errors and without a lag it
    is that of Lemma 1, bit for bit, in Omega
    """
    xp = array_namespace(v)
    before = a if a_before is None else a_before
    bounds = speed_bounds(v, xp.maximum(a, before), xp.minimum(a, before), errors, constants)
    return smallest(xp.concat([spacing_bound(s, errors, constants), *bounds]))


def uncertain_exact_period(
    s: Array,
    v: Array,
    a: Array,
    errors: Errors,
    constants: PlatoonParameters,
    a_before: Array | None = None,
    a_foreign: Array | None = None,
) -> Array:
    """T_exact for spacings and speeds that are known within bounds (ours: the exact period with the worst case).

    With a lag each acceleration lies between that of the actuator and the command; the worst of both counts.

    Parameters
    ----------
    s, v, a, errors, a_before : as for `uncertain_period`
    a_foreign : (n, ...) array, what vehicles that drive themselves are taken to hold; 0 for the others, for whose `a`
        theirs is 0 [m/s2]; None where all are automated

    Returns
    -------
    (...) array [s], not negative; without errors and without a lag that of `exact_period`, bit for bit, in Omega
    """
    xp = array_namespace(v)
    before = a if a_before is None else a_before
    most, least = xp.maximum(a, before), xp.minimum(a, before)
    bounds = speed_bounds(v, most, least, errors, constants)
    if a_foreign is not None:
        most, least = most + a_foreign, least + a_foreign
    return smallest(xp.concat([contact_bound(s, relative(v), least[:-1] - most[1:], errors, constants), *bounds]))


def spacing_bound(s: Array, errors: Errors, constants: PlatoonParameters) -> Array:
    """How long a spacing lasts whatever the vehicles do, at its smallest (ours).

    Parameters
    ----------
    s : array, spacings [m]
    errors, constants : as for `uncertain_period`

    Returns
    -------
    array like s [s]
    """
    return array_namespace(s).maximum(s - errors.error_s - constants.L, 0.0) / constants.v_max


def contact_bound(s: Array, dv: Array, da: Array, errors: Errors, constants: PlatoonParameters) -> Array:
    """How long a spacing lasts under the worst accelerations, at its smallest and closing fastest (ours).

    Parameters
    ----------
    s, dv, da : arrays, spacings [m], their rates of change [m/s], and the least that these change by [m/s2]
    errors, constants : as for `uncertain_exact_period`

    Returns
    -------
    array like s [s]
    """
    xp = array_namespace(s)
    room = xp.maximum(s - errors.error_s - constants.L, 0.0)
    return xp.where(room > 0.0, first_contact(room, dv - 2.0 * errors.error_v, da), 0.0)


def speed_bounds(
    v: Array, most: Array, least: Array, errors: Errors, constants: PlatoonParameters
) -> tuple[Array, Array]:
    """How long speeds stay at most v_max, and at least 0, in the worst case (ours).

    Parameters
    ----------
    v, most, least : arrays, speeds [m/s], and the accelerations between which theirs are [m/s2]
    errors, constants : as for `uncertain_period`

    Returns
    -------
    faster, slower : arrays like v [s]
    """
    xp = array_namespace(v)
    up = xp.maximum(constants.v_max - (v + errors.error_v), 0.0)
    down = xp.maximum(v - errors.error_v, 0.0)
    faster = xp.where(most > 0.0, up / xp.where(most > 0.0, most, 1.0), np.inf)
    slower = xp.where(least < 0.0, down / xp.where(least < 0.0, -least, 1.0), np.inf)
    return faster, slower
