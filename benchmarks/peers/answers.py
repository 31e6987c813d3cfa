"""The protocol of the workers, for programs that run in a Python of their own."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable


def answer(begin: Callable[[], Callable[[], None]], steps: int) -> None:
    """Answer every line of the input, a number of segments, with seconds per step and the steps of a segment.

    Parameters
    ----------
    begin : puts the vehicles at their start; what it returns does all steps of a segment
    steps : of a segment
    """
    print("ready", flush=True)
    for line in sys.stdin:
        seconds, segments = 0.0, max(1, int(line))
        for _ in range(segments):
            run = begin()
            began = time.perf_counter()
            run()
            seconds += time.perf_counter() - began
        print(seconds / segments / steps, steps, flush=True)
