"""Which potential a platoon runs with: a fixed triple, the network's answer, or the best of its candidates."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

from ..errors import ModelError
from ..parameters import BEST_FIXED, V_OLD, ObjectiveWeights, PlatoonParameters, PotentialParameters
from ..platoon import Sampling
from ..state import PlatoonState, StartDomain
from .feasible import project, require_feasible
from .network import ParameterNetwork
from .rollout import best_by_rollout, share_rollouts


class ParameterSource(IntEnum):
    """Where alpha, r, p come from."""

    NETWORK = 1
    FIXED = 2
    ROLLOUT = 3


@dataclass(frozen=True)
class Request:
    """What the user asks for.

    Attributes
    ----------
    old : V_old instead of V_new
    source : where alpha, r, p come from
    fixed : the triple for source FIXED, and the fallback of the others
    rollouts : most rollouts with source ROLLOUT
    horizon : of the rollouts [s]

    Raises
    ------
    ModelError : where the horizon is not positive and finite
    """

    old: bool = False
    source: ParameterSource = ParameterSource.NETWORK
    fixed: PotentialParameters = BEST_FIXED
    rollouts: int = 16
    horizon: float = 20.0

    def __post_init__(self) -> None:
        if not 0 < self.horizon < float("inf"):
            raise ModelError("horizon", self.horizon)


def outside_domain(
    s: Any, v: Any, constants: PlatoonParameters, domain: StartDomain, trained_with: PlatoonParameters
) -> str | None:
    """Why a network's answer does not hold for a start, or None if it does (ours).

    Parameters
    ----------
    s, v : (n-1,) gaps [m] and (n,) speeds [m/s]
    constants : of the model
    domain, trained_with : starts and constants that the network was trained on

    Returns
    -------
    the reason, to go into a sentence
    """
    if constants != trained_with:
        return "other constants than the network was trained with"
    if not domain.contains(s, v):
        return "gaps or speeds outside the network's training domain"
    return None


def _fallback(
    reason: str, request: Request, constants: PlatoonParameters, warn: Callable[[str], None]
) -> PotentialParameters:
    """The fixed triple, with a warning."""
    fixed = request.fixed
    require_feasible(fixed, constants)
    warn(str(ModelError("fallback", reason, fixed.alpha, fixed.r, fixed.p)))
    return fixed


def choose_potential(
    start: PlatoonState,
    request: Request,
    network: ParameterNetwork | None,
    weights: ObjectiveWeights,
    sampling: Sampling,
    warn: Callable[[str], None],
) -> PotentialParameters:
    """The potential for a start (paper, section IV, except the fallback and the rollouts, which are ours).

    Parameters
    ----------
    start : initial state
    request : what the user asks for
    network : the network for this number of vehicles, None if there is none
    weights, sampling : what rollouts are judged by
    warn : called with one sentence where the fallback is used

    Returns
    -------
    a feasible triple, or V_old

    Raises
    ------
    ModelError : where a fixed triple is not feasible or a network is asked for and missing or unreadable
    """
    n = start.v.size
    if network is None and not request.old and request.source is not ParameterSource.FIXED:
        raise ModelError("no_network", n)
    networks = {} if network is None else {n: network}
    return choose_for_any_number(start.s, start.v, start.constants, request, networks, weights, sampling, warn)[0]


def choose_for_any_number(
    s: Any,
    v: Any,
    constants: PlatoonParameters,
    request: Request,
    networks: Mapping[int, ParameterNetwork],
    weights: ObjectiveWeights,
    sampling: Sampling,
    warn: Callable[[str], None],
) -> tuple[PotentialParameters, bool]:
    """The potential for however many vehicles there are; where there is no network for them, the fixed triple (ours).

    Parameters
    ----------
    s, v : (n-1,) gaps [m] and (n,) speeds [m/s], n >= 1
    constants : of the model
    request, weights, sampling : as `choose_potential` takes them
    networks : by number of vehicles
    warn : called with one sentence where the fallback is used

    Returns
    -------
    the potential, and whether a network's training domain holds the vehicles and the network was asked

    Raises
    ------
    ModelError : where a fixed triple is not feasible or a network is unreadable
    """
    network = networks.get(v.size)
    if request.old:
        return V_OLD, False
    if v.size == 1 or request.source is ParameterSource.FIXED:  # a lone vehicle meets no potential
        require_feasible(request.fixed, constants)
        return request.fixed, False
    if network is None:
        return _fallback(f"{v.size} vehicles, for which there is no network here", request, constants, warn), False
    reason = outside_domain(s, v, constants, network.domain, network.constants)
    if reason is not None:  # also where policy 2 has let vehicles leave the state space
        return _fallback(reason, request, constants, warn), False
    if request.source is ParameterSource.NETWORK:
        return project(network.evaluate(s, v), constants), True
    count, rounds = share_rollouts(request.rollouts)
    candidates, start = network.candidates(s, v, count), PlatoonState(s, v, constants)
    return best_by_rollout(start, candidates, weights, sampling, request.horizon, rounds), True
