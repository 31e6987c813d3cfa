"""Native against Python FMU from random starts over 20 s: the largest difference of any output at any sampling instant.

Both potentials, all sources of alpha, r, p.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from fmpy import instantiate_fmu, read_model_description

from psp_model import StartDomain

from .fmus import fmu
from .registry import Context
from .rounds import Row

CASES = {  # potential, parameter_source
    "V_old": (1, 2),
    "V_new, given parameters": (2, 2),
    "V_new, network": (2, 1),
    "V_new, network and rollouts": (2, 3),
}


def load(folder: str) -> tuple[Any, Any]:
    """An instance and the model description."""
    model = read_model_description(folder)
    return instantiate_fmu(folder, model, "CoSimulation"), model


def run(slave: Any, model: Any, real: dict[str, float], integer: dict[str, int], steps: int = 2000) -> Any:
    """All outputs at every sampling instant; the instance is reset at the end."""
    reference = {variable.name: variable.valueReference for variable in model.modelVariables}
    outputs = [variable.valueReference for variable in model.modelVariables if variable.causality == "output"]
    slave.setupExperiment(startTime=0.0)
    slave.setReal([reference[name] for name in real], list(real.values()))
    slave.setInteger([reference[name] for name in integer], list(integer.values()))
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    rows = [slave.getReal(outputs)]
    for k in range(steps):
        slave.doStep(k * 0.01, 0.01)
        rows.append(slave.getReal(outputs))
    slave.terminate()
    slave.reset()
    return np.array(rows)


def measure(context: Context) -> list[Row]:
    """A line per case."""
    starts = 1 if context.quick else 20
    worst = dict.fromkeys(CASES, 0.0)
    both = [load(fmu(kind, 7).folder) for kind in ("python", "native")]
    rng = np.random.default_rng(2026)
    for number in range(starts):
        if number % 5 == 0:
            context.say(f"start {number + 1} of {starts}")
        s, v = StartDomain().draw(rng, 7, 1)
        real = {f"s_start[{i}]": float(spacing) for i, spacing in enumerate(s[:, 0], start=2)}
        real |= {f"v_start[{i}]": float(speed) for i, speed in enumerate(v[:, 0], start=1)}
        for case, (potential, source) in CASES.items():
            integer = {"potential": potential, "parameter_source": source}
            reference, seen = (run(*each, real, integer) for each in both)
            worst[case] = max(worst[case], float(np.abs(reference - seen).max()))
    size, peer = f"{starts} starts, 20 s", "Python FMU"
    return [
        Row(f"native FMU, {case}: largest difference", size, peer, value, None, "SI", None, None, None, starts)
        for case, value in worst.items()
    ]
