"""What the explorer shows for one position of its sliders; knows nothing of the page."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..errors import ModelError
from ..figures import Figure
from ..law.potential import V_OLD, PotentialParameters
from ..parameters import HILL_WIDTH, P_MAX, P_MIN, PlatoonParameters
from ..run import Run
from ..sampling.policy import Lemma1Policy, Sampling
from ..selection.feasible import max_slope, project, require_feasible
from ..simulate import simulate
from ..state import PlatoonState
from ..validate import validate
from .curves import Curve, curve


@dataclass(frozen=True)
class Choice:
    """One position of the sliders.

    Attributes
    ----------
    old : V_old instead of V_new
    alpha, r, p : parameters of V_new [1], [m], [1]
    s : n-1 spacings at the start [m]
    v : n speeds at the start [m/s]
    """

    old: bool
    alpha: float
    r: float
    p: float
    s: tuple[float, ...]
    v: tuple[float, ...]

    @property
    def shape(self) -> PotentialParameters:
        """The potential."""
        return V_OLD if self.old else PotentialParameters(self.alpha, self.r, self.p)


@dataclass(frozen=True, eq=False)
class Response:
    """What the model makes of a choice.

    Attributes
    ----------
    run : the run; None where the start is refused
    curve : V and V'
    slope : max |V_new'| on the hill [m/s2]; 0 for V_old, which has none
    problem : the model's sentence where start or potential is not allowed, else ""
    figures : the numbers shown
    """

    run: Run | None
    curve: Curve
    slope: float
    problem: str
    figures: tuple[Figure, ...]


def respond(choice: Choice, constants: PlatoonParameters, duration: float = 20.0) -> Response:
    """Run the model for a choice.

    A potential outside the feasible set is run all the same, and the problem said: that is what exploring is for.

    Parameters
    ----------
    choice : the sliders
    constants : of the model
    duration : of the run [s]
    """
    shape, problem = choice.shape, ""
    line = curve(shape, constants, points=481)
    slope = 0.0 if choice.old else max_slope(shape, constants)
    try:
        start = validate(PlatoonState(choice.s, choice.v, constants))
    except ModelError as error:
        return Response(None, line, slope, str(error), ())
    if not choice.old:
        try:
            require_feasible(shape, constants)
        except ModelError as error:
            problem = str(error)
    run = simulate(start, shape, sampling=Sampling(policy=Lemma1Policy.WARN), duration=duration)
    return Response(run, line, slope, problem, tuple(run.figures()))


@lru_cache(maxsize=64)
def feasible_edge(
    alpha: float, constants: PlatoonParameters, points: int = 49
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The largest feasible p for each r, at one alpha.

    Parameters
    ----------
    alpha : scale of the potential [1]
    constants : of the model
    points : R

    Returns
    -------
    r, p : (R,) arrays [m], [1]; p is NaN where no p is feasible
    """
    r = np.linspace(constants.L, constants.lam - HILL_WIDTH, points + 1)[1:]
    p = np.full(points, np.nan)
    for k, place in enumerate(r.tolist()):
        found = _projected(PotentialParameters(alpha, place, P_MAX), constants)
        if found is not None and found.r == place and found.alpha == alpha and found.p >= P_MIN:
            p[k] = found.p
    return r, p


def _projected(shape: PotentialParameters, constants: PlatoonParameters) -> PotentialParameters | None:
    try:
        return project(shape, constants)
    except ModelError:
        return None
