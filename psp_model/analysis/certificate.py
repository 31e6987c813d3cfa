"""Lemma 1 along a whole run: which vehicle limits T, when, by how much, and which T is certified throughout."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..law.potential import PotentialParameters
from ..objective import HORIZON
from ..parameters import PlatoonParameters
from ..platoon import SampledPlatoon
from ..run import Run
from ..sampling.clock import locate
from ..sampling.lemma1 import period_bounds
from ..sampling.policy import Lemma1Policy, Sampling
from ..state import PlatoonState

KINDS = ("spacing to the vehicle ahead", "speed limit", "standstill")


@dataclass(frozen=True, eq=False, repr=False)
class Certificate:
    """What Lemma 1 says along a run, K times.

    Attributes
    ----------
    T : sampling period of the run [s]
    time : (K,) [s]
    T_max : (K,) the bound at each time [s]
    vehicle : (K,) number of the vehicle that sets it
    kind : (K,) index into KINDS: what that vehicle would come up against
    """

    T: float
    time: NDArray[np.float64]
    T_max: NDArray[np.float64]
    vehicle: NDArray[np.int64]
    kind: NDArray[np.int64]

    @property
    def certified(self) -> NDArray[np.bool_]:
        """(K,) whether T < T_max at each time."""
        return self.T_max > self.T

    @property
    def tightest(self) -> int:
        """Index of the smallest bound."""
        return int(np.argmin(self.T_max))

    def __repr__(self) -> str:
        count, at = int((~self.certified).sum()), self.tightest
        verdict = f"not certified at {count} of" if count else "certified at all"
        tightest = f"smallest T_max {self.T_max[at]:.4g} s at t = {self.time[at]:.4g} s ({self.who(at)})"
        return f"T = {self.T:g} s, {verdict} {self.time.size} times; {tightest}"

    def refused(self) -> list[tuple[float, float]]:
        """First and last time of every stretch of output times at which T is not certified [s]."""
        marks = np.flatnonzero(np.diff(np.concatenate([[False], ~self.certified, [False]]).astype(int)))
        return [(float(self.time[a]), float(self.time[b - 1])) for a, b in marks.reshape(-1, 2)]

    def who(self, index: int) -> str:
        """Which vehicle limits T at one time, in words.

        Parameters
        ----------
        index : of the time
        """
        return f"vehicle {self.vehicle[index]}, {KINDS[self.kind[index]]}"


def certify(run: Run, constants: PlatoonParameters, T: float) -> Certificate:
    """Lemma 1 at every output time of a run.

    The bound is exact where the output times are the sampling instants; between them `a` belongs to the last
    instant and the state does not, so use the output step T (as `psp_model.simulate` does by default).

    Parameters
    ----------
    run : the run
    constants : those it was made with
    T : its sampling period [s]

    Returns
    -------
    Certificate
    """
    of_spacings, of_speeds = period_bounds(run.s.T, run.v.T, run.a.T, constants)
    i, j = np.argmin(of_spacings, axis=0), np.argmin(of_speeds, axis=0)
    columns = np.arange(run.time.size)
    by_spacing, by_speed = of_spacings[i, columns], of_speeds[j, columns]
    spacing_first = by_spacing <= by_speed
    return Certificate(
        T=T,
        time=run.time,
        T_max=np.where(spacing_first, by_spacing, by_speed),
        vehicle=np.where(spacing_first, i + 2, j + 1),
        kind=np.where(spacing_first, 0, np.where(run.a.T[j, columns] > 0, 1, 2)),
    )


def largest_certified_period(
    start: PlatoonState, shape: PotentialParameters, duration: float = HORIZON, tolerance: float = 1e-4
) -> float:
    """The largest sampling period that Lemma 1 certifies at every instant of a run from a start (ours).

    A different T gives a different run, so each T tried is run to the end.  Bisection down from the bound at the
    start, to within `tolerance` of it: the answer is certified; a larger T that is certified again is not looked for.

    Parameters
    ----------
    start : initial state
    shape : the potential
    duration : of the run [s]
    tolerance : relative width of the last interval

    Returns
    -------
    the period [s]
    """
    above = SampledPlatoon.begin(start, shape, sampling=Sampling(policy=Lemma1Policy.WARN)).now.T_max
    below = above
    while not holds_throughout(start, shape, below, duration):
        above, below = below, 0.5 * below
    while above - below > tolerance * below:
        middle = 0.5 * (above + below)
        if holds_throughout(start, shape, middle, duration):
            below = middle
        else:
            above = middle
    return below


def holds_throughout(start: PlatoonState, shape: PotentialParameters, T: float, duration: float) -> bool:
    """Whether Lemma 1 certifies T at every sampling instant of a run.

    Parameters
    ----------
    start, shape : where the run starts and its potential
    T : sampling period [s]
    duration : of the run [s]
    """
    try:
        platoon = SampledPlatoon.begin(start, shape, sampling=Sampling(T, Lemma1Policy.ERROR))
        platoon.advance_to(locate(duration, T)[0], 0.0)
    except ModelError as error:
        if not error.key.startswith("lemma1"):
            raise
        return False
    return True
