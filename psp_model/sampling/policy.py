"""How the loop is sampled, what certifies the period, and what happens where that does not."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class Lemma1Policy(IntEnum):
    """What happens at a sampling instant at which the chosen certificate does not certify T (ours)."""

    ERROR = 1
    WARN = 2
    SHORTEN = 3


class Certificate(IntEnum):
    """What certifies a sampling period: T < T_max of Lemma 1, or T < T_exact, the exact period (ours)."""

    LEMMA1 = 1
    EXACT = 2


@dataclass(frozen=True)
class Sampling:
    """How the loop is sampled (ours, except T).

    Attributes
    ----------
    T : sampling period [s]
    policy : what happens where T is not certified; one of `Lemma1Policy`, or its number
    max_short_periods : most shortened periods in one call of `SampledPlatoon.advance_to`
    certificate : what certifies T; one of `Certificate`, or its number
    """

    T: float = 0.01
    policy: Lemma1Policy | int = Lemma1Policy.ERROR
    max_short_periods: int = 100_000
    certificate: Certificate | int = Certificate.LEMMA1
