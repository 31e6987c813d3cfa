"""Fewer points for lines that look the same: thinning with a bound on what it changes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

TOLERANCE = 5e-4  # [1] of the range that the lines of a plot span together


def kept(time: NDArray[np.float64], lines: NDArray[np.float64], tolerance: float = TOLERANCE) -> NDArray[np.int64]:
    """Which points to keep so that straight lines between them miss no dropped one by more than a tolerance (ours).

    All lines of a plot keep the same times.  A stretch is split at the point that is farthest off the chord, until none
    is (the algorithm of Ramer, Douglas and Peucker, with the distance measured along the vertical axis).

    Parameters
    ----------
    time : (K,) increasing [s]
    lines : (K, m) values
    tolerance : largest error, as a fraction of the range of all values

    Returns
    -------
    increasing indices into time, first and last included
    """
    spread = float(np.ptp(lines)) or 1.0
    keep = np.zeros(time.size, dtype=bool)
    keep[[0, -1]] = True
    stretches = [(0, time.size - 1)]
    while stretches:
        a, b = stretches.pop()
        if b - a < 2:
            continue
        fraction = ((time[a + 1 : b] - time[a]) / (time[b] - time[a]))[:, None]
        error = np.abs(lines[a + 1 : b] - (lines[a] + fraction * (lines[b] - lines[a]))).max(axis=1)
        worst = int(np.argmax(error))
        if error[worst] > tolerance * spread:
            middle = a + 1 + worst
            keep[middle] = True
            stretches += [(a, middle), (middle, b)]
    return np.flatnonzero(keep)


def rounded(lines: NDArray[np.float64], tolerance: float = TOLERANCE) -> NDArray[np.float64]:
    """Values with no more decimals than the tolerance makes visible.

    Parameters
    ----------
    lines : values
    tolerance : as for `kept`; rounding adds at most a tenth of it
    """
    spread = float(np.ptp(lines)) or 1.0
    step = tolerance * spread / 10.0
    if step < 1e-15:  # nothing to save, and decimals that rounding cannot count
        return lines
    return np.round(lines, max(int(np.ceil(-np.log10(step))), 0))
