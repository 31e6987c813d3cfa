"""Selectors of the potential: a fixed one, the network's answer, or the best of its candidates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from math import inf
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from ..errors import ModelError
from ..law.potential import BEST_FIXED, V_OLD, PotentialParameters
from ..parameters import ObjectiveWeights, PlatoonParameters
from ..sampling.policy import Sampling
from ..state import PlatoonState, StartDomain
from ..validate import validate
from .feasible import project, require_feasible
from .network import ParameterNetwork
from .rollout import best_by_rollout, share_rollouts


class Selection(NamedTuple):
    """A potential, and how it came about.

    Attributes
    ----------
    potential : to run with
    by_network : whether it is a network's answer, or the best of its candidates
    warning : the sentence that says why the answer is not the one asked for, None where it is
    """

    potential: PotentialParameters
    by_network: bool = False
    warning: str | None = None


@runtime_checkable
class Selector(Protocol):
    """Selects the potential for a start (ours)."""

    def select(self, s: ArrayLike, v: ArrayLike, constants: PlatoonParameters) -> Selection:
        """The potential for n >= 1 vehicles.

        Parameters
        ----------
        s, v : (n-1,) spacings [m] and (n,) speeds [m/s]
        constants : of the model

        Raises
        ------
        ModelError : where a fixed triple is not feasible or a network is unreadable
        """


@dataclass(frozen=True)
class Old:
    """V_old for any start (paper)."""

    def select(self, s: ArrayLike, v: ArrayLike, constants: PlatoonParameters) -> Selection:
        """See `Selector.select`."""
        return Selection(V_OLD)


@dataclass(frozen=True)
class Fixed:
    """One feasible triple for any start.

    Attributes
    ----------
    triple : alpha, r, p
    """

    triple: PotentialParameters = BEST_FIXED

    def select(self, s: ArrayLike, v: ArrayLike, constants: PlatoonParameters) -> Selection:
        """See `Selector.select`."""
        require_feasible(self.triple, constants)
        return Selection(self.triple)


@dataclass(frozen=True)
class FromNetwork:
    """The network's answer, projected into the feasible set (paper, section IV, except the fallback, which is ours).

    Attributes
    ----------
    networks : by number of vehicles
    fallback : for a lone vehicle, which meets no potential, and wherever a network's answer does not hold
    """

    networks: Mapping[int, ParameterNetwork]
    fallback: PotentialParameters = BEST_FIXED

    def select(self, s: ArrayLike, v: ArrayLike, constants: PlatoonParameters) -> Selection:
        """See `Selector.select`."""
        n = np.size(v)
        if n == 1:
            return Fixed(self.fallback).select(s, v, constants)
        network = self.networks.get(n)
        reason = why_not(network, s, v, constants)
        if network is not None and reason is None:
            return Selection(self._asked(network, s, v, constants), by_network=True)
        require_feasible(self.fallback, constants)
        triple = self.fallback
        warning = str(ModelError("fallback", reason, triple.alpha, triple.r, triple.p))
        return Selection(triple, warning=warning)

    def _asked(
        self, network: ParameterNetwork, s: ArrayLike, v: ArrayLike, constants: PlatoonParameters
    ) -> PotentialParameters:
        return project(network.evaluate(s, v), constants)


@dataclass(frozen=True)
class BestOfRollouts(FromNetwork):
    """The best of the network's candidates, each rolled out from the vehicles' state (ours).

    Attributes
    ----------
    networks, fallback : as of `FromNetwork`
    rollouts : most of them
    horizon : how far ahead they look [s]
    weights, sampling : what they are judged by
    """

    rollouts: int = 16
    horizon: float = 20.0
    weights: ObjectiveWeights = field(default_factory=ObjectiveWeights)
    sampling: Sampling = field(default_factory=Sampling)

    def _asked(
        self, network: ParameterNetwork, s: ArrayLike, v: ArrayLike, constants: PlatoonParameters
    ) -> PotentialParameters:
        count, rounds = share_rollouts(self.rollouts)
        candidates, start = network.candidates(s, v, count), PlatoonState(s, v, constants)
        return best_by_rollout(start, candidates, self.weights, self.sampling, self.horizon, rounds)


def outside_domain(
    s: ArrayLike, v: ArrayLike, constants: PlatoonParameters, domain: StartDomain, trained_with: PlatoonParameters
) -> str | None:
    """Why a network's answer does not hold for a start, or None if it does (ours).

    Parameters
    ----------
    s, v : (n-1,) spacings [m] and (n,) speeds [m/s]
    constants : of the model
    domain, trained_with : starts and constants that the network was trained on

    Returns
    -------
    the reason, to go into a sentence
    """
    if constants != trained_with:
        return "other constants than the network was trained with"
    if not domain.contains(s, v):  # also where policy 2 has let vehicles leave the state space
        return "spacings or speeds outside the network's training domain"
    return None


class Trained(Protocol):
    """What a network was trained on: a `ParameterNetwork`, or what somebody has noted of one."""

    @property
    def domain(self) -> StartDomain:
        """The starts."""

    @property
    def constants(self) -> PlatoonParameters:
        """The constants of the model."""


def lies_in_domain(trained: Mapping[int, Trained], s: ArrayLike, v: ArrayLike, constants: PlatoonParameters) -> bool:
    """Whether there is a network for so many vehicles, trained on such starts with these constants (ours).

    Parameters
    ----------
    trained : by number of vehicles
    s, v, constants : as for `Selector.select`
    """
    known = trained.get(np.size(v))
    return known is not None and outside_domain(s, v, constants, known.domain, known.constants) is None


def why_not(network: ParameterNetwork | None, s: ArrayLike, v: ArrayLike, constants: PlatoonParameters) -> str | None:
    """Why there is no network's answer for these vehicles, or None if there is.

    Parameters
    ----------
    network : for this number of vehicles, None if there is none
    s, v, constants : as for `Selector.select`
    """
    if network is None:
        return f"{np.size(v)} vehicles, for which there is no network here"
    return outside_domain(s, v, constants, network.domain, network.constants)


class ParameterSource(IntEnum):
    """Where alpha, r, p come from."""

    NETWORK = 1
    FIXED = 2
    ROLLOUT = 3


@dataclass(frozen=True)
class Request:
    """What the user of an FMU requests.

    Attributes
    ----------
    old : V_old instead of V_new
    source : where alpha, r, p come from
    fixed : the triple for source FIXED, and the fallback of the others
    rollouts : most rollouts with source ROLLOUT
    horizon : of the rollouts [s]
    """

    old: bool = False
    source: ParameterSource = ParameterSource.NETWORK
    fixed: PotentialParameters = BEST_FIXED
    rollouts: int = 16
    horizon: float = 20.0

    def checked(self) -> Request:
        """The same.

        Raises
        ------
        ModelError : where the horizon is not positive and finite, or the fixed triple not finite
        """
        validate(self.fixed)
        if not 0 < self.horizon < inf:
            raise ModelError("horizon", self.horizon)
        return self

    @property
    def asks_network(self) -> bool:
        """Whether a network is wanted."""
        return not self.old and self.source != ParameterSource.FIXED


def selector_for(
    request: Request, networks: Mapping[int, ParameterNetwork], weights: ObjectiveWeights, sampling: Sampling
) -> Selector:
    """The selector for a request.

    Parameters
    ----------
    request : what is asked for
    networks : by number of vehicles
    weights, sampling : what rollouts are judged by

    Raises
    ------
    ModelError : where the horizon is not positive and finite, or the fixed triple not finite
    """
    request.checked()
    if request.old:
        return Old()
    if request.source == ParameterSource.FIXED:
        return Fixed(request.fixed)
    if request.source == ParameterSource.NETWORK:
        return FromNetwork(networks, request.fixed)
    return BestOfRollouts(networks, request.fixed, request.rollouts, request.horizon, weights, sampling)


def select_for(
    start: PlatoonState,
    request: Request,
    network: ParameterNetwork | None,
    weights: ObjectiveWeights,
    sampling: Sampling,
) -> Selection:
    """The potential for a start, where the one network there is serves this number of vehicles.

    Parameters
    ----------
    start : initial state
    request : what is asked for
    network : for this number of vehicles, None if there is none
    weights, sampling : what rollouts are judged by

    Raises
    ------
    ModelError : as `Selector.select` does, and where a network is asked for and there is none
    """
    n = start.v.size
    if network is None and request.asks_network:
        raise ModelError("no_network", n)
    networks = {} if network is None else {n: network}
    return selector_for(request, networks, weights, sampling).select(start.s, start.v, start.constants)
