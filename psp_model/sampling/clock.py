"""Time as sampling periods."""

from __future__ import annotations

from math import floor

from ..errors import ModelError

MOST_PERIODS = 9e15  # more cannot be told apart in double precision
TIME_TOLERANCE = 1e-6  # [sampling periods] a time this close to a nominal sampling instant is that instant


def locate(time: float, T: float) -> tuple[int, float]:
    """Time as whole sampling periods and a fraction in [0, 1), rounded to a nominal instant within TIME_TOLERANCE.

    Ours, because masters add their steps up and arrive at a sampling instant with rounding errors.

    Parameters
    ----------
    time : time since the start [s]
    T : sampling period [s]

    Raises
    ------
    ModelError : where that is more sampling periods than can be counted
    """
    periods = time / T
    if not abs(periods) < MOST_PERIODS:
        raise ModelError("periods", time, T)
    nearest = round(periods)
    if abs(periods - nearest) <= TIME_TOLERANCE:
        return nearest, 0.0
    return floor(periods), periods - floor(periods)
