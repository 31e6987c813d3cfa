"""How the loop is sampled, and what happens where Lemma 1 does not certify the period."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class Lemma1Policy(IntEnum):
    """What happens at a sampling instant with T >= T_max (ours)."""

    ERROR = 1
    WARN = 2
    SHORTEN = 3


@dataclass(frozen=True)
class Sampling:
    """How the loop is sampled (ours, except T).

    Attributes
    ----------
    T : sampling period [s]
    policy : what happens where Lemma 1 does not certify T; one of `Lemma1Policy`, or its number
    max_short_periods : most shortened periods in one call of `SampledPlatoon.advance_to`
    """

    T: float = 0.01
    policy: Lemma1Policy | int = Lemma1Policy.ERROR
    max_short_periods: int = 100_000
