"""A run together with everything it was made from, and the figures it is judged by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..figures import Figure
from ..law.cooperation import PAPERS_LAW, Cooperation, contact_spacing
from ..law.potential import PotentialParameters
from ..objective import HORIZON
from ..parameters import ObjectiveWeights
from ..run import Run
from ..sampling.policy import Sampling
from ..selection.network import ParameterNetwork
from ..selection.selectors import ParameterSource, Request, select_for
from ..simulate import simulate
from ..state import PlatoonState
from .certificate import Certificate, certify, extended_law


@dataclass(frozen=True, eq=False)
class Setup:
    """What a run is made from.

    Attributes
    ----------
    start : initial state
    request : where alpha, r, p come from
    weights : of the objective
    sampling : period and policy
    no_network : the fixed triple is used because there is no network for this number of vehicles, not by request
    cooperation : parameters of the law; the paper's by default
    """

    start: PlatoonState
    request: Request
    weights: ObjectiveWeights
    sampling: Sampling
    no_network: bool = False
    cooperation: Cooperation = PAPERS_LAW


@dataclass(frozen=True, eq=False)
class Case:
    """A run with what it was made from.

    Attributes
    ----------
    name : what it is called in pictures and tables
    setup : what was asked for
    shape : the potential it ran with
    origin : where alpha, r, p came from, in words
    run : what came out, at every sampling instant
    warnings : sentences of the model
    """

    name: str
    setup: Setup
    shape: PotentialParameters
    origin: str
    run: Run
    warnings: tuple[str, ...] = ()

    @property
    def certificate(self) -> Certificate:
        """What certifies T along the run."""
        setup = self.setup
        certificate = setup.sampling.certificate
        return certify(self.run, setup.start.constants, setup.sampling.T, setup.cooperation, certificate)


def run_case(name: str, setup: Setup, network: ParameterNetwork | None, duration: float = HORIZON) -> Case:
    """Choose the potential and run the platoon.

    Parameters
    ----------
    name : what to call it
    setup : what to run
    network : for this number of vehicles, None if there is none
    duration : [s]

    Raises
    ------
    ModelError : as `select_for` and `simulate` do
    """
    start, request = setup.start, setup.request
    seen = PlatoonState(contact_spacing(start.s, setup.cooperation, start.constants), start.v, start.constants)
    selection = select_for(seen, request, network, setup.weights, setup.sampling)
    shape, fell_back = selection.potential, selection.warning is not None
    origin = origin_of(request, network, fell_back)
    if setup.no_network and not request.old:
        origin = f"the fixed triple, because there is no network for {start.v.size} vehicles"
    law = extended_law(setup.cooperation, setup.sampling.T)
    run = simulate(start, shape, weights=setup.weights, sampling=setup.sampling, duration=duration, controller=law)
    warnings = (selection.warning,) if selection.warning else ()
    return Case(name, setup, shape, origin, run, warnings)


def origin_of(request: Request, network: ParameterNetwork | None, fell_back: bool) -> str:
    """Where alpha, r, p came from, in words.

    Parameters
    ----------
    request : what was asked for
    network : what was asked
    fell_back : whether the network could not be used
    """
    if request.old:
        return "V_old: no hill"
    if request.source is ParameterSource.FIXED:
        return "alpha_fixed, r_fixed, p_fixed"
    if fell_back:
        return "fixed: the fallback, because the network cannot be used here"
    assert network is not None  # select_for has raised otherwise
    if request.source is ParameterSource.NETWORK:
        return f"network {network.path.name}, from the initial state"
    return f"network {network.path.name}, best of {request.rollouts} rollouts from the initial state"


def without_repetitions(cases: Sequence[Case]) -> tuple[list[Case], dict[str, str]]:
    """The cases that differ, and of each other one why it repeats an earlier one.

    Parameters
    ----------
    cases : in the order of the table

    Returns
    -------
    the cases to show, and by the name of each other one the reason
    """
    shown: list[Case] = []
    repeated: dict[str, str] = {}
    for case in cases:
        first = next((one for one in shown if _same(one, case)), None)
        if first is None:
            shown.append(case)
            continue
        why = case.warnings[0] if case.warnings else f"alpha, r, p are the same ({case.origin})"
        repeated[case.name] = f"it would repeat {first.name}: {why}"
    return shown, repeated


def _same(one: Case, other: Case) -> bool:
    """Whether two cases are the same run: equal starts under equal potentials give equal runs."""
    run, another = one.run, other.run
    return (
        one.shape == other.shape
        and one.setup.request.old == other.setup.request.old
        and one.setup.weights == other.setup.weights
        and one.setup.start.constants == other.setup.start.constants
        and repr(one.setup.cooperation) == repr(other.setup.cooperation)
        and all(np.array_equal(getattr(run, name), getattr(another, name)) for name in ("time", "x", "v", "a", "T_max"))
    )


def comparison(setup: Setup, network: ParameterNetwork | None) -> dict[str, Setup]:
    """The four ways to choose a potential, from the same start; without a network, the two that need none.

    Parameters
    ----------
    setup : start, weights and sampling of all; its request gives the fixed triple and the number of rollouts
    network : for this number of vehicles, None if there is none
    """
    old, fixed = replace(setup.request, old=True), replace(setup.request, old=False, source=ParameterSource.FIXED)
    requests = {"V_old": old, "V_new, fixed": fixed}
    if network is not None:
        requests["V_new, network"] = replace(fixed, source=ParameterSource.NETWORK)
        requests["V_new, network and rollout"] = replace(fixed, source=ParameterSource.ROLLOUT)
    return {name: replace(setup, request=request, no_network=False) for name, request in requests.items()}


def figures(case: Case) -> list[Figure]:
    """The numbers that runs are compared by, and the parameters they ran with.

    Parameters
    ----------
    case : the run
    """
    shape = case.shape
    parameters = [Figure("alpha", "1", shape.alpha), Figure("r", "m", shape.r), Figure("p", "1", shape.p)]
    return case.run.figures() + parameters
