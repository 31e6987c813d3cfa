"""The offline search beside IPOPT and differential evolution at equal or better J, all on one thread.

A rival is set beside the cheapest effort of ours whose mean J on the rival's starts is not above the rival's.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from psp_model import StartDomain
from psp_model.offline.ipopt import LocalSolver
from psp_model.selection.search.engine import Engine, Problem
from psp_model.selection.search.search import EFFORTS, Search

from .offline_search import brute_force, feasible_grid
from .offline_speed import evolution, judged
from .registry import Context
from .rounds import Row, interleave, row

BATCH = 20  # starts of a round; the rivals take the first few
RIVALS = {  # name: (starts of a round, population, generations)
    "IPOPT from three guesses": (2, 0, 0),
    "differential evolution, 15 x 3, 60 generations": (4, 15, 60),
    "differential evolution, 30 x 3, 150 generations": (2, 30, 150),
}
ORDER = ("grid", "quick", "full")  # of our efforts, cheapest first


class Rivals:
    """What is timed, round by round; the triples found are kept."""

    def __init__(self, rounds: int):
        self.problem = Problem()
        s, v = StartDomain().draw(np.random.default_rng(7), 7, BATCH * (rounds + 1))
        self.starts = np.concatenate([s, v]).T
        self.searches = {name: Search(self.problem, EFFORTS[name], 1) for name in ORDER}
        self.engine, self.exact = Engine(self.problem, "float", 1), Engine(self.problem, "double", 1)
        self.local = LocalSolver(self.problem)
        self.found: dict[str, list[Any]] = {name: [] for name in (*ORDER, *RIVALS)}
        self.searches["grid"].solve(self.starts[:1])  # compiles
        self.local.solve(self.starts[0], [(1e-3, 11.0, 5.5)])  # builds

    def solve(self, name: str, starts: Any) -> Any:
        """Triples for starts, by one of ours or of the rivals."""
        if name in self.searches:
            return self.searches[name].solve(starts).triples
        _, population, generations = RIVALS[name]
        if not population:
            return np.array([self.local.solve(start)[0] for start in starts])
        limit = self.searches["full"].limit
        return np.array(
            [
                evolution(start, self.problem, self.engine, limit, k, population, generations)
                for k, start in enumerate(starts)
            ]
        )

    def timed(self, name: str) -> Callable[[], float]:
        """Gives the seconds per start; every call takes the next starts."""

        def measure() -> float:
            number = len(self.found[name])
            few = RIVALS[name][0] if name in RIVALS else BATCH
            starts = self.starts[BATCH * number : BATCH * number + few]
            began = time.perf_counter()
            triples = self.solve(name, starts)
            seconds = (time.perf_counter() - began) / few
            self.found[name].append(judged(starts, triples, self.exact))
            return seconds

        return measure

    def J(self, name: str, few: int) -> Any:
        """What was reached on the first `few` starts of every round."""
        return np.concatenate([J[:few] for J in self.found[name]])


def measure(context: Context) -> list[Row]:
    """All lines of this measurement."""
    rounds = context.rounds(5)
    rivals = Rivals(rounds)
    context.say("ours, IPOPT and differential evolution in turn")
    samples = interleave({name: rivals.timed(name) for name in rivals.found}, rounds, 80.0)
    rows = []
    for rival, (few, *_) in RIVALS.items():
        theirs = rivals.J(rival, few)
        means = {name: float((rivals.J(name, few) / theirs - 1).mean()) for name in ORDER}
        ours = next((name for name in ORDER if means[name] <= 0), "full")
        note = f"its mean J is {100 * abs(means[ours]):.2g} % {'lower' if means[ours] <= 0 else 'higher'}"
        size = f"{len(theirs)} starts of 7"
        rows.append(
            row(f"search, {ours}", size, rival, samples[ours], samples[rival], "ms/start", scale=1e3, note=note)
        )
    context.say("a brute-force grid")
    return [*rows, against_brute_force(rivals, 1 if context.quick else 10)]


def against_brute_force(rivals: Rivals, count: int) -> Row:
    """J of the search beside J of a fine grid with refinement."""
    rng, starts = np.random.default_rng(100), rivals.starts[:count]
    points = feasible_grid()
    best = [brute_force(start, points, Engine(rivals.problem), rivals.exact, rng) for start in starts]
    ours = rivals.searches["full"].solve(starts).J
    return row(
        "search, full: J found", f"{count} starts of 7", f"grid of {len(points):,} points, refined", ours, best, "J"
    )
