"""How hard the vehicles ahead may brake from now on without a collision (ours; docs/theory.md)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..law.following import NEAREST, followed_by
from ..namespaces import Array, Number, array_namespace, smallest
from .ride import first_stop, ride, uninterrupted, unless_standing

TINY = 1e-12  # [s] no time is divided by less
MOST = 12.0  # [m/s2] no road allows harder braking: larger margins are not searched
INSTANTS = 200  # at which each pair is looked at before the vehicle behind stands, denser at first


class Braking(NamedTuple):
    """Vehicles that keep their accelerations for a while and then brake to standstill.

    Attributes
    ----------
    v, a : (n, ...) speeds [m/s], not negative, and accelerations held until the brakes act [m/s2]
    dead_time : time from now until the brakes' first effect, the age of what is measured included [s]
    lag : time constants of the actuators, numbers or (n, ...) array, 0 for none [s]
    a_min : accelerations braked with, below 0, numbers or (n, ...) array [m/s2]
    """

    v: Array
    a: Array
    dead_time: Number
    lag: Number
    a_min: Number

    def rows(self, which: slice) -> Braking:
        """Some of the vehicles.

        Parameters
        ----------
        which : their places
        """
        parts: Any = self
        return Braking(*(one[which] if getattr(one, "shape", ()) else one for one in parts))


def brake_margin(clearance: Array, vehicles: Braking, automated: Array | None = None) -> Array:
    """The largest b so that all vehicles not automated may brake with b to standstill and those behind do not collide.

    Without any vehicle that drives itself the leader is the one that brakes.  The automated vehicles behind it keep
    their accelerations for the dead time, then go over to a_min with their lags, each until it stands.

    Parameters
    ----------
    clearance : (n-1, ...) array, bumper to bumper [m]
    vehicles : all of them; speeds count, and of the automated ones everything
    automated : (n, ...) array, 0 for a vehicle that drives itself, 1 else; None where all are automated

    Returns
    -------
    (...) array, from 0 to MOST [m/s2]; 0 where vehicles would collide even if the one ahead did not brake, or where
    automated vehicles collide when all of them brake
    """
    v = vehicles.v
    xp = array_namespace(v)
    if v.shape[0] < 2:
        return MOST + 0.0 * v[0]
    automated = 1.0 + 0.0 * v if automated is None else automated + 0.0 * v
    first = xp.where(smallest(automated) < 0.5, automated[:1], 0.0)  # all are automated: the leader brakes
    brakes = xp.concat([first, automated[1:]])
    ahead, behind = vehicles.rows(slice(None, -1)), vehicles.rows(slice(1, None))
    of_ahead, of_behind = stop(ahead), stop(behind)

    def bound(t: Array) -> Array:
        needed = travelled(behind, of_behind, t) - clearance
        apart = xp.where(travelled(ahead, of_ahead, t) > needed, MOST, 0.0)
        return xp.where(brakes[:-1] < 0.5, hardest(needed, ahead.v, t), apart)

    counted = followed_by(brakes, NEAREST)[1:] > 0.5
    least = _least(bound, of_behind[0] + of_behind[1])
    return smallest(xp.where(counted, xp.minimum(xp.maximum(least, 0.0), MOST), MOST))


def _least(bound: Callable[[Array], Array], until: Array) -> Array:
    """The smallest of a function of time until a time, element by element, looked at more densely at first."""
    shares = [(k / INSTANTS) ** 2 for k in range(1, INSTANTS + 1)]
    if isinstance(until, np.ndarray):
        return bound(np.reshape(shares, (-1, *[1] * until.ndim)) * until).min(axis=0)
    xp = array_namespace(until)
    least = bound(until)
    for share in shares[:-1]:
        least = xp.minimum(least, bound(share * until))
    return least


def hardest(needed: Array, v: Array, t: Array) -> Array:
    """The largest constant deceleration that takes a vehicle at least `needed` far within a time t (ours).

    It travels v t - b t^2 / 2, or v^2 / (2 b) where it stands by then, which it does for b > v / t.

    Parameters
    ----------
    needed : array, how far [m]
    v : array, its speed now [m/s]
    t : array, time [s]

    Returns
    -------
    array [m/s2], at most MOST, below 0 where it would have to accelerate
    """
    xp = array_namespace(needed)
    t = xp.maximum(t, TINY)
    far = needed > 0.0
    length = xp.where(far, needed, 1.0)
    standing = 0.5 * v * v / length
    moving = 2.0 * (v - length / t) / t
    found = xp.where(length <= 0.5 * v * t, standing, moving)
    return xp.where(far, xp.minimum(found, MOST), MOST)


def stop(vehicles: Braking) -> tuple[Array, Array]:
    """For how long vehicles keep their accelerations, standing included, and then brake to standstill (ours).

    Returns
    -------
    kept, braked : (n, ...) arrays [s]; `kept` is the dead time
    """
    v, a, dead_time, lag, a_min = vehicles
    xp = array_namespace(v)
    speed, _, _ = ride(v, a, a, 0.0, dead_time)
    a = unless_standing(speed, a) + 0.0 * v
    low = (speed + xp.maximum(a - a_min, 0.0) * lag) / -a_min
    return dead_time + 0.0 * v, first_stop(speed, xp.where(lag + 0.0 * v > 0.0, a, a_min), a_min, lag, low)


def travelled(vehicles: Braking, stops: tuple[Array, Array], t: Array) -> Array:
    """How far vehicles get within a time (ours).

    Parameters
    ----------
    stops : from `stop` [s]
    t : array, time [s]

    Returns
    -------
    array [m]
    """
    v, a, dead_time, lag, a_min = vehicles
    xp = array_namespace(v)
    speed, first, _ = ride(v, a, a, 0.0, xp.minimum(t, dead_time + 0.0 * t))
    a = unless_standing(speed, a) + 0.0 * v
    braked = xp.minimum(xp.maximum(t - dead_time, 0.0), stops[1])
    _, then = uninterrupted(speed, xp.where(lag + 0.0 * v > 0.0, a, a_min), a_min, lag, braked)
    return first + then
