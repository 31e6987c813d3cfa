"""A vehicle with a first-order lag under one command, standstill included; in closed form (ours)."""

from __future__ import annotations

from math import expm1

import numpy as np

from ..law.cooperation import is_off
from ..namespaces import Array, Number, array_namespace

NEWTON_STEPS = 30  # from the convex side of one root: more than double precision needs


def unless_standing(v: Array, a: Array) -> Array:
    """Accelerations, none below 0 for vehicles that stand: these do not roll back (ours).

    Parameters
    ----------
    v, a : (n, ...) arrays, speeds [m/s] and accelerations [m/s2]

    Returns
    -------
    (n, ...) array [m/s2]
    """
    xp = array_namespace(v)
    return xp.where(v > 0.0, a, xp.maximum(a, 0.0))


def ride(v: Array, a: Array, command: Array, lag: Number, span: Number) -> tuple[Array, Array, Array]:
    """v' = a, lag a' = command - a while v > 0; a vehicle that has stopped stands until a rises above 0 (ours).

    v(t) = v + t command + (a - command) lag (1 - exp(-t / lag)), and a lag of 0 gives v + t command.

    Parameters
    ----------
    v, a : (n, ...) speeds [m/s], not negative, and accelerations [m/s2]
    command : (n, ...) array, held [m/s2]
    lag : time constants, numbers or (n, ...) array, 0 for none [s]
    span : time [s]

    Returns
    -------
    v, moved, a : (n, ...) arrays a time span later [m/s], [m], [m/s2]; a is the actuators', also at standstill
    """
    xp = array_namespace(v)
    begins = first_felt(a, command, lag)
    then, moved, after = unstopped(v, a, command, lag, span, faded(a, lag, span))
    lowest = v + span * xp.minimum(xp.minimum(begins, command), 0.0)
    if isinstance(lowest, np.ndarray) and lowest.min() >= 0.0:
        return then, moved, after
    return (*_with_stop(v, begins, command, lag, span, then, moved), after)


def unstopped(
    v: Array, a: Array, command: Array, lag: Number, span: Number, shares: tuple[Number, Number]
) -> tuple[Array, Array, Array]:
    """`ride` where no vehicle stops (ours).

    Parameters
    ----------
    v, a, command, lag, span : as for `ride`
    shares : from `faded`

    Returns
    -------
    v, moved, a : arrays [m/s], [m], [m/s2]
    """
    gone, kept = shares
    excess = a - command
    then = v + span * command + excess * kept
    moved = span * (v + 0.5 * span * command) + excess * (lag * (span - kept))
    return then, moved, approached(a, command, gone)


def approached(a: Array, command: Number, gone: Number) -> Array:
    """The acceleration on its way to the command, once a share of the difference is gone (ours).

    Parameters
    ----------
    a, command : arrays [m/s2]
    gone : from `faded` [1]
    """
    return command + (a - command) * (1.0 - gone)


def first_felt(a: Array, command: Array, lag: Number) -> Array:
    """The acceleration with which a ride begins: the command at once where there is no lag (ours).

    Parameters
    ----------
    a, command, lag : as for `ride`
    """
    if isinstance(lag, int | float):
        return a if lag > 0.0 else command
    return array_namespace(a).where(lag + 0.0 * a > 0.0, a, command)


def faded(a: Array, lag: Number, span: Number) -> tuple[Number, Number]:
    """1 - exp(-span / lag), and lag times that; 1 and 0 without a lag (ours).

    Parameters
    ----------
    a : array that gives the shape
    lag, span : time constants, 0 for none, and time [s]

    Returns
    -------
    shares [1], [s]
    """
    if is_off(lag):
        return 1.0, 0.0
    if isinstance(lag, int | float) and isinstance(span, int | float):
        gone = -expm1(-span / lag)
        return gone, lag * gone
    xp = array_namespace(a)
    lag = lag + 0.0 * a
    gone = xp.where(lag > 0.0, -xp.expm1(-span / xp.where(lag > 0.0, lag, 1.0)), 1.0)
    return gone, lag * gone


def uninterrupted(v: Array, a: Array, command: Number, lag: Number, span: Number) -> tuple[Array, Array]:
    """Speed and distance of a vehicle that may reverse (ours).

    Parameters
    ----------
    v, a, command, lag, span : as for `ride`; without a lag a is the command

    Returns
    -------
    speed, distance : arrays [m/s], [m]
    """
    if is_off(lag):
        return v + span * command, span * (v + 0.5 * span * command)
    _, kept = faded(a, lag, span)
    excess = a - command
    then = v + span * command + excess * kept
    return then, span * (v + 0.5 * span * command) + excess * lag * (span - kept)


def _with_stop(
    v: Array, a: Array, command: Array, lag: Number, span: Number, then: Array, moved: Array
) -> tuple[Array, Array]:
    """Speed and distance where vehicles may come to a stop on the way, and may drive off again."""
    xp = array_namespace(v)
    again = (a < 0.0) * (command > 0.0)  # braking still, but told to drive off; symbols know no &
    turn = turning(a, command, lag)
    low = xp.where(again, xp.minimum(turn, span), span)  # where the speed is least, besides now
    stops = uninterrupted(v, a, command, lag, low)[0] < 0.0
    stop = first_stop(v, a, command, lag, xp.where(stops, low, 0.0))
    gone = xp.where(again * stops, xp.maximum(span - turn, 0.0), 0.0)
    speed, further = uninterrupted(0.0 * v, 0.0 * a, command, lag, gone)
    until = uninterrupted(v, a, command, lag, stop)[1]
    return xp.where(stops, xp.maximum(speed, 0.0), xp.maximum(then, 0.0)), xp.where(stops, until + further, moved)


def turning(a: Array, command: Array, lag: Number) -> Array:
    """When a vehicle that brakes still, but is told to drive off, brakes no more (ours).

    Parameters
    ----------
    a, command, lag : as for `ride`

    Returns
    -------
    array [s], 0 for other vehicles
    """
    xp = array_namespace(a)
    again = (a < 0.0) * (command > 0.0)
    return lag * xp.log(xp.where(again, 1.0 - a / xp.where(again, command, 1.0), 1.0))


def first_stop(v: Array, a: Array, command: Number, lag: Number, low: Array) -> Array:
    """When the speed falls to 0, by Newton's method from the side where it is monotone (ours).

    Parameters
    ----------
    v, a, command, lag : as for `ride`; without a lag a is the command
    low : a time at which the speed is not above 0 [s]

    Returns
    -------
    array [s]
    """
    xp = array_namespace(v)
    t = xp.where(a < command, 0.0 * low, low)
    for _ in range(NEWTON_STEPS):
        t = nearer_stop(v, a, command, lag, t, low)
    return t


def nearer_stop(v: Array, a: Array, command: Number, lag: Number, t: Array, low: Array) -> Array:
    """One step of Newton's method towards the time at which the speed falls to 0 (ours).

    Parameters
    ----------
    v, a, command, lag, low : as for `first_stop`
    t : the time found so far [s]

    Returns
    -------
    array [s], from 0 to `low`
    """
    xp = array_namespace(v)
    gone, kept = faded(a, lag, t)
    slope = approached(a, command, gone)
    speed = v + t * command + (a - command) * kept
    step = xp.where(slope < 0.0, speed / xp.where(slope < 0.0, slope, -1.0), 0.0)
    return xp.minimum(xp.maximum(t - step, 0.0), low)
