"""Co-simulation masters: what they mean, in exact fractions, and what they hand over, rounded in their own way."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from itertools import cycle, islice
from typing import NamedTuple

import numpy as np


class Told(NamedTuple):
    """One communication step.

    Attributes
    ----------
    begin, size : what fmi2DoStep is told [s]
    end : the time since the start that the master means to reach [s]
    """

    begin: float
    size: float
    end: Fraction


Steps = Sequence[Fraction]  # the sizes meant [s], which repeat


def _ends(steps: Steps) -> Iterator[tuple[Fraction, Fraction]]:
    end = Fraction(0)
    for step in cycle(steps):
        end += step
        yield step, end


def sums(start: float, steps: Steps) -> Iterator[Told]:
    """t += h, with h as the size."""
    t = start
    for step, end in _ends(steps):
        yield Told(t, float(step), end)
        t += float(step)


def sums_and_differences(start: float, steps: Steps) -> Iterator[Told]:
    """t += h, with the difference of two times as the size."""
    t = start
    for step, end in _ends(steps):
        after = t + float(step)
        yield Told(t, after - t, end)
        t = after


def counts(start: float, steps: Steps) -> Iterator[Told]:
    """t = start + k h, with h as the size."""
    t = start
    for step, end in _ends(steps):
        yield Told(t, float(step), end)
        t = start + float(end)


def counts_and_differences(start: float, steps: Steps) -> Iterator[Told]:
    """t = start + k h, with the difference of two times as the size."""
    t = start
    for _, end in _ends(steps):
        after = start + float(end)
        yield Told(t, after - t, end)
        t = after


def single_steps(start: float, steps: Steps) -> Iterator[Told]:
    """t += h, with h rounded to single precision."""
    t = start
    for step, end in _ends(steps):
        h = float(np.float32(float(step)))
        yield Told(t, h, end)
        t += h


def single_clock(start: float, steps: Steps) -> Iterator[Told]:
    """t += h, both in single precision."""
    t = np.float32(start)
    for step, end in _ends(steps):
        h = np.float32(float(step))
        yield Told(float(t), float(h), end)
        t = np.float32(t + h)


def nanoseconds(start: float, steps: Steps) -> Iterator[Told]:
    """Whole nanoseconds, added up; the size is a difference of two times in seconds, as libcosim has it."""
    at = round(start * 1e9)
    for step, end in _ends(steps):
        after = at + round(step * 10**9)
        yield Told(at / 1e9, after / 1e9 - at / 1e9, end)
        at = after


def noisy(start: float, steps: Steps) -> Iterator[Told]:
    """t = start + k h with an error of up to 1e-12 s, with the difference of two times as the size."""
    rng, t = np.random.default_rng(1), start
    for _, end in _ends(steps):
        after = start + float(end) + rng.uniform(-1e-12, 1e-12)
        yield Told(t, after - t, end)
        t = after


def printed(start: float, steps: Steps) -> Iterator[Told]:
    """t = start + k h, with all numbers sent as text of 15 digits."""
    t = start
    for step, end in _ends(steps):
        yield Told(float(f"{t:.15g}"), float(f"{float(step):.15g}"), end)
        t = start + float(end)


Master = Callable[[float, Steps], Iterator[Told]]

MASTERS: dict[str, Master] = {  # those that any clock time and any step is good for
    "t += h": sums,
    "t += h, differences": sums_and_differences,
    "k h": counts,
    "k h, differences": counts_and_differences,
}
ROUNDERS: dict[str, Master] = {  # those that round more than a double does
    "single steps": single_steps,
    "single clock": single_clock,
    "nanoseconds": nanoseconds,
    "noise": noisy,
    "text": printed,
}
STARTS = (0.0, -10.0, 1e6, 1700000000.0, 1700000000.123, -1.7e9)


def steps_of(master: Master, start: float, steps: Steps, count: int) -> list[Told]:
    """The first steps of a master.

    Parameters
    ----------
    master : the kind
    start : time at which it starts [s]
    steps : sizes meant [s], which repeat
    count : how many
    """
    return list(islice(master(start, steps), count))
