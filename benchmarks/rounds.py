"""Figures as ratios: what is compared runs in turn, round after round, so that a busy machine slows all of it alike."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from statistics import median, quantiles
from typing import Any


@dataclass(frozen=True)
class Row:
    """One line of the table.

    Attributes
    ----------
    what, size : of ours
    peer : what it stands beside
    ours, theirs : medians, in `unit`; None where there is none
    unit : of both
    ratio : of the costs, ours over theirs (median of the rounds): below 1 ours is cheaper
    low, high : quartiles of that ratio over the rounds
    rounds : how many
    note : what has to be known
    """

    what: str
    size: str
    peer: str
    ours: float | None
    theirs: float | None
    unit: str
    ratio: float | None
    low: float | None
    high: float | None
    rounds: int
    note: str = ""

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


Samples = Mapping[str, Sequence[float]]


def interleave(
    measures: Mapping[str, Callable[[], float]], rounds: int, seconds: float = 60.0
) -> dict[str, list[float]]:
    """Call all measures in turn, round after round.

    Parameters
    ----------
    measures : by name; each gives a cost
    rounds : how many; one round is run before them and thrown away
    seconds : after which no further round is begun, once three are done

    Returns
    -------
    what each gave, by name
    """
    found: dict[str, list[float]] = {name: [] for name in measures}
    began = time.perf_counter()
    for number in range(-1, rounds):
        if number >= 3 and time.perf_counter() - began > seconds:
            break
        for name, measure in measures.items():
            value = measure()
            if number >= 0:
                found[name].append(value)
    return found


def spread(values: Sequence[float]) -> tuple[float, float, float]:
    """Median and quartiles."""
    if len(values) == 1:
        return values[0], values[0], values[0]
    low, _, high = quantiles(values, n=4, method="inclusive")
    return median(values), low, high


def row(
    what: str,
    size: str,
    peer: str,
    ours: Sequence[float],
    theirs: Sequence[float],
    unit: str,
    *,
    scale: float = 1.0,
    rate: bool = False,
    note: str = "",
) -> Row:
    """A line of the table from what the rounds gave.

    Parameters
    ----------
    what, size, peer, unit, note : as in `Row`
    ours, theirs : costs, or rates where `rate` is set, round by round
    scale : from the samples' unit to `unit`
    rate : whether more is better; the ratio is then theirs over ours
    """
    pairs = list(zip(ours, theirs, strict=True))
    ratio, low, high = spread([theirs / ours if rate else ours / theirs for ours, theirs in pairs])
    return Row(what, size, peer, scale * median(ours), scale * median(theirs), unit, ratio, low, high, len(pairs), note)
