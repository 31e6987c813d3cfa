"""The best of a few candidates, found by rolling each out from the actual initial state."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import cast

import numpy as np
from numpy.typing import NDArray

from ..law.controller import Controller, MakeController, Memory, PaperLaw
from ..law.potential import Potential, PotentialParameters, stacked
from ..objective import HORIZON
from ..parameters import ObjectiveWeights
from ..sampling.clock import locate
from ..sampling.hold import IDEAL, Moving, Plant, Vehicles
from ..sampling.period import decide, hold
from ..sampling.policy import Sampling
from ..state import PlatoonState, Start, as_state
from .feasible import project

Batch = NDArray[np.float64]

STEP_R, STEP_P = 0.1, 0.15  # [m], [1] first step of the refinement
MOST_ROUNDS = 3
CROSS = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
_STEPS = np.array([[0.0, STEP_R * r, STEP_P * p] for r, p in CROSS])

Tried = Callable[[Batch], tuple[Batch, Batch]]
"""Rolls out (B, K, 3) triples, K for each start: gives them as projected into the feasible set, and their (B, K) J,
infinite where Lemma 1 does not certify T throughout."""


def rollout_costs(
    start: Start,
    candidates: Sequence[Potential],
    weights: ObjectiveWeights | None = None,
    sampling: Sampling | None = None,
    horizon: float = HORIZON,
    *,
    controller: MakeController[Memory] | None = None,
    plant: Plant[Vehicles] | None = None,
) -> tuple[Batch, NDArray[np.bool_]]:
    """J of each candidate from this start, and whether Lemma 1 certifies T throughout (ours).

    Parameters
    ----------
    start : initial state, or a pair of (n-1,) spacings [m] and (n,) speeds [m/s]
    candidates : K potentials of one family
    weights : of the objective; the paper's by default
    sampling : T counts, the policy does not; T = 0.01 s by default
    horizon : how far ahead to look [s], at least one sampling period is
    controller : makes the controller from potential and constants; the paper's law by default
    plant : what is driven; double integrators by default

    Returns
    -------
    J, certified : (K,) arrays
    """
    start, weights, T = as_state(start), weights or ObjectiveWeights(), (sampling or Sampling()).T
    count = len(candidates)
    potential = stacked(candidates)
    law: object = PaperLaw(potential, start.constants) if controller is None else controller(potential, start.constants)
    driven = cast(Plant[Moving], IDEAL if plant is None else plant)
    s, v = np.repeat(start.s[:, None], count, axis=1), np.repeat(start.v[:, None], count, axis=1)
    memory: object = None
    vehicles = driven.begin(np.full(count, start.x_leader), s, v)
    J, certified = np.zeros(count), np.ones(count, dtype=bool)
    with np.errstate(all="ignore"):  # a candidate that is not certified may leave the state space: it is not taken
        for _ in range(max(locate(horizon, T)[0], 1)):
            memory, a, T_max = decide(cast(Controller[object], law), memory, vehicles)
            certified &= T_max > T
            vehicles, added = hold(driven, vehicles, a, T, weights)
            J += sum(added)
    return J, certified


def share_rollouts(rollouts: int) -> tuple[int, int]:
    """How a budget is spent best: on the network's candidates first, then on rounds of refinement (ours, measured).

    Parameters
    ----------
    rollouts : the budget, at least 1

    Returns
    -------
    candidates, rounds : their number, and the rounds of 4 rollouts each; 16 are 12 and 1, 32 are 20 and 3
    """
    rounds = min(max(rollouts // 8 - 1, 0), MOST_ROUNDS)
    return rollouts - len(CROSS) * rounds, rounds


def best_by_rollout(
    start: PlatoonState,
    candidates: Sequence[PotentialParameters],
    weights: ObjectiveWeights,
    sampling: Sampling,
    horizon: float,
    rounds: int = 0,
) -> PotentialParameters:
    """The candidate with the least J among those that are certified throughout, refined (ours).

    Parameters
    ----------
    start : initial state
    candidates : triples, the network's answer first; they are projected into the feasible set here
    weights : of the objective
    sampling : T counts, the policy does not
    horizon : how far ahead to look [s]
    rounds : of refinement, as for `refined`

    Returns
    -------
    the best triple, the earlier of equals; the first candidate, projected, where none is certified
    """

    def tried(triples: Batch) -> tuple[Batch, Batch]:
        feasible = [project(PotentialParameters(*map(float, row)), start.constants) for row in triples[0]]
        J, certified = rollout_costs(start, feasible, weights, sampling, horizon)
        return as_rows(feasible)[None], np.where(certified, J, np.inf)[None]

    return PotentialParameters(*map(float, refined(tried, as_rows(candidates)[None], rounds)[0]))


def refined(tried: Tried, candidates: Batch, rounds: int) -> Batch:
    """The triple with the least J for each of B starts: of its candidates, then of those around the best so far (ours).

    A round of refinement tries r + h, r - h, p + k and p - k around the best triple so far and moves to the best of
    them if it has a smaller J; h = 0.1 m and k = 0.15 are halved after each round.

    Parameters
    ----------
    tried : rolls triples out
    candidates : (B, K, 3) array, alpha [1], r [m], p [1]
    rounds : of refinement

    Returns
    -------
    (B, 3) array, the earlier of equals; a start's first candidate where none is certified
    """
    best, least = _least(*tried(candidates))
    for number in range(rounds):
        around, J = tried(best[:, None] + _STEPS * 0.5**number)
        best, least = _least(
            np.concatenate([best[:, None], around], axis=1), np.concatenate([least[:, None], J], axis=1)
        )
    return best


def as_rows(triples: Sequence[PotentialParameters]) -> Batch:
    """Triples as an array.

    Parameters
    ----------
    triples : K of them

    Returns
    -------
    (K, 3) array, alpha [1], r [m], p [1]
    """
    return np.array([(one.alpha, one.r, one.p) for one in triples]).reshape(-1, 3)


def _least(triples: Batch, J: Batch) -> tuple[Batch, Batch]:
    """Of each row the triple with the least J, the first of equals, and that J."""
    place = J.argmin(axis=1)[:, None]
    return np.take_along_axis(triples, place[..., None], axis=1)[:, 0], np.take_along_axis(J, place, axis=1)[:, 0]
