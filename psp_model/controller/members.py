"""Which vehicle is which, after one has joined or left: the controller is told numbers, not names (ours)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .decision import Basis

Vector = NDArray[np.float64]


def members_of(before: Basis | None, rows: int, s: Vector, v: Vector) -> list[int | None]:
    """The place that each vehicle had before, counted from 0; None for one that was not there.

    Where one vehicle has joined or left, it is the one without which spacings and speeds fit those before best.  Else
    vehicles are known by their places: those at the end have joined, or have left.

    Parameters
    ----------
    before : what the last decision was based on, None where that is not known
    rows : how many vehicles there were
    s, v : (n-1,) spacings [m] and (n,) speeds [m/s] now
    """
    n = v.size
    if before is None or before.v.size != rows or abs(n - rows) != 1:
        return [i if i < rows else None for i in range(n)]
    if n < rows:
        left = odd_one_out(before.s, before.v, s, v)
        return [i for i in range(rows) if i != left]
    joined = odd_one_out(s, v, before.s, before.v)
    return [None if i == joined else i - (i > joined) for i in range(n)]


def odd_one_out(s: Vector, v: Vector, others_s: Vector, others_v: Vector) -> int:
    """The place of the vehicle without which the others are those of another platoon, as nearly as can be.

    The sum of squared differences of spacings [m] and speeds [m/s] is least; of equals the last place counts.

    Parameters
    ----------
    s, v : (m,) spacings [m] and (m+1,) speeds [m/s]
    others_s, others_v : (m-1,) and (m,), of the platoon without it
    """
    ahead, behind = _before(s[:-1] - others_s), _behind(s[1:] - others_s)
    merged = (s[:-1] + s[1:] - others_s) ** 2
    of_spacings = np.concatenate([behind[:1], ahead[:-1] + merged + behind[1:], ahead[-1:]])
    of_speeds = _before(v[:-1] - others_v) + _behind(v[1:] - others_v)
    return s.size - int(np.argmin((of_spacings + of_speeds)[::-1]))


def _before(difference: Vector) -> Vector:
    """The sum of squares ahead of each place, (k+1,) for (k,)."""
    return np.concatenate([[0.0], np.cumsum(difference * difference)])


def _behind(difference: Vector) -> Vector:
    """The sum of squares from each place on, (k+1,) for (k,)."""
    return np.concatenate([np.cumsum((difference * difference)[::-1])[::-1], [0.0]])
