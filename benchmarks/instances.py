"""1 to 1000 instances for 7 vehicles in one process: memory, time to make one, and what a step of one costs."""

from __future__ import annotations

import sys
from contextlib import ExitStack

from .fmus import CACHE, HOSTS, KINDS, fmu
from .registry import Context
from .rounds import Row, interleave, row
from .worker import Worker

COUNTS = (1, 10, 100, 1000)
TITLES = {"python": ("Python FMU", "empty pythonfmu slave"), "native": ("native FMU", "empty FMU in C")}


def many(kind: str, count: int) -> Worker:
    """A worker that steps all of so many instances."""
    under = fmu(kind, 7)
    numbers = [under.arguments(0.0)[i] for i in (0, 1, 2, 4, 5)]
    command = [sys.executable, str(HOSTS / "many_host.py"), str(count), under.folder, under.model, *numbers]
    return Worker(command, CACHE / f"many_{count}_{kind}.log".replace(" ", "_"))


def measure(context: Context) -> list[Row]:
    """All lines of this measurement."""
    counts = (1, 10) if context.quick else COUNTS
    rows, memory, making = [], {}, {}
    for count in counts:
        size = f"{count} instances" if count > 1 else "1 instance"
        context.say(size)
        with ExitStack() as stack:
            running = {kind: stack.enter_context(many(kind, count)) for kind in KINDS}
            for kind, worker in running.items():
                memory[kind, count], making[kind] = map(float, worker.ask(0))
            found = interleave({kind: worker.seconds for kind, worker in running.items()}, context.rounds(9), 15.0)
        for kind, (title, peer) in TITLES.items():
            pair = found[kind], found[f"empty {kind}"]
            rows.append(row(f"{title}, a step of one", size, peer, *pair, "µs/step", scale=1e6))
    few, most = counts[0], counts[-1]
    for kind, (title, peer) in TITLES.items():
        first = [memory[kind, few]], [memory[f"empty {kind}", few]]
        rows.append(row(f"{title}, memory of the first", "1 instance", peer, *first, "KiB", scale=1 / 1024))
        more = [[(memory[k, most] - memory[k, few]) / (most - few)] for k in (kind, f"empty {kind}")]
        rows.append(row(f"{title}, memory of one more", f"{most} instances", peer, *more, "KiB", scale=1 / 1024))
        made = [making[kind]], [making[f"empty {kind}"]]
        rows.append(row(f"{title}, to make one", f"{most} instances", peer, *made, "ms", scale=1e3))
    return rows
