"""What certifies T along a whole run: which vehicle limits T, when, by how much, and which T holds throughout."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..law.controller import MakeController
from ..law.cooperation import PAPERS_LAW, Cooperation, contact_spacing
from ..law.extended import Engaged, ExtendedLaw
from ..law.potential import PotentialParameters
from ..objective import HORIZON
from ..parameters import PlatoonParameters
from ..platoon import SampledPlatoon
from ..run import Run
from ..sampling import policy
from ..sampling.clock import locate
from ..sampling.exact import exact_bounds
from ..sampling.lemma1 import period_bounds
from ..sampling.policy import Lemma1Policy, Sampling
from ..state import PlatoonState

KINDS = ("spacing to the vehicle ahead", "speed limit", "standstill")


@dataclass(frozen=True, eq=False, repr=False)
class Certificate:
    """What Lemma 1 or the exact period says along a run, K times.

    Attributes
    ----------
    T : sampling period of the run [s]
    time : (K,) [s]
    T_max : (K,) the bound at each time, T_max or T_exact [s]
    vehicle : (K,) number of the vehicle that sets it
    kind : (K,) index into KINDS: what that vehicle would come up against
    bound : what the bound is called, "T_max" or "T_exact"
    """

    T: float
    time: NDArray[np.float64]
    T_max: NDArray[np.float64]
    vehicle: NDArray[np.int64]
    kind: NDArray[np.int64]
    bound: str = "T_max"

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
        tightest = f"smallest {self.bound} {self.T_max[at]:.4g} s at t = {self.time[at]:.4g} s ({self.who(at)})"
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


def certify(
    run: Run,
    constants: PlatoonParameters,
    T: float,
    cooperation: Cooperation = PAPERS_LAW,
    certificate: policy.Certificate | int = policy.Certificate.LEMMA1,
) -> Certificate:
    """Lemma 1, or the exact period, at every output time of a run.

    The bound is exact where the output times are the sampling instants; between them `a` belongs to the last
    instant and the state does not, so use the output step T (as `psp_model.simulate` does by default).

    Parameters
    ----------
    run : the run
    constants : those it was made with
    T : its sampling period [s]
    cooperation : with the lengths of its vehicles
    certificate : what certifies T

    Returns
    -------
    Certificate
    """
    exact = certificate == policy.Certificate.EXACT
    s = contact_spacing(run.s.T, _by_columns(cooperation), constants)
    of_spacings, of_speeds = (exact_bounds if exact else period_bounds)(s, run.v.T, run.a.T, constants)
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
        bound="T_exact" if exact else "T_max",
    )


def _by_columns(cooperation: Cooperation) -> Cooperation:
    """The lengths as a column, for spacings at several times."""
    length = cooperation.length
    return cooperation if length is None else replace(cooperation, length=np.reshape(length, (-1, 1)))


def extended_law(cooperation: Cooperation, T: float) -> MakeController[Engaged | None]:
    """Makes the extended law from potential and constants (ours).

    Parameters
    ----------
    cooperation : its parameters
    T : sampling period [s]
    """
    return lambda potential, constants: ExtendedLaw(potential, constants, cooperation, T=T)


def largest_certified_period(
    start: PlatoonState,
    shape: PotentialParameters,
    duration: float = HORIZON,
    tolerance: float = 1e-4,
    cooperation: Cooperation = PAPERS_LAW,
    certificate: policy.Certificate | int = policy.Certificate.LEMMA1,
) -> float:
    """The largest sampling period that is certified at every instant of a run from a start (ours).

    A different T gives a different run, so each T tried is run to the end.  Bisection down from the bound at the
    start, to within `tolerance` of it: the answer is certified; a larger T that is certified again is not looked for.

    Parameters
    ----------
    start : initial state
    shape : the potential
    duration : of the run [s]; no longer period is looked for with the exact period, which may be infinite
    tolerance : relative width of the last interval
    cooperation : parameters of the law; the paper's by default
    certificate : what certifies T

    Returns
    -------
    the period [s]
    """
    sampling = Sampling(policy=Lemma1Policy.WARN, certificate=certificate)
    made = extended_law(cooperation, sampling.T)
    above = SampledPlatoon.begin(start, shape, sampling=sampling, controller=made).now.bound
    if certificate == policy.Certificate.EXACT:
        above = min(above, duration)

    def holds(T: float) -> bool:
        return holds_throughout(start, shape, T, duration, cooperation, certificate)

    below = above
    while not holds(below):
        above, below = below, 0.5 * below
    while above - below > tolerance * below:
        middle = 0.5 * (above + below)
        if holds(middle):
            below = middle
        else:
            above = middle
    return below


def holds_throughout(
    start: PlatoonState,
    shape: PotentialParameters,
    T: float,
    duration: float,
    cooperation: Cooperation = PAPERS_LAW,
    certificate: policy.Certificate | int = policy.Certificate.LEMMA1,
) -> bool:
    """Whether T is certified at every sampling instant of a run.

    Parameters
    ----------
    start, shape : where the run starts and its potential
    T : sampling period [s]
    duration : of the run [s]
    cooperation, certificate : as for `largest_certified_period`
    """
    sampling = Sampling(T, Lemma1Policy.ERROR, certificate=certificate)
    try:
        platoon = SampledPlatoon.begin(start, shape, sampling=sampling, controller=extended_law(cooperation, T))
        platoon.advance_to(locate(duration, T)[0], 0.0)
    except ModelError as error:
        if not error.key.startswith(("lemma1", "exact", "left")):
            raise
        return False
    return True
