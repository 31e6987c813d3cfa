"""Vehicles that act late and softly: dead time, first-order lag, limits; in closed form (ours)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from ..law.cooperation import is_off
from ..namespaces import Array, array_namespace
from ..parameters import Actuation
from .ride import approached, faded, ride


class Actuators(NamedTuple):
    """State of all actuators of a platoon.

    Attributes
    ----------
    a : (n, ...) accelerations that they give [m/s2]
    command : (n, ...) commands in effect [m/s2]
    queue : commands on their way, the first to take effect first, each with the time until then [s]
    """

    a: Array
    command: Array
    queue: tuple[tuple[float, Array], ...] = ()


class Foreign(NamedTuple):
    """Vehicles that drive themselves.

    Attributes
    ----------
    automated : (n, ...) array, 0 for these, 1 for the others
    a : (n, ...) array, accelerations, of which theirs count; held [m/s2]
    """

    automated: Array
    a: Array


def at_rest(v: Array) -> Actuators:
    """Actuators before the first command: they hold 0 (ours).

    Parameters
    ----------
    v : (n, ...) array, speeds [m/s]
    """
    return Actuators(0.0 * v, 0.0 * v)


def commanded(actuators: Actuators, a: Array, actuation: Actuation, ago: float = 0.0) -> Actuators:
    """The actuators once a command has been given (ours).

    Parameters
    ----------
    a : (n, ...) accelerations commanded [m/s2]
    ago : minus the time until it is given [s]
    """
    return actuators._replace(queue=(*actuators.queue, (actuation.actuation_delay - ago, a)))


def drive(
    v: Array, actuators: Actuators, actuation: Actuation, tau: float, foreign: Foreign | None = None
) -> tuple[Array, Array, Actuators]:
    """Speeds after a time tau, distances travelled, and the actuators then: exact (ours).

    Parameters
    ----------
    v : (n, ...) array, speeds [m/s], not negative
    tau : time [s]

    Returns
    -------
    v : (n, ...) array [m/s], not negative: vehicles brake to standstill and stand
    moved : (n, ...) array [m]
    actuators : their state
    """
    moved, a = 0.0 * v, actuators.a
    for span, command in segments(actuators, tau):
        given = limited(command, actuation)
        if foreign is not None:
            xp = array_namespace(v)
            own = foreign.automated > 0.5
            given, a = xp.where(own, given, foreign.a), xp.where(own, a, foreign.a)
        v, further, a = ride(v, a, given, actuation.actuator_lag, span)
        moved = moved + further
    return v, moved, _later(actuators, a, tau)


def settle(actuators: Actuators, actuation: Actuation, tau: float) -> Actuators:
    """The actuators a time tau later; nothing but their own state counts (ours).

    Parameters
    ----------
    tau : time [s]
    """
    a = actuators.a
    if is_off(actuation.actuator_lag):  # only the last command counts
        after = _later(actuators, a, tau)
        return after._replace(a=limited(after.command, actuation))
    for span, command in segments(actuators, tau):
        given = limited(command, actuation)
        a = approached(a, given, faded(a, actuation.actuator_lag, span)[0])
    return _later(actuators, a, tau)


def segments(actuators: Actuators, tau: float) -> Iterator[tuple[float, Array]]:
    """How long which command is in effect, for a time tau from now on (ours).

    Parameters
    ----------
    tau : time [s]
    """
    now, command = 0.0, actuators.command
    for due, following in actuators.queue:
        if due > tau:
            break
        if due > now:
            yield due - now, command
            now = due
        command = following
    yield tau - now, command


def limited(command: Array, actuation: Actuation) -> Array:
    """The command inside the limits of the vehicles (ours).

    Parameters
    ----------
    command : (n, ...) array [m/s2]
    """
    xp = array_namespace(command)
    return xp.minimum(xp.maximum(command, actuation.a_min), actuation.a_max)


def _later(actuators: Actuators, a: Array, tau: float) -> Actuators:
    """The actuators with another acceleration, and the queue a time tau later."""
    reached = [command for due, command in actuators.queue if due <= tau]
    left = tuple((due - tau, command) for due, command in actuators.queue if due > tau)
    return Actuators(a, reached[-1] if reached else actuators.command, left)
