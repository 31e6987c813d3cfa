"""Native against Python FMU from 50 random starts over 20 s: python benchmarks/native_agreement.py [STARTS]

Both potentials, all sources of alpha, r, p; all outputs at every sampling instant; the largest difference of each case.
"""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from fmpy import extract, instantiate_fmu, read_model_description

from build_fmu import main as build
from psp_model import StartDomain

CASES = {  # potential, parameter_source
    "V_old": (1, 2),
    "V_new, given parameters": (2, 2),
    "V_new, network": (2, 1),
    "V_new, network and rollouts": (2, 3),
}


def load(path: Path) -> tuple[Any, Any]:
    """An instance and the model description."""
    folder = extract(str(path))
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


def main(starts: int = 50) -> dict[str, float]:
    """Largest absolute difference of any output, by case."""
    worst = dict.fromkeys(CASES, 0.0)
    with TemporaryDirectory() as folder:
        for runtime in ("python", "native"):
            build(["--runtime", runtime, "--output", folder])
        both = [load(Path(folder, f"{name}.fmu")) for name in ("PspPlatoon", "PspPlatoonNative")]
        rng = np.random.default_rng(2026)
        for _ in range(starts):
            s, v = StartDomain().draw(rng, 7, 1)
            real = {f"s_start[{i}]": float(gap) for i, gap in enumerate(s[:, 0], start=2)}
            real |= {f"v_start[{i}]": float(speed) for i, speed in enumerate(v[:, 0], start=1)}
            for case, (potential, source) in CASES.items():
                integer = {"potential": potential, "parameter_source": source}
                reference, seen = (run(*each, real, integer) for each in both)
                worst[case] = max(worst[case], float(np.abs(reference - seen).max()))
    for case, value in worst.items():
        print(f"{case:30} {value:.2e}")
    return worst


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
