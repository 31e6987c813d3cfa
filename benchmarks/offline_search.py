"""How close the search comes to a brute-force fine grid with refinement: python benchmarks/offline_search.py

The brute force shares the rollouts with the search and nothing else: a regular grid in alpha, r and p, the slope limit
checked by the model's own branch and bound, and random refinement around the best points.
"""

from __future__ import annotations

if __name__ == "__main__":  # before the imports that take time
    from psp_cli.interrupt import install

    install("offline_search.py")

import argparse
import json
from pathlib import Path

import numpy as np

from psp_model import PlatoonParameters, PotentialParameters, StartDomain
from psp_model.selection.feasible import slope_within_limit
from psp_model.selection.search.engine import Engine, Problem
from psp_model.selection.search.search import Search
from psp_model.whole_file import write_whole

ALPHAS = (1e-3, 1.5e-3, 2.5e-3, 5e-3, 1e-2)
R = np.arange(6.0, 17.001, 0.05)
P = np.arange(3.0, 7.6, 0.1)
KEPT, TRIES, ROUNDS = 20, 64, 4


def feasible_grid() -> np.ndarray:
    """(N, 3) feasible points of the regular grid."""
    constants, points = PlatoonParameters(), []
    for alpha in ALPHAS:
        for r in R:
            for p in P:
                if not slope_within_limit(PotentialParameters(alpha, float(r), float(p)), constants):
                    break  # a larger p is steeper
                points.append((alpha, r, p))
    return np.array(points)


def brute_force(
    start: np.ndarray, points: np.ndarray, engine: Engine, exact: Engine, rng: np.random.Generator
) -> float:
    """The best J found for one start."""

    def costs(triples: np.ndarray) -> np.ndarray:
        return engine.costs(start[None], np.zeros(len(triples), int), triples)[0]

    J = costs(points)
    order = np.argsort(J)[:KEPT]
    best, J = points[order], J[order].astype(float)
    constants, spread = PlatoonParameters(), np.array([0.2, 0.04, 0.08])
    for number in range(ROUNDS):
        noise = rng.standard_normal((KEPT, TRIES, 3)) * spread * 0.4**number
        tried = best[:, None] * np.array([1, 0, 0]) * np.exp(noise * [1, 0, 0]) + (best[:, None] + noise) * [0, 1, 1]
        tried = np.clip(tried, [1e-3, 5.5, 3.0], [1e-1, 17.0, 9.0])
        found = costs(tried.reshape(-1, 3)).reshape(KEPT, TRIES)
        for k in range(KEPT):
            for j in np.argsort(found[k])[:8]:  # the best of the feasible ones
                if found[k, j] < J[k] and slope_within_limit(PotentialParameters(*map(float, tried[k, j])), constants):
                    best[k], J[k] = tried[k, j], found[k, j]
                    break
    return float(exact.costs(start[None], np.zeros(KEPT, int), best)[0].min())


def main() -> dict[str, float]:
    """Compare, print and save."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--starts", type=int, default=100)
    parser.add_argument("--seed", type=int, default=100)
    parser.add_argument("--output", type=Path, default=Path(__file__).parent / "results" / "offline_search.json")
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    s, v = StartDomain().draw(rng, 7, options.starts)
    starts, problem = np.concatenate([s, v]).T, Problem()
    found = Search(problem).solve(starts)
    points, engine, exact = feasible_grid(), Engine(problem), Engine(problem, "double")
    reference = np.array([brute_force(start, points, engine, exact, rng) for start in starts])
    excess = found.J / reference - 1.0
    result = {
        "starts": options.starts,
        "seed": options.seed,
        "brute_force_points": len(points) + KEPT * TRIES * ROUNDS,
        "excess_mean": float(excess.mean()),
        "excess_p95": float(np.percentile(excess, 95)),
        "excess_worst": float(excess.max()),
        "excess_best": float(excess.min()),
        "share_search_is_better": float((excess < 0).mean()),
    }
    write_whole(options.output, json.dumps(result, indent=1) + "\n")
    print(json.dumps(result, indent=1))
    return result


if __name__ == "__main__":
    main()
