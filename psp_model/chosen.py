"""What `simulate` and `simulate_many` take for a potential: one, a selector, or a word."""

from __future__ import annotations

from typing import Literal, TypeGuard

from .errors import ModelError
from .law.potential import Potential
from .parameters import ObjectiveWeights
from .sampling.policy import Sampling
from .selection.network import ParameterNetwork, network_path, open_network
from .selection.selectors import BestOfRollouts, Fixed, FromNetwork, Old, Selector
from .state import PlatoonState, shortened

Word = Literal["network", "fixed", "old", "rollouts"]
"""network: this project's own network for the number of vehicles; fixed: `BEST_FIXED`; old: `V_OLD`; rollouts: the best
of that network's candidates, each rolled out from the start."""

WORDS = ("network", "fixed", "old", "rollouts")


def project_networks(vehicles: int) -> dict[int, ParameterNetwork]:
    """This project's own network for n vehicles, by n; empty where there is none.

    Parameters
    ----------
    vehicles : n

    Raises
    ------
    ModelError : where the installation has lost its networks
    """
    from .installed.files import networks_folder  # here, because FMUs carry this module without that room

    path = network_path(vehicles, networks_folder())
    return {} if path is None else {vehicles: open_network(path)}


def selector_of(asked: object, vehicles: int, weights: ObjectiveWeights, sampling: Sampling) -> Selector:
    """The selector that a word stands for; a selector stands for itself.

    Parameters
    ----------
    asked : selector or word
    vehicles : n
    weights, sampling : what rollouts are judged by

    Raises
    ------
    ModelError : where it is neither
    """
    if asked == "network":
        return FromNetwork(project_networks(vehicles))
    if asked == "rollouts":
        return BestOfRollouts(project_networks(vehicles), weights=weights, sampling=sampling)
    if asked == "fixed":
        return Fixed()
    if asked == "old":
        return Old()
    if isinstance(asked, Selector) and not isinstance(asked, type):
        return asked
    raise ModelError("potential", shortened(repr(asked)), f"{', '.join(WORDS[:-1])} and {WORDS[-1]}")


def potential_for(
    start: PlatoonState, asked: Potential | Selector | Word, weights: ObjectiveWeights, sampling: Sampling
) -> tuple[Potential, str | None]:
    """The potential for a start, and the sentence that says why it is not the one asked for, None where it is.

    Parameters
    ----------
    start : initial state, inside the state space
    asked : potential, selector or word
    weights, sampling : what rollouts are judged by

    Raises
    ------
    ModelError : where it is none of these, a fixed triple not feasible, or a network unreadable
    """
    if is_potential(asked):
        return asked, None
    selector = selector_of(asked, start.v.size, weights, sampling)
    selection = selector.select(start.s, start.v, start.constants)
    return selection.potential, selection.warning


def is_potential(asked: object) -> TypeGuard[Potential]:
    """Whether this is a potential.

    Parameters
    ----------
    asked : anything
    """
    return isinstance(asked, Potential) and not isinstance(asked, type)
