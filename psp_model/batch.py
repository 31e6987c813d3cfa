"""Thousands of runs at once, as what they came to (ours)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from math import inf

import numpy as np
from numpy.typing import NDArray

from .errors import ModelError
from .figures import Figure, figures_table
from .law.controller import PaperLaw
from .law.potential import Potential, PotentialParameters, stacked
from .objective import HORIZON
from .parameters import ObjectiveWeights, PlatoonParameters
from .sampling.clock import locate
from .sampling.hold import IDEAL
from .sampling.period import decide, hold
from .state import PlatoonState, read_only
from .validate import validate

Array = NDArray[np.float64]

_COMPILED_FROM = 200  # runs; with fewer NumPy has finished before a compiled engine is loaded


@dataclass(frozen=True, eq=False, repr=False)
class Runs:
    """What B runs of n vehicles came to.

    Attributes
    ----------
    T : sampling period of the runs [s]
    s, v : (B, n-1) spacings [m] and (B, n) speeds [m/s] at the end
    s_min : (B,) smallest spacing at any sampling instant [m]
    a_peak : (B,) largest |acceleration| of any vehicle [m/s2]
    T_max : (B,) smallest bound of Lemma 1 on the way [s]
    cost : (B, 2) terms of J, of acceleration and of spacings
    """

    T: float
    s: Array
    v: Array
    s_min: Array
    a_peak: Array
    T_max: Array
    cost: Array

    @property
    def J(self) -> Array:
        """(B,) the objective."""
        return self.cost.sum(axis=1)

    @property
    def certified(self) -> NDArray[np.bool_]:
        """(B,) whether Lemma 1 certified T at every sampling instant; where not, a run may have left the state space."""
        return self.T_max > self.T

    def __len__(self) -> int:
        """B."""
        return len(self.T_max)

    def __repr__(self) -> str:
        """A short table: the worst and the mean of all runs."""
        figures = [
            Figure("smallest spacing, worst", "m", float(self.s_min.min())),
            Figure("peak |acceleration|, worst", "m/s²", float(self.a_peak.max())),
            Figure("J, mean", "1", float(self.J.mean())),
            Figure("J, 95 %", "1", float(np.quantile(self.J, 0.95))),
            Figure("smallest T_max, worst", "s", float(self.T_max.min())),
            Figure("certified throughout", "1", float(self.certified.sum())),
        ]
        return figures_table(f"{len(self)} runs of {self.v.shape[1]} vehicles", figures)


def simulate_many(
    starts: Sequence[PlatoonState],
    potential: Potential | Sequence[Potential],
    *,
    weights: ObjectiveWeights | None = None,
    T: float = 0.01,
    duration: float = HORIZON,
    compiled: bool | None = None,
) -> Runs:
    """Run many platoons of the same number of vehicles, each to the end, whatever Lemma 1 says on the way.

    Parameters
    ----------
    starts : B initial states with the same constants and number of vehicles, at least 2
    potential : for all, or a sequence of B of one family
    weights : of the objective; the paper's by default
    T : sampling period [s]
    duration : of each run [s], rounded to whole sampling periods
    compiled : whether the compiled engine of the search runs them, which needs the extra `offline`; None: where it is
        installed and worth it.  Its results differ from NumPy's in the last digits

    Returns
    -------
    Runs

    Raises
    ------
    ModelError : where a start is outside the state space, or the starts do not go together
    """
    weights = validate(weights or ObjectiveWeights())
    constants, periods = _common(starts), _periods(duration, T)
    potentials = list(potential) if isinstance(potential, Sequence) else [potential] * len(starts)
    if len(potentials) != len(starts):
        raise ModelError("batch_potentials", len(potentials), len(starts))
    ours = all(isinstance(one, PotentialParameters) for one in potentials)
    if compiled is None:
        compiled = ours and len(starts) >= _COMPILED_FROM and all(map(find_spec, ("casadi", "ziglang")))
    s, v = np.array([start.s for start in starts]), np.array([start.v for start in starts])
    if compiled and ours:
        return _compiled(s, v, potentials, constants, weights, T, periods)
    return _with_numpy(s, v, potentials, constants, weights, T, periods)


def _common(starts: Sequence[PlatoonState]) -> PlatoonParameters:
    """The constants that all starts share."""
    if not starts:
        raise ModelError("batch_empty")
    first = starts[0]
    for place, start in enumerate(starts, start=1):
        validate(start)
        if start.v.size != first.v.size or start.v.size < 2 or start.constants != first.constants:
            raise ModelError("batch_starts", place, start.v.size, first.v.size)
    return first.constants


def _periods(duration: float, T: float) -> int:
    if not 0 < T < inf:
        raise ModelError("T", T)
    if not 0 <= duration < inf:
        raise ModelError("duration", duration)
    return locate(duration, T)[0]


def _with_numpy(
    s: Array,
    v: Array,
    potentials: Sequence[Potential],
    constants: PlatoonParameters,
    weights: ObjectiveWeights,
    T: float,
    periods: int,
) -> Runs:
    law, count = PaperLaw(stacked(potentials), constants), len(s)
    vehicles, memory = IDEAL.begin(np.zeros(count), s.T, v.T), None
    s_min, a_peak, T_max = s.min(axis=1), np.zeros(count), np.full(count, inf)
    cost = np.zeros((2, count))
    with np.errstate(all="ignore"):  # a run that is not certified may leave the state space
        for _ in range(periods):
            memory, a, bound = decide(law, memory, vehicles)
            vehicles, added = hold(IDEAL, vehicles, a, T, weights)
            cost += np.array(added)
            T_max, a_peak = np.minimum(T_max, bound), np.maximum(a_peak, np.abs(a).max(axis=0))
            s_min = np.minimum(s_min, vehicles.s.min(axis=0))
    return Runs(T, *map(read_only, (vehicles.s.T, vehicles.v.T, s_min, a_peak, T_max, cost.T)))


def _compiled(
    s: Array,
    v: Array,
    potentials: Sequence[Potential],
    constants: PlatoonParameters,
    weights: ObjectiveWeights,
    T: float,
    periods: int,
) -> Runs:
    from .selection.search.engine import Engine, Problem  # here, because it brings CasADi

    problem = Problem(v.shape[1], constants, weights, T, periods * T)
    shapes = np.array(
        [(one.alpha, one.r, one.p, one.hill) for one in potentials if isinstance(one, PotentialParameters)]
    )
    found = Engine(problem, "double").summaries(np.hstack([s, v]), np.arange(len(s)), shapes)
    s_min = np.minimum(found.s_min, s.min(axis=1))
    return Runs(T, *map(read_only, (found.s, found.v, s_min, found.a_peak, found.T_max, found.cost)))
