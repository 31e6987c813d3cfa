"""What a trial is, and what comes out of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

KEPT = 20  # sentences about violations that are kept word by word


@dataclass
class Outcome:
    """What a chunk of a trial, or all chunks together, came to; sums, extremes and sentences that can be merged.

    Attributes
    ----------
    count : how many cases were tried
    failures : how many of them went wrong
    violations : a sentence for each of the first of them
    tallies : further counts by name
    largest, smallest : extremes by name
    seconds : processor time
    """

    count: int = 0
    failures: int = 0
    violations: list[str] = field(default_factory=list)
    tallies: dict[str, int] = field(default_factory=dict)
    largest: dict[str, float] = field(default_factory=dict)
    smallest: dict[str, float] = field(default_factory=dict)
    seconds: float = 0.0

    def violate(self, sentence: str, cases: int = 1) -> None:
        """Note that something went wrong in so many cases."""
        self.failures += cases
        if len(self.violations) < KEPT:
            self.violations.append(sentence)

    def tally(self, name: str, count: int = 1) -> None:
        """Count something."""
        self.tallies[name] = self.tallies.get(name, 0) + int(count)

    def note(self, name: str, value: float) -> None:
        """Keep the largest of the values of that name."""
        self.largest[name] = max(float(value), self.largest.get(name, float(value)))

    def note_least(self, name: str, value: float) -> None:
        """Keep the smallest of the values of that name."""
        self.smallest[name] = min(float(value), self.smallest.get(name, float(value)))

    def add(self, other: Outcome) -> None:
        """Take in what another chunk came to."""
        self.count += other.count
        self.failures += other.failures
        self.violations = (self.violations + other.violations)[:KEPT]
        self.seconds += other.seconds
        for name, count in other.tallies.items():
            self.tally(name, count)
        for name, value in other.largest.items():
            self.note(name, value)
        for name, value in other.smallest.items():
            self.note_least(name, value)

    def as_dict(self) -> dict[str, Any]:
        """As JSON holds it."""
        return asdict(self)

    @classmethod
    def from_dict(cls, found: Mapping[str, Any]) -> Outcome:
        """What `as_dict` gave."""
        return cls(**found)


@dataclass(frozen=True)
class Chunk:
    """A part of a trial: the same chunk does the same every time.

    Attributes
    ----------
    number : which one
    count : cases
    scratch : an empty folder of its own
    fmus : folder in which FMUs lie, or are built when first asked for
    """

    number: int
    count: int
    scratch: Path
    fmus: Path


@dataclass(frozen=True)
class Trial:
    """One line of the summary.

    Attributes
    ----------
    name : on the command line
    promise : what must hold
    run : does one chunk
    chunks, count : of the long form, and the cases in each chunk
    short : cases of the short form, which is a single chunk
    tell : the figures worth a line, from what all chunks came to
    needs : from the system, by the names in tests/system_packages.py, without which the trial is left out
    limit : seconds after which a chunk is taken for hanging
    """

    name: str
    promise: str
    run: Callable[[Chunk], Outcome]
    chunks: int
    count: int
    short: int
    tell: Callable[[Outcome], str] = lambda outcome: ""
    needs: tuple[str, ...] = ()
    limit: float = 900.0
