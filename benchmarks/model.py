"""What a sampling period of the model costs in NumPy, without any FMI, for 2 to 100,000 vehicles."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack

from psp_model import BEST_FIXED, PlatoonState, SampledPlatoon

from .fmus import OFF_HILL, ON_HILL, loop
from .registry import Context
from .rounds import Row, interleave, row

SIZES = (2, 7, 20, 100, 1000, 10_000, 100_000)
SEGMENT = 50  # sampling periods from the same start, as the hand-written loop does them


def stepper(n: int, spacing: float) -> Callable[[], float]:
    """Gives seconds per sampling period, over segments that last some hundredths of a second in all."""
    start = PlatoonState([spacing + 0.05 * (i % 5) for i in range(n - 1)], [30.0 + 0.01 * (i % 7) for i in range(n)])
    segments = max(1, 2000 // n)

    def measure() -> float:
        seconds = 0.0
        for _ in range(segments):
            platoon = SampledPlatoon.begin(start, BEST_FIXED)
            began = time.perf_counter()
            for period in range(1, SEGMENT + 1):
                platoon.advance_to(period, 0.0)
                platoon.observe(period, 0.0)
            seconds += time.perf_counter() - began
        return seconds / segments / SEGMENT

    return measure


def measure(context: Context) -> list[Row]:
    """All lines of this measurement."""
    sizes = (2, 7) if context.quick else SIZES
    rows, by_size = [], {}
    for n in sizes:
        context.say(f"n = {n}")
        with ExitStack() as stack:
            measures = {}
            for case, spacing in (("on", ON_HILL), ("off", OFF_HILL)):
                measures[f"ours, {case}"] = stepper(n, spacing)
                measures[f"loop, {case}"] = stack.enter_context(loop(n, spacing)).seconds
            found = by_size[n] = interleave(measures, context.rounds(7), 12.0)
        for case in ("on", "off"):
            title, pair = f"psp_model in NumPy, {case} the hill", (found[f"ours, {case}"], found[f"loop, {case}"])
            rows.append(row(title, f"n = {n:,}", "hand-written C loop", *pair, "µs/step", scale=1e6))
    few, many = sizes[-2], sizes[-1]
    for case in ("on", "off"):
        pair = []
        for who in ("ours", "loop"):
            ends = zip(by_size[few][f"{who}, {case}"], by_size[many][f"{who}, {case}"], strict=False)
            pair.append([(large - small) / (many - few) for small, large in ends])
        size = f"slope, {few:,} to {many:,}"
        title = f"psp_model in NumPy, {case} the hill"
        rows.append(row(title, size, "hand-written C loop", *pair, "ns/vehicle", scale=1e9))
    return rows
