"""Runs of the platoon without FMI."""

from __future__ import annotations

from math import inf
from typing import Any

import numpy as np

from .errors import ModelError
from .law.controller import MakeController, PaperLaw
from .law.potential import Potential
from .objective import HORIZON
from .parameters import ObjectiveWeights
from .platoon import SampledPlatoon
from .run import Run
from .sampling.clock import locate
from .sampling.hold import IDEAL, Plant
from .sampling.policy import Sampling
from .state import PlatoonState


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
