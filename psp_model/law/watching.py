"""Estimates of other vehicles' accelerations, and the memory of closing up (ours)."""

from __future__ import annotations

from math import exp
from typing import NamedTuple

from ..namespaces import Array, array_namespace

ESTIMATE_TIME = 0.2  # [s] an estimated acceleration follows speed differences with this time constant (ours)
CLOSING_TIME = 2.0  # [s] closing up sets in, and ends, with this time constant (ours)


class Watched(NamedTuple):
    """What is remembered from one sampling instant to the next.

    Attributes
    ----------
    v : (n, ...) speeds measured last [m/s]
    a : (n, ...) accelerations estimated from them [m/s2]
    closing : (n, ...) what closing up adds to the desired speeds [m/s]
    """

    v: Array
    a: Array
    closing: Array


def watch(before: Watched | None, v: Array, wanted: Array, T: float) -> Watched:
    """What is remembered after another sampling instant (ours).

    Parameters
    ----------
    before : what was remembered at the last one, None at the first
    v : (n, ...) speeds measured [m/s]
    wanted : (n, ...) what closing up would add if it were engaged at once, from `closing_speeds` [m/s]
    T : time since the last one [s]
    """
    if before is None:
        return Watched(v, 0.0 * v, 0.0 * v)
    estimate = nearer(before.a, (v - before.v) / T, 1.0 - exp(-T / ESTIMATE_TIME))
    return Watched(v, estimate, engaged(before.closing, wanted, T))


def nearer(before: Array, value: Array, share: float) -> Array:
    """What follows a value with a share of the difference (ours).

    Parameters
    ----------
    before, value : arrays of one unit
    share : from 0 to 1 [1]
    """
    return before + share * (value - before)


def engaged(before: Array, wanted: Array, T: float) -> Array:
    """What closing up adds to the desired speeds, a time later (ours).

    Parameters
    ----------
    before : (n, ...) what it added [m/s]
    wanted : (n, ...) what it would add if it were engaged at once, from `closing_speeds` [m/s]
    T : that time [s]

    Returns
    -------
    (n, ...) array [m/s]
    """
    return nearer(before, wanted, 1.0 - exp(-T / CLOSING_TIME))


def accelerations(watched: Watched, measured: Array | None, known: Array | None) -> Array:
    """The acceleration of each vehicle that drives itself: communicated where known, else estimated (ours).

    Parameters
    ----------
    watched : what is remembered
    measured : (n, ...) accelerations communicated [m/s2], None for none
    known : (n, ...) 1 where they are, 0 else; None where all are

    Returns
    -------
    (n, ...) array [m/s2]
    """
    if measured is None:
        return watched.a
    if known is None:
        return measured + 0.0 * watched.a
    return array_namespace(watched.a).where(known + 0.0 * watched.a > 0.5, measured, watched.a)
