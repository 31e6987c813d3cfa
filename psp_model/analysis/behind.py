"""A platoon behind a leader who drives himself: what became of it, and the figures it is judged by."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan

import numpy as np
from numpy.typing import NDArray

from ..figures import Figure, smallest

Batch = NDArray[np.float64]
QUIET = 1e-3  # [m/s2] no gain is given over a vehicle whose root mean square acceleration is less


@dataclass(frozen=True, eq=False)
class BehindLeader:
    """The output of a run at K sampling instants; the run ends where vehicles touch (ours).

    Attributes
    ----------
    time : (K,) [s]
    x, v : (K, n) positions [m] and speeds [m/s], the leader's first
    s, clearance : (K, n-1) spacings and clearances, 0 or below where vehicles touch [m]
    a : (K, n) accelerations of the vehicles at these times [m/s2]
    command : (K, n) accelerations commanded there; the leader's own [m/s2]
    T_max, T_exact, brake_margin : (K,) the controller's outputs [s], [s], [m/s2]
    certified, in_order : (K,) likewise, 1 or 0
    """

    time: Batch
    x: Batch
    v: Batch
    s: Batch
    clearance: Batch
    a: Batch
    command: Batch
    T_max: Batch
    T_exact: Batch
    brake_margin: Batch
    certified: Batch
    in_order: Batch

    @property
    def mean_accelerations(self) -> Batch:
        """(K-1, n) mean accelerations of the vehicles between the instants [m/s2]."""
        found: Batch = np.diff(self.v, axis=0) / np.diff(self.time)[:, None]
        return found

    @property
    def contact(self) -> tuple[float, int] | None:
        """When vehicles touch [s], and the number of the one behind; None where none do."""
        touching = np.argwhere(self.clearance <= 0.0)
        return None if touching.size == 0 else (float(self.time[touching[0, 0]]), int(touching[0, 1]) + 2)

    def gain(self, last: int, first: int) -> float:
        """Root mean square acceleration of one vehicle over that of another; NaN where the other hardly has any.

        Parameters
        ----------
        last, first : their places, counted from 0
        """
        size = np.sqrt((self.mean_accelerations**2).sum(axis=0) / max(len(self.time) - 1, 1))
        return float(size[last] / size[first]) if size[first] > QUIET else nan

    def figures(self) -> list[Figure]:
        """The numbers that such runs are compared by."""
        a = self.mean_accelerations[:, 1:]
        return [
            Figure("least clearance", "m", smallest(self.clearance)),
            Figure("largest clearance", "m", float(self.clearance.max())),
            Figure("smallest brake margin", "m/s²", smallest(self.brake_margin)),
            Figure("head-to-tail gain", "1", self.gain(-1, 0)),
            Figure("gain along the platoon", "1", self.gain(-1, 1)),
            Figure("largest deceleration", "m/s²", float((-a).max(initial=0.0))),
            Figure("largest acceleration", "m/s²", float(a.max(initial=0.0))),
            Figure("smallest T_max", "s", smallest(self.T_max)),
            Figure("smallest T_exact", "s", smallest(self.T_exact)),
            Figure("sampling instants not certified", "1", float((self.certified < 0.5).sum())),
            Figure("sampling instants with the fail-safe command", "1", float((self.in_order < 0.5).sum())),
        ]
