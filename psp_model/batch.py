"""Many runs at once, reduced to their results (ours)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from math import inf
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .chosen import Word, is_potential, selector_of
from .errors import ModelError
from .figures import Figure, figures_table, warned
from .law.controller import PaperLaw
from .law.potential import Potential, PotentialParameters, stacked
from .objective import HORIZON
from .parameters import ObjectiveWeights, PlatoonParameters
from .sampling.clock import locate
from .sampling.hold import IDEAL
from .sampling.period import decide, hold
from .sampling.policy import Sampling
from .selection.selectors import Selector
from .state import PlatoonState, Start, as_state, read_only, shortened
from .validate import validate

Array = NDArray[np.float64]

Starts = Sequence[Start] | tuple[ArrayLike, ArrayLike]
"""Starts of a batch: states or pairs, or a pair of (B, n-1) spacings [m] and (B, n) speeds [m/s]."""

_COLUMNS = ("s", "v", "s_min", "a_peak", "T_max", "cost")
_COMPILED_FROM = 200  # runs; with fewer NumPy has finished before a compiled engine is loaded


@dataclass(frozen=True, eq=False, repr=False)
class Runs:
    """The results of B runs of n vehicles.

    Attributes
    ----------
    T : sampling period of the runs [s]
    s, v : (B, n-1) spacings [m] and (B, n) speeds [m/s] at the end
    s_min : (B,) smallest spacing at any sampling instant [m]
    a_peak : (B,) largest |acceleration| of any vehicle [m/s2]
    T_max : (B,) smallest bound of Lemma 1 on the way [s]
    cost : (B, 2) terms of J, of acceleration and of spacings
    potentials : (B,) in use
    warnings : why other potentials are in use than asked for, each sentence once, with the number of starts
    """

    T: float
    s: Array
    v: Array
    s_min: Array
    a_peak: Array
    T_max: Array
    cost: Array
    potentials: tuple[Potential, ...] = ()
    warnings: tuple[str, ...] = ()

    @property
    def J(self) -> Array:
        """(B,) the objective."""
        return self.cost.sum(axis=1)

    @property
    def certified(self) -> NDArray[np.bool_]:
        """(B,) whether Lemma 1 certified T at every sampling instant; where not, a run may have left Omega."""
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
        table = figures_table(f"{len(self)} runs of {self.v.shape[1]} vehicles{self._with()}", figures)
        return "\n".join([table, *warned(self.warnings)])

    def _with(self) -> str:
        """What to say of the potentials in the title."""
        first, *others = self.potentials or ("",)
        return f", {len(self)} potentials" if any(one != first for one in others) else f", {shortened(str(first))}"


def simulate_many(
    starts: Starts,
    potential: Potential | Sequence[Potential] | Selector | Word,
    *,
    weights: ObjectiveWeights | None = None,
    T: float = 0.01,
    duration: float = HORIZON,
    compiled: bool | None = None,
) -> Runs:
    """Run many platoons of the same number of vehicles, each to the end, whatever Lemma 1 says on the way.

    Parameters
    ----------
    starts : B initial states with the same constants and number of vehicles, at least 2: a sequence of states or of
        pairs of spacings [m] and speeds [m/s], or one pair of (B, n-1) and (B, n) arrays
    potential : for all, or a sequence of B of one family; or a selector or a word as for `simulate`, which then selects
        for each start
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
    (s, v, constants), periods = _together(starts), _periods(duration, T)
    potentials, warnings = _potentials(s, v, constants, potential, weights, T)
    ours = all(isinstance(one, PotentialParameters) for one in potentials)
    if compiled is None:
        compiled = ours and len(s) >= _COMPILED_FROM and all(map(find_spec, ("casadi", "ziglang")))
    run = _compiled if compiled and ours else _with_numpy
    found = run(s, v, potentials, constants, weights, T, periods)
    columns: dict[str, Any] = dict(zip(_COLUMNS, map(read_only, found), strict=True))
    return Runs(T, **columns, potentials=tuple(potentials), warnings=warnings)


def _together(starts: Starts) -> tuple[Array, Array, PlatoonParameters]:
    """(B, n-1) spacings, (B, n) speeds and the constants of all starts."""
    arrays = _pair_of_arrays(starts)
    if arrays is None:
        states = [as_state(start) for start in starts]  # type: ignore[arg-type]  # a sequence of them, by now
        if not states:
            raise ModelError("batch_empty")
        first = states[0]
        for place, state in enumerate(states, start=1):
            validate(state)
            if state.v.size != first.v.size or state.v.size < 2 or state.constants != first.constants:
                raise ModelError("batch_starts", place, state.v.size, first.v.size)
        return np.array([state.s for state in states]), np.array([state.v for state in states]), first.constants
    s, v, constants = *arrays, PlatoonParameters()
    if not len(v):
        raise ModelError("batch_empty")
    inside = (s > constants.L).all(axis=1) & ((v >= 0) & (v <= constants.v_max)).all(axis=1)
    for row in np.flatnonzero(~(inside & np.isfinite(s).all(axis=1))).tolist():
        validate(PlatoonState(s[row], v[row], constants))
    return s, v, constants


def _pair_of_arrays(starts: Starts) -> tuple[Array, Array] | None:
    """Starts that are a pair of (B, n-1) and (B, n) arrays with n >= 2, None where they are a sequence of starts."""
    if not isinstance(starts, tuple | list) or len(starts) != 2:
        return None
    try:
        s, v = (np.asarray(part, dtype=np.float64) for part in starts)
    except (TypeError, ValueError):
        return None
    fits = s.ndim == v.ndim == 2 and len(s) == len(v) and 1 <= s.shape[1] == v.shape[1] - 1
    return (s, v) if fits else None


def _potentials(
    s: Array,
    v: Array,
    constants: PlatoonParameters,
    asked: Potential | Sequence[Potential] | Selector | Word,
    weights: ObjectiveWeights,
    T: float,
) -> tuple[list[Potential], tuple[str, ...]]:
    """A potential for each start, and why some are not those asked for."""
    if is_potential(asked):
        return [asked] * len(s), ()
    if isinstance(asked, Sequence) and not isinstance(asked, str):
        if len(asked) != len(s):
            raise ModelError("batch_potentials", len(asked), len(s))
        return list(asked), ()
    selector = selector_of(asked, v.shape[1], weights, Sampling(T))
    found = [selector.select(one, other, constants) for one, other in zip(s, v, strict=True)]
    counts = Counter(selection.warning for selection in found if selection.warning)
    warnings = tuple(f"{count} of {len(found)} starts: {sentence}" for sentence, count in counts.items())
    return [selection.potential for selection in found], warnings


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
) -> tuple[Array, ...]:
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
    return vehicles.s.T, vehicles.v.T, s_min, a_peak, T_max, cost.T


def _compiled(
    s: Array,
    v: Array,
    potentials: Sequence[Potential],
    constants: PlatoonParameters,
    weights: ObjectiveWeights,
    T: float,
    periods: int,
) -> tuple[Array, ...]:
    from .selection.search.engine import Engine, Problem  # here, because it brings CasADi

    problem = Problem(v.shape[1], constants, weights, T, periods * T)
    shapes = np.array(
        [(one.alpha, one.r, one.p, one.hill) for one in potentials if isinstance(one, PotentialParameters)]
    )
    found = Engine(problem, "double").summaries(np.hstack([s, v]), np.arange(len(s)), shapes)
    s_min = np.minimum(found.s_min, s.min(axis=1))
    return found.s, found.v, s_min, found.a_peak, found.T_max, found.cost
