"""Runs of the platoon without FMI."""

from __future__ import annotations

from math import inf
from typing import Any

import numpy as np

from .chosen import Word, potential_for
from .errors import ModelError
from .law.controller import MakeController, Memory
from .law.cooperation import PAPERS_LAW, Cooperation
from .law.potential import Potential
from .objective import HORIZON
from .parameters import ObjectiveWeights
from .platoon import SampledPlatoon
from .run import Run
from .sampling.clock import locate
from .sampling.hold import Plant, Vehicles
from .sampling.policy import Sampling
from .selection.selectors import Selector
from .state import Start, as_state, read_only
from .validate import validate, validate_start

POINTS = Cooperation(length=0.0)  # the controller knows lengths, and is made later


def simulate(
    start: Start,
    potential: Potential | Selector | Word,
    *,
    weights: ObjectiveWeights | None = None,
    sampling: Sampling | None = None,
    duration: float = HORIZON,
    output_step: float | None = None,
    controller: MakeController[Memory] | None = None,
    plant: Plant[Vehicles] | None = None,
) -> Run:
    """Run a platoon from its initial state.

    Parameters
    ----------
    start : initial state, or a pair of (n-1,) spacings [m] and (n,) speeds [m/s], lists or arrays
    potential : potential; or a selector, or one of the words "network" (this project's own for n vehicles; outside its
        domain the fallback, with a warning), "fixed" (`BEST_FIXED`), "old" (`V_OLD`) and "rollouts" (the best of the
        network's candidates, each rolled out from the start)
    weights : of the objective; the paper's by default
    sampling : period and policy; T = 0.01 s and errors by default
    duration : [s]
    output_step : time between two outputs [s]; the sampling period by default
    controller : makes the controller from potential and constants; the paper's law by default
    plant : what is driven; double integrators by default

    Returns
    -------
    Run, with the potential in use and all warnings

    Raises
    ------
    ModelError : as `SampledPlatoon` does, and where duration or output_step makes no sense
    """
    weights, sampling = validate(weights or ObjectiveWeights()), validate(sampling or Sampling())
    step = sampling.T if output_step is None else output_step
    if not 0 <= duration < inf:
        raise ModelError("duration", duration)
    if not 0 < step < inf:
        raise ModelError("output_step", step)
    start = as_state(start)
    validate_start(start, PAPERS_LAW if controller is None else POINTS)
    in_use, warning = potential_for(start, potential, weights, sampling)
    warnings = [] if warning is None else [warning]
    platoon = SampledPlatoon.begin(
        start, in_use, weights, sampling, warnings.append, controller=controller, plant=plant
    )
    times = step * np.arange(locate(duration, step)[0] + 1, dtype=np.float64)
    rows, T_max = [], []
    for time in times:
        at = locate(float(time), sampling.T)
        platoon.advance_to(*at)
        rows.append(platoon.observe(*at))
        T_max.append(platoon.now.T_max)
    columns: dict[str, Any] = {
        name: read_only([getattr(row, name) for row in rows]) for name in ("x", "s", "v", "a", "cost")
    }
    told: dict[str, Any] = {"potential": in_use, "warnings": tuple(warnings)}
    return Run(time=read_only(times), T_max=read_only(T_max), violations=platoon.now.violations, **columns, **told)
