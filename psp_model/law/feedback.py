"""The feedback law: from spacings and speeds to accelerations."""

from __future__ import annotations

from ..namespaces import Array, Number, array_namespace
from ..parameters import PlatoonParameters
from .potential import Potential

SPEED_MARGIN = 0.5  # [m/s] a desired speed counts as this far from 0 and from v_max in g's denominators (ours)


def f(x: Number, epsilon: Number) -> Array:
    """The smoothed positive part (paper, eq. of f): 0 below -epsilon, x + epsilon/2 above 0, a parabola between.

    Parameters
    ----------
    x : array, acceleration [m/s2]
    epsilon : width of the smoothing [m/s2]

    Returns
    -------
    array like x [m/s2], never below max(x, 0)
    """
    xp = array_namespace(x)
    return xp.maximum(x, 0.0) + _excess(xp.minimum(x, 0.0), epsilon)


def _excess(negative: Array, epsilon: Number) -> Array:
    """f(x) - max(x, 0), between 0 and epsilon/2 [m/s2], from the negative part min(x, 0)."""
    ramp = array_namespace(negative).maximum(negative + epsilon, 0.0)
    return ramp * ramp / (2.0 * epsilon)


def g(x: Number, constants: PlatoonParameters) -> Array:
    """g(x) = v_max f(x) / (v* (v_max - v*)) - x / v* (paper, eq. of g).

    Written as a sum of terms that are each >= 0, so that rounding cannot make a gain smaller than mu (ours):
    with x = x+ + x- and f = x+ + excess, g = v_max excess / (v* (v_max - v*)) + x+ / (v_max - v*) - x- / v*.

    Parameters
    ----------
    x : array, sum of the slopes on a vehicle [m/s2]
    constants : v_star, v_max, epsilon

    Returns
    -------
    array like x [1/s], never negative
    """
    xp = array_namespace(x)
    margin = constants.v_max - constants.v_star
    negative = xp.minimum(x, 0.0)
    smooth = constants.v_max * _excess(negative, constants.epsilon) / (constants.v_star * margin)
    return smooth + xp.maximum(x, 0.0) / margin - negative / constants.v_star


def repulsion(s: Array, shape: Potential, constants: PlatoonParameters) -> Array:
    """u: the slopes of the potential that act on each vehicle (paper, eq. 2).

    u_1 = -V'(s_2), u_i = V'(s_i) - V'(s_{i+1}), u_n = V'(s_n)

    Parameters
    ----------
    s : (n-1, ...) array, spacings [m], leader's first

    Returns
    -------
    (n, ...) array [m/s2], leader first
    """
    xp = array_namespace(s)
    slope = shape.slope(s, constants)
    if s.shape[0] == 0:  # a lone vehicle: nothing acts on it
        return xp.zeros((1, *s.shape[1:]))
    return xp.concat([-slope[:1], slope[:-1] - slope[1:], slope[-1:]])


def gain(u: Array, constants: PlatoonParameters) -> Array:
    """k_i = mu + g(u_i) (paper, eq. 3).

    Parameters
    ----------
    u : (n, ...) array from `repulsion` [m/s2]

    Returns
    -------
    (n, ...) array [1/s], never below mu
    """
    return constants.mu + g(u, constants)


def feedback(s: Array, v: Array, shape: Potential, constants: PlatoonParameters) -> Array:
    """F_i = -k_i (v_i - v*) + u_i (paper, eq. 2).

    Computed in an equal form without cancellation (ours), from which Theorem 1's signs can be read off:
    F = -(mu + v_max excess(u) / (v* (v_max - v*))) (v - v*) + u+ (v_max - v) / (v_max - v*) + u- v / v*,
    which is above 0 at v = 0 and below 0 at v = v_max for every u, however large, also in floating point.

    Parameters
    ----------
    s : (n-1, ...) array, spacings [m], all above L
    v : (n, ...) array, speeds [m/s], in [0, v_max]

    Returns
    -------
    (n, ...) array, accelerations [m/s2]
    """
    return command(repulsion(s, shape, constants), v, constants)


def feedback_towards(s: Array, v: Array, shape: Potential, constants: PlatoonParameters, v_desired: Number) -> Array:
    """F_i with another desired speed than v*, anywhere in [0, v_max] (ours).

    Parameters
    ----------
    s, v : as for `feedback`
    v_desired : desired speed [m/s], in [0, v_max]

    Returns
    -------
    (n, ...) array, accelerations [m/s2]; those of `feedback` with v* = v_desired, bit for bit, for v_desired from
    SPEED_MARGIN to v_max - SPEED_MARGIN
    """
    return command_towards(repulsion(s, shape, constants), v, constants, v_desired)


def command(u: Array, v: Array, constants: PlatoonParameters) -> Array:
    """F_i from the slopes u_i that act on a vehicle and its speed (paper, eq. 2, in the form that `feedback` gives).

    Parameters
    ----------
    u : (n, ...) array from `repulsion` [m/s2]
    v : (n, ...) array, speeds [m/s], in [0, v_max]

    Returns
    -------
    (n, ...) array, accelerations [m/s2]
    """
    return _command(u, v, constants, constants.v_star, constants.v_star, constants.v_max - constants.v_star)


def command_towards(u: Array, v: Array, constants: PlatoonParameters, v_desired: Number) -> Array:
    """F_i for a desired speed v_d in [0, v_max] in the place of v* (ours; proofs: docs/theory.md).

    g has v* and v_max - v* in its denominators.  Here v_d stays the speed that the vehicle tends to, and the
    denominators are kept at SPEED_MARGIN and above.  What pushes forward counts by the share v_d / SPEED_MARGIN where
    v_d is lower than that: without this the vehicles of a platoon with v_d = 0 would push each other forward.

    Parameters
    ----------
    u, v : as for `command`
    v_desired : v_d [m/s], in [0, v_max]

    Returns
    -------
    (n, ...) array, accelerations [m/s2]: at v = 0 never below mu v_d, at v = v_max never above mu (v_d - v_max)
    """
    xp = array_namespace(u)
    least = xp.maximum(v_desired, SPEED_MARGIN)
    divisor = xp.maximum(xp.minimum(v_desired, constants.v_max - SPEED_MARGIN), SPEED_MARGIN)
    margin = xp.maximum(constants.v_max - v_desired, SPEED_MARGIN)
    u = xp.minimum(u, 0.0) + xp.maximum(u, 0.0) * (v_desired / least)
    return _command(u, v, constants, v_desired, divisor, margin)


def _command(
    u: Array, v: Array, constants: PlatoonParameters, target: Number, divisor: Number, margin: Number
) -> Array:
    """The law for a desired speed `target`, with what stands for v* and v_max - v* in g's denominators, all [m/s]."""
    xp = array_namespace(u)
    negative = xp.minimum(u, 0.0)
    smooth = constants.mu + constants.v_max / (divisor * margin) * _excess(negative, constants.epsilon)
    pushed = xp.maximum(u, 0.0) * ((constants.v_max - v) / margin)
    held = negative * (v / divisor)
    return pushed + held - smooth * (v - target)
