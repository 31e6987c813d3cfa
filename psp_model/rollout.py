"""The best of a few candidates, found by rolling each out from the actual initial state."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .feasible import project
from .feedback import feedback
from .lemma1 import largest_period
from .objective import running_cost
from .parameters import ObjectiveWeights, PotentialParameters
from .platoon import Sampling, locate
from .sampled_data import advance
from .state import PlatoonState

Batch = NDArray[np.float64]


class Shapes(NamedTuple):
    """K triples as (K,) arrays alpha, r, p and hill, in the form that the potential takes."""

    alpha: Batch
    r: Batch
    p: Batch
    hill: Batch


def rollout_costs(
    start: PlatoonState,
    candidates: Sequence[PotentialParameters],
    weights: ObjectiveWeights,
    sampling: Sampling,
    horizon: float,
) -> tuple[Batch, NDArray[np.bool_]]:
    """J of each candidate from this start, and whether Lemma 1 certifies T throughout (ours).

    Parameters
    ----------
    start : initial state
    candidates : K feasible triples
    weights : of the objective
    sampling : T counts, the policy does not
    horizon : how far ahead to look [s], at least one sampling period is

    Returns
    -------
    J, certified : (K,) arrays
    """
    columns = np.array([(c.alpha, c.r, c.p, c.hill) for c in candidates]).T
    shapes = Shapes(*columns)
    count, T, constants = len(candidates), sampling.T, start.constants
    s, v = np.repeat(start.s[:, None], count, axis=1), np.repeat(start.v[:, None], count, axis=1)
    J, certified = np.zeros(count), np.ones(count, dtype=bool)
    with np.errstate(all="ignore"):  # a candidate that is not certified may leave the state space: it is not taken
        for _ in range(max(locate(horizon, T)[0], 1)):
            a = feedback(s, v, shapes, constants)
            certified &= largest_period(s, v, a, constants) > T
            J += sum(running_cost(s, v, a, T, weights))
            s, v = advance(s, v, a, T)
    return J, certified


def best_by_rollout(
    start: PlatoonState,
    candidates: Sequence[PotentialParameters],
    weights: ObjectiveWeights,
    sampling: Sampling,
    horizon: float,
) -> PotentialParameters:
    """The candidate with the least J among those that are certified throughout (ours).

    Parameters
    ----------
    start : initial state
    candidates : triples, the network's answer first; they are projected into the feasible set here
    weights : of the objective
    sampling : T counts, the policy does not
    horizon : how far ahead to look [s]

    Returns
    -------
    the best triple, the earlier of equals; the first candidate, projected, where none is certified
    """
    feasible = [project(candidate, start.constants) for candidate in candidates]
    J, certified = rollout_costs(start, feasible, weights, sampling, horizon)
    return feasible[int(np.argmin(np.where(certified, J, np.inf)))]
