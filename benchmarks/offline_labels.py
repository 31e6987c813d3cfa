"""Why the paper's MSE of 0.0012 says little: python benchmarks/offline_labels.py

Labels from a local solver begun at one fixed guess stay near that guess, so even a constant fits them well; global
optima jump about as the start moves.  The variance of the labels, scaled to [0, 1] by their bounds, is the MSE of the
best constant.
"""

from __future__ import annotations

if __name__ == "__main__":  # before the imports that take time
    from psp_cli.interrupt import install

    install("offline_labels.py")

import argparse
import json
from pathlib import Path

import numpy as np

from psp_model import StartDomain
from psp_model.offline.evaluate import projected
from psp_model.offline.ipopt import LocalSolver
from psp_model.offline.recipes import output_scaling
from psp_model.selection.search.engine import Engine, Problem
from psp_model.selection.search.search import Search
from psp_model.whole_file import write_whole

GUESS = (1e-3, 11.0, 5.5)


def main() -> dict[str, object]:
    """Measure, print and save."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--starts", type=int, default=40)
    options = parser.parse_args()
    problem = Problem()
    s, v = StartDomain().draw(np.random.default_rng(12), 7, options.starts)
    starts = np.concatenate([s, v]).T
    local = LocalSolver(problem)
    labels = {
        "local solver from one guess": np.array([local.solve(start, [GUESS])[0] for start in starts]),
        "global search": Search(problem).solve(starts).triples,
    }
    exact, (_, scale) = Engine(problem, "double"), output_scaling(problem)
    result: dict[str, object] = {"starts": options.starts, "guess": GUESS, "paper_mse": 0.0012}
    J = {
        name: exact.costs(starts, np.arange(len(starts)), projected(found, problem.constants))[0]
        for name, found in labels.items()
    }
    for name, found in labels.items():
        variance = (found / scale).var(axis=0)
        result[name] = {
            "mse_of_best_constant": {"alpha": variance[0], "r": variance[1], "p": variance[2], "mean": variance.mean()},
            "J_above_global_mean": float((J[name] / J["global search"] - 1.0).mean()),
        }
    path = Path(__file__).parent / "results" / "offline_labels.json"
    write_whole(path, json.dumps(result, indent=1) + "\n")
    print(json.dumps(result, indent=1))
    return result


if __name__ == "__main__":
    main()
