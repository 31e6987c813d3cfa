"""Speed and quality of the search beside a local solver and differential evolution: python benchmarks/offline_speed.py

All solve the same starts with the same objective (T = 0.01 s, 20 s) and feasible set.  CPU seconds are given beside
wall seconds, because they do not depend on what else the machine does.
"""

from __future__ import annotations

if __name__ == "__main__":  # before the imports that take time
    from psp_cli.interrupt import install

    install("offline_speed.py")

import argparse
import json
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from psp_model import PlatoonParameters, PotentialParameters, StartDomain, project
from psp_model.offline.ipopt import LocalSolver
from psp_model.selection.search.engine import Engine, Problem
from psp_model.selection.search.search import Search
from psp_model.selection.search.slope_limit import SlopeLimit
from psp_model.whole_file import write_whole


def timed(work: Callable[[], Any]) -> tuple[Any, float, float]:
    """What `work` returns, its wall seconds and its CPU seconds."""
    wall, cpu = time.perf_counter(), time.process_time()
    found = work()
    return found, time.perf_counter() - wall, time.process_time() - cpu


def evolution(
    start: np.ndarray,
    problem: Problem,
    engine: Engine,
    limit: SlopeLimit,
    seed: int,
    population: int = 15,
    generations: int = 60,
) -> np.ndarray:
    """scipy's differential evolution over (log alpha, r, level of p), population by population; the best triple."""
    from scipy.optimize import differential_evolution

    def costs(places: np.ndarray) -> np.ndarray:
        triples, feasible = limit.triples(np.exp(places[0]), places[1], places[2])
        J = engine.costs(start[None], np.zeros(places.shape[1], int), triples)[0]
        return np.where(feasible, J, 1e3)

    bounds = [(np.log(1e-3), np.log(1e-1)), (5.96, 17.0), (0.0, 1.0)]
    options = {"vectorized": True, "updating": "deferred", "polish": False, "rng": seed}
    found = differential_evolution(costs, bounds, popsize=population, maxiter=generations, **options)
    return limit.triples(np.exp(found.x[0]), found.x[1], found.x[2])[0]


def judged(starts: np.ndarray, triples: np.ndarray, exact: Engine) -> np.ndarray:
    """J in float64 of each start's triple, projected."""
    shapes = [project(PotentialParameters(*map(float, row)), PlatoonParameters()) for row in triples]
    rows = np.array([(shape.alpha, shape.r, shape.p) for shape in shapes])
    return exact.costs(starts, np.arange(len(starts)), rows)[0]


def main() -> dict[str, Any]:
    """Measure, print and save."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--starts", type=int, default=100, help="for the search")
    parser.add_argument("--others", type=int, default=10, help="for the slow ones, out of these")
    parser.add_argument("--output", type=Path, default=Path(__file__).parent / "results" / "offline_speed.json")
    options = parser.parse_args()
    s, v = StartDomain().draw(np.random.default_rng(7), 7, options.starts)
    starts, problem = np.concatenate([s, v]).T, Problem()
    search, exact, engine = Search(problem), Engine(problem, "double"), Engine(problem)
    search.solve(starts[:1])  # compiles
    local = LocalSolver(problem)
    local.solve(starts[0], [(1e-3, 11.0, 5.5)])  # builds
    few = starts[: options.others]
    found, wall, cpu = timed(lambda: search.solve(starts))
    rows = {
        "search": {"starts": len(starts), "wall_s_per_start": wall / len(starts), "cpu_s_per_start": cpu / len(starts)}
    }
    best = found.J[: len(few)]
    works = {
        "ipopt_three_guesses": lambda: np.array([local.solve(start)[0] for start in few]),
        "differential_evolution": lambda: np.array(
            [evolution(x, problem, engine, search.limit, k) for k, x in enumerate(few)]
        ),
    }
    for name, work in works.items():
        triples, wall, cpu = timed(work)
        excess = judged(few, triples, exact) / best - 1.0
        rows[name] = {
            "starts": len(few),
            "wall_s_per_start": wall / len(few),
            "cpu_s_per_start": cpu / len(few),
            "J_above_search_mean": float(excess.mean()),
            "J_above_search_worst": float(excess.max()),
            "cpu_times_search": cpu / len(few) / rows["search"]["cpu_s_per_start"],
        }
    load = os.getloadavg()[0]
    result = {
        "cores": os.cpu_count(),
        "load_average": load,
        "minutes_for_6000_starts": rows["search"]["wall_s_per_start"] * 6000 / 60,
        "minutes_for_6000_starts_on_idle_cores": rows["search"]["cpu_s_per_start"] * 6000 / 60 / (os.cpu_count() or 1),
        "rows": rows,
    }
    write_whole(options.output, json.dumps(result, indent=1) + "\n")
    print(json.dumps(result, indent=1))
    return result


if __name__ == "__main__":
    main()
