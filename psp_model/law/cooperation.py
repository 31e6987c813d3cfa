"""The law for platoons on a road: viscosity, feed-forward, closing up, time gap, lengths (ours; docs/theory.md)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..namespaces import Array, Number, array_namespace
from ..parameters import PlatoonParameters
from .feedback import SPEED_MARGIN, command, command_towards, repulsion
from .following import NEAREST, shares_along, speeds_followed
from .potential import Potential

CLOSING_WIDTH = 15.0  # [m] closing up sets in, and ends, smoothly over this length (ours)
KEPT_SHARE = 0.1  # [1] of a clearance: no time gap takes more than the rest of it off the model spacing (ours)


@dataclass(frozen=True)
class Cooperation:
    """The parameters of the extended law; with the defaults it is the paper's law, bit for bit (ours).

    Each field is a number, an array that broadcasts with the vehicles, or a symbol; `following` is a number.

    Attributes
    ----------
    kappa : viscosity of vehicles at the smallest spacing [1/s]
    kappa_reach : model spacing at which viscosity has faded to 0 [m]
    time_gap : clearance per speed that is taken off the model spacing [s]
    feedforward : share of the followed vehicle's acceleration that is commanded, from 0 to 1 [1]
    following : 1 the nearest vehicle ahead that is not automated, 2 the predecessor
    closing_speed : by how much each vehicle may be faster than its predecessor in order to close up [m/s]
    closing_spacing : model spacing at which closing up sets in [m]
    closing_reach : model spacing at which closing up has faded to 0 [m]
    length : (n, ...) lengths of the vehicles, a number for all, or None for L [m]
    """

    kappa: Number = 0.0
    kappa_reach: Number = 30.0
    time_gap: Number = 0.0
    feedforward: Number = 1.0
    following: int = NEAREST
    closing_speed: Number = 0.0
    closing_spacing: Number = 15.0
    closing_reach: Number = 100.0
    length: Number | None = None


@dataclass(frozen=True)
class Traffic:
    """The inputs of the extended law at a sampling instant, besides spacings and speeds (ours).

    Attributes
    ----------
    automated : (n, ...) array, 0 for a vehicle that drives itself, 1 else; None where all are automated
    a : (n, ...) array, accelerations, of which those of vehicles that drive themselves count [m/s2]; None for 0
    v_desired : desired speed of vehicles that follow no vehicle, None for v* [m/s]
    a_desired : its derivative [m/s2]
    closing : (n, ...) array, what closing up adds to the desired speeds now, from `closing_speeds` [m/s]; None for 0
    """

    automated: Array | None = None
    a: Array | None = None
    v_desired: Number | None = None
    a_desired: Number = 0.0
    closing: Array | None = None


PAPERS_LAW, ALL_AUTOMATED = Cooperation(), Traffic()


def smooth_step(x: Array) -> Array:
    """x^2 (3 - 2x) between 0 and 1, 0 below, 1 above (ours).

    Parameters
    ----------
    x : array [1]

    Returns
    -------
    array like x [1]
    """
    xp = array_namespace(x)
    x = xp.minimum(xp.maximum(x, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


def contact_spacing(s: Array, cooperation: Cooperation, constants: PlatoonParameters) -> Array:
    """s_i - (length[i-1] - L): L where vehicle i touches the one ahead (ours).

    Parameters
    ----------
    s : (n-1, ...) array, spacings [m]

    Returns
    -------
    (n-1, ...) array [m]
    """
    length = cooperation.length
    if length is None:
        return s
    ahead: Any = length
    if getattr(length, "shape", ()):
        ahead = ahead[:-1]
    return s - (ahead - constants.L)


def clearances(s: Array, cooperation: Cooperation, constants: PlatoonParameters) -> Array:
    """c_i = s_i - length[i-1], bumper to bumper (ours).

    Parameters
    ----------
    s : (n-1, ...) array, spacings [m]

    Returns
    -------
    (n-1, ...) array [m]
    """
    return contact_spacing(s, cooperation, constants) - constants.L


def model_spacing(s: Array, v: Array, cooperation: Cooperation, constants: PlatoonParameters) -> Array:
    """s~_i = s_i - (length[i-1] - L) - time_gap v_i, what the potential is a function of (ours).

    The time gap takes at most 1 - KEPT_SHARE of the clearance, so that s~_i is above L exactly where no vehicles touch.

    Parameters
    ----------
    s, v : (n-1, ...) spacings [m] and (n, ...) speeds [m/s]

    Returns
    -------
    (n-1, ...) array [m]
    """
    contact = contact_spacing(s, cooperation, constants)
    if is_off(cooperation.time_gap):
        return contact
    xp = array_namespace(contact)
    least = constants.L + KEPT_SHARE * (contact - constants.L)
    return xp.maximum(contact - cooperation.time_gap * v[1:], least)


def viscosity(s: Array, v: Array, cooperation: Cooperation, constants: PlatoonParameters) -> Array:
    """kappa(s~_i) (v_{i-1} - v_i) + kappa(s~_{i+1}) (v_{i+1} - v_i), inwards at v_i = 0 and v_i = v_max (ours).

    kappa(s) falls smoothly from kappa at L to 0 at kappa_reach, as in the group's viscous controllers.

    Parameters
    ----------
    s, v : (n-1, ...) model spacings [m] and (n, ...) speeds [m/s]

    Returns
    -------
    (n, ...) array [m/s2]
    """
    if s.shape[0] == 0:
        return 0.0 * v
    depth = (cooperation.kappa_reach - s) / (cooperation.kappa_reach - constants.L)
    drag = cooperation.kappa * smooth_step(depth) * (v[:-1] - v[1:])
    return array_namespace(s).concat([-drag[:1], drag[:-1] - drag[1:], drag[-1:]])


def closing_speeds(s: Array, cooperation: Cooperation, automated: Array | None = None) -> Array:
    """What closing up adds to each desired speed: closing_speed sum w(s~_j) from the followed vehicle on (ours).

    w rises smoothly from 0 at closing_spacing to 1 at CLOSING_WIDTH more, and falls to 0 within CLOSING_WIDTH before
    closing_reach.  All spacings close at once, each at closing_speed.

    Parameters
    ----------
    s : (n-1, ...) array, model spacings [m]
    automated : as in `Traffic`

    Returns
    -------
    (n, ...) array [m/s]
    """
    begins = smooth_step((s - cooperation.closing_spacing) / CLOSING_WIDTH)
    ends = smooth_step((cooperation.closing_reach - s) / CLOSING_WIDTH)
    return shares_along(cooperation.closing_speed * begins * ends, automated, cooperation.following)


def desired(v: Array, traffic: Traffic, cooperation: Cooperation, constants: PlatoonParameters) -> tuple[Array, Array]:
    """v_d and a_d: the speed that each vehicle takes on, and its derivative as far as it is communicated (ours).

    Parameters
    ----------
    v : (n, ...) array, speeds [m/s]

    Returns
    -------
    v_d, a_d : (n, ...) arrays [m/s], [m/s2]
    """
    free = constants.v_star if traffic.v_desired is None else traffic.v_desired
    a = 0.0 * v if traffic.a is None else traffic.a + 0.0 * v
    speed, rate = speeds_followed(v, a, traffic.automated, cooperation.following, (free, traffic.a_desired))
    if traffic.closing is not None:
        xp = array_namespace(v)
        speed = xp.minimum(speed + traffic.closing, xp.maximum(speed, constants.v_max - SPEED_MARGIN))
    return speed, rate


def feed_forward(v: Array, a_desired: Number, share: Number, constants: PlatoonParameters) -> Array:
    """The part of a_d that is commanded, less and less of it within SPEED_MARGIN of a bound that it points to (ours).

    Without that Theorem 1's signs would not hold: at v = 0 a braking leader's acceleration points out of Omega.

    Parameters
    ----------
    v : (n, ...) array, speeds [m/s]
    a_desired : (n, ...) array, a_d [m/s2]
    share : the gain `feedforward` [1]

    Returns
    -------
    (n, ...) array [m/s2], not below 0 at v = 0 and not above 0 at v = v_max
    """
    xp = array_namespace(v)
    down = xp.minimum(xp.maximum(v / SPEED_MARGIN, 0.0), 1.0)
    up = xp.minimum(xp.maximum((constants.v_max - v) / SPEED_MARGIN, 0.0), 1.0)
    return share * (xp.minimum(a_desired, 0.0) * down + xp.maximum(a_desired, 0.0) * up)


def cooperative_command(
    s: Array, v: Array, shape: Potential, constants: PlatoonParameters, cooperation: Cooperation, traffic: Traffic
) -> Array:
    """F_i = -(mu + g(u_i)) (v_i - v_d,i) + u_i + viscosity + feedforward a_d, in the form without cancellation (ours).

    Parameters
    ----------
    s : (n-1, ...) array, spacings [m], all clearances above 0
    v : (n, ...) array, speeds [m/s], in [0, v_max]

    Returns
    -------
    (n, ...) array, accelerations [m/s2]; those of `feedback`, bit for bit, with start values; those of vehicles that
    drive themselves mean nothing
    """
    spacing = model_spacing(s, v, cooperation, constants)
    u = repulsion(spacing, shape, constants)
    free = traffic.automated is None and traffic.v_desired is None and traffic.closing is None
    if free and cooperation.following == NEAREST and is_off(traffic.a_desired):
        F = command(u, v, constants)
    else:
        speed, rate = desired(v, traffic, cooperation, constants)
        F = command_towards(u, v, constants, speed) + feed_forward(v, rate, cooperation.feedforward, constants)
    return F if is_off(cooperation.kappa) else F + viscosity(spacing, v, cooperation, constants)


def is_off(parameter: Number) -> bool:
    """Whether a parameter is the number 0, so that what it scales need not be computed (ours).

    Parameters
    ----------
    parameter : a number, an array or a symbol; only a number can be off
    """
    return isinstance(parameter, int | float) and parameter == 0
