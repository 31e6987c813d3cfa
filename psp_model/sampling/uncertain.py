"""Lemma 1 for what is measured late and with bounded errors: the worst case at the predicted state (ours)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..namespaces import Array, Number, array_namespace, smallest
from ..parameters import PlatoonParameters


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
    most, least = xp.maximum(a, before), xp.minimum(a, before)
    up = xp.maximum(constants.v_max - (v + errors.error_v), 0.0)
    down = xp.maximum(v - errors.error_v, 0.0)
    of_gaps = xp.maximum(s - errors.error_s - constants.L, 0.0) / constants.v_max
    faster = xp.where(most > 0.0, up / xp.where(most > 0.0, most, 1.0), np.inf)
    slower = xp.where(least < 0.0, down / xp.where(least < 0.0, -least, 1.0), np.inf)
    return smallest(xp.concat([of_gaps, faster, slower]))
