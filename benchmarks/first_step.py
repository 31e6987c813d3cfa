"""From loading the FMU's library to the end of the first doStep, in a fresh process every time, for 7 vehicles."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from .begin import beginner
from .fmus import Fmu, fmu
from .registry import Context
from .rounds import Row, interleave, row

SOURCES = {2: "fixed triple", 1: "network", 3: "network and 16 rollouts"}
TITLES = {"python": ("Python FMU", "empty pythonfmu slave"), "native": ("native FMU", "empty FMU in C")}


def once(kind: str, under: Fmu, which: str, source: int) -> float:
    """Seconds in one fresh process."""
    with beginner(kind, under, which, source) as worker:
        return float(worker.ask(0)[0])


def measure(context: Context) -> list[Row]:
    """All lines of this measurement."""
    rows = []
    for which in ("fmpy", "C host"):
        context.say(which)
        measures: dict[str, Callable[[], float]] = {}
        for kind in TITLES:
            measures[f"empty {kind}"] = partial(once, f"empty {kind}", fmu(f"empty {kind}", 7), which, 0)
            for source in SOURCES:
                measures[f"{kind} {source}"] = partial(once, kind, fmu(kind, 7), which, source)
        found = interleave(measures, context.rounds(7), 40.0)
        for kind, (title, peer) in TITLES.items():
            for source, choice in SOURCES.items():
                pair = found[f"{kind} {source}"], found[f"empty {kind}"]
                rows.append(row(f"{title}, {choice}, {which}", "n = 7", peer, *pair, "ms", scale=1e3))
    return rows
