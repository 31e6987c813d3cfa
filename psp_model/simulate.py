"""A run of the platoon without FMI."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import ModelError
from .law.controller import MakeController, PaperLaw
from .law.potential import Potential
from .objective import HORIZON
from .parameters import ObjectiveWeights
from .platoon import SampledPlatoon
from .sampling.clock import locate
from .sampling.hold import IDEAL, Plant
from .sampling.policy import Sampling
from .state import PlatoonState


@dataclass(frozen=True, eq=False)
class Run:
    """What a run put out, K times along the first axis.

    Attributes
    ----------
    time : (K,) [s]
    x, v, a : (K, n) positions [m], speeds [m/s], accelerations [m/s2]
    s : (K, n-1) gaps [m]
    T_max : (K,) Lemma 1's bound at the last sampling instant [s]
    cost : (K, 2) running terms of J, of acceleration and of gaps
    violations : sampling instants at which T was not certified
    """

    time: NDArray[np.float64]
    x: NDArray[np.float64]
    s: NDArray[np.float64]
    v: NDArray[np.float64]
    a: NDArray[np.float64]
    T_max: NDArray[np.float64]
    cost: NDArray[np.float64]
    violations: int

    @property
    def J(self) -> float:
        """The objective at the end of the run."""
        return float(self.cost[-1].sum())


def simulate(
    start: PlatoonState,
    shape: Potential,
    *,
    weights: ObjectiveWeights | None = None,
    sampling: Sampling | None = None,
    duration: float = HORIZON,
    output_step: float | None = None,
    controller: MakeController = PaperLaw,
    plant: Plant[Any] = IDEAL,
) -> Run:
    """Run a platoon from its initial state.

    Parameters
    ----------
    start : initial state
    shape : the potential
    weights : of the objective; the paper's by default
    sampling : period and policy; T = 0.01 s and errors by default
    duration : [s]
    output_step : time between two outputs [s]; the sampling period by default
    controller : makes the controller from potential and constants; the paper's law by default
    plant : what is driven; double integrators by default

    Returns
    -------
    Run

    Raises
    ------
    ModelError : as `SampledPlatoon` does, and where duration or output_step makes no sense
    """
    sampling = sampling or Sampling()
    step = sampling.T if output_step is None else output_step
    if not 0 <= duration < inf:
        raise ModelError("duration", duration)
    if not 0 < step < inf:
        raise ModelError("output_step", step)
    platoon = SampledPlatoon.begin(start, shape, weights, sampling, controller=controller, plant=plant)
    times = step * np.arange(locate(duration, step)[0] + 1, dtype=np.float64)
    rows, T_max = [], []
    for time in times:
        at = locate(float(time), sampling.T)
        platoon.advance_to(*at)
        rows.append(platoon.observe(*at))
        T_max.append(platoon.now.T_max)
    columns = {name: np.array([getattr(row, name) for row in rows]) for name in ("x", "s", "v", "a", "cost")}
    return Run(time=times, T_max=np.array(T_max), violations=platoon.now.violations, **columns)
