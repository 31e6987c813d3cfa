"""Time of `parameter_source` 3 at initialisation, by rollouts: python benchmarks/offline_initialisation.py"""

from __future__ import annotations

if __name__ == "__main__":  # before the imports that take time
    from psp_cli.interrupt import install

    install("offline_initialisation.py")

import json
import time
from pathlib import Path

import numpy as np

from psp_model import ObjectiveWeights, PlatoonState, Sampling, StartDomain
from psp_model.selection.network import ParameterNetwork
from psp_model.selection.rollout import best_by_rollout, share_rollouts
from psp_model.whole_file import write_whole

COUNTS = (1, 2, 4, 8, 16, 32)
REPEATS = 5


def main() -> dict[str, float]:
    """Measure in NumPy, print and save; the native FMU is measured by benchmarks/native*."""
    network = ParameterNetwork(Path(__file__).parents[1] / "onnx" / "platoon_7.onnx")
    s, v = StartDomain().draw(np.random.default_rng(3), 7, 1)
    start = PlatoonState(s[:, 0], v[:, 0])
    network.evaluate(start.s, start.v)  # loads
    result = {}
    for count in COUNTS:
        seconds = []
        for _ in range(REPEATS):
            begin = time.perf_counter()
            first, rounds = share_rollouts(count)
            candidates = network.candidates(start.s, start.v, first)
            best_by_rollout(start, candidates, ObjectiveWeights(), Sampling(), 20.0, rounds)
            seconds.append(time.perf_counter() - begin)
        result[f"{count} rollouts"] = min(seconds)
        print(f"{count:3d} rollouts {1e3 * min(seconds):8.1f} ms")
    path = Path(__file__).parent / "results" / "offline_initialisation.json"
    write_whole(path, json.dumps({"seconds_numpy": result}, indent=1) + "\n")
    return result


if __name__ == "__main__":
    main()
