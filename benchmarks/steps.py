"""What a step costs: doStep over one sampling period and all outputs, in three hosts, for 2 to 1000 vehicles."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import numpy as np

from .fmus import KINDS, OFF_HILL, ON_HILL, fmu, host, loop
from .registry import Context
from .rounds import Row, interleave, row
from .worker import Worker

SIZES = (2, 7, 20, 100, 1000)
HOSTS = ("fmpy", "ctypes", "C host")
Samples = dict[str, list[float]]


@contextmanager
def workers(n: int) -> Iterator[dict[str, Worker]]:
    """All that is compared at one number of vehicles, by name."""
    with ExitStack() as stack:
        found = {
            f"{kind}, {which}": stack.enter_context(host(kind, fmu(kind, n), which, ON_HILL))
            for which in HOSTS
            for kind in KINDS
        }
        found["native, off the hill"] = stack.enter_context(host("native", fmu("native", n), "C host", OFF_HILL))
        found["loop"] = stack.enter_context(loop(n, ON_HILL))
        found["loop, off the hill"] = stack.enter_context(loop(n, OFF_HILL))
        yield found


def same_numbers(n: int, running: dict[str, Worker]) -> None:
    """Check that loop and FMUs compute the same motion: otherwise their times say nothing."""
    for case in ("", ", off the hill"):
        expected = np.array(running[f"loop{case}"].ask(0), dtype=float)[: 4 * n - 1]
        names = [f"native{case}"] if case else ["native, C host", "python, C host", "python, ctypes", "native, fmpy"]
        for name in names:
            found = np.array(running[name].ask(0), dtype=float)[: 4 * n - 1]
            worst = float(np.abs(found - expected).max())
            if worst > 1e-9:
                raise RuntimeError(f"{name} differs from the hand-written loop by {worst} for {n} vehicles")


def rows_at(n: int, found: Samples) -> list[Row]:
    """The lines for one number of vehicles."""
    rows, size = [], f"n = {n}"
    for which in HOSTS:
        for kind, title, peer in (
            ("python", "Python FMU", "empty pythonfmu slave"),
            ("native", "native FMU", "empty FMU in C"),
        ):
            pair = found[f"{kind}, {which}"], found[f"empty {kind}, {which}"]
            rows.append(row(f"{title}, {which}", size, peer, *pair, "µs/step", scale=1e6))
    for case, ours in (("on", "native, C host"), ("off", "native, off the hill")):
        pair = found[ours], found["loop" if case == "on" else "loop, off the hill"]
        rows.append(
            row(f"native FMU, C host, {case} the hill", size, "hand-written C loop", *pair, "µs/step", scale=1e6)
        )
    pair = found["native, C host"], found["python, C host"]
    rows.append(row("native FMU, C host", size, "Python FMU", *pair, "µs/step", scale=1e6))
    return rows


def slopes(by_size: dict[int, Samples]) -> list[Row]:
    """What one more vehicle costs, between the two largest numbers of vehicles."""
    few, many = sorted(by_size)[-2:]
    size, rows = f"slope, {few} to {many}", []

    def slope(name: str) -> list[float]:
        pairs = zip(by_size[few][name], by_size[many][name], strict=False)
        return [(large - small) / (many - few) for small, large in pairs]

    for which in HOSTS:
        for kind, title in (("python", "Python FMU"), ("native", "native FMU")):
            pair = slope(f"{kind}, {which}"), slope(f"empty {kind}, {which}")
            peer = "empty pythonfmu slave" if kind == "python" else "empty FMU in C"
            rows.append(row(f"{title}, {which}", size, peer, *pair, "ns/vehicle", scale=1e9))
    for case, ours, theirs in (
        ("on", "native, C host", "loop"),
        ("off", "native, off the hill", "loop, off the hill"),
    ):
        title = f"native FMU, C host, {case} the hill"
        rows.append(row(title, size, "hand-written C loop", slope(ours), slope(theirs), "ns/vehicle", scale=1e9))
    return rows


def measure(context: Context) -> list[Row]:
    """All lines of this measurement."""
    sizes = (2, 7) if context.quick else SIZES
    by_size: dict[int, Samples] = {}
    rows = []
    for n in sizes:
        context.say(f"n = {n}")
        with workers(n) as running:
            same_numbers(n, running)
            measures = {name: worker.seconds for name, worker in running.items()}
            by_size[n] = interleave(measures, context.rounds(9), 25.0)
        rows += rows_at(n, by_size[n])
    return rows + slopes(by_size)
