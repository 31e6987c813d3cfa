"""A leader's speed over time: steady, then a stop-and-go wave."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, isfinite, pi

from .errors import ModelError


@dataclass(frozen=True)
class Wave:
    """A cosine between two speeds after a while at the higher one (ours).

    Attributes
    ----------
    high, low : speeds [m/s]; equal for a leader who never changes his
    begin : when the first braking begins [s]
    period : of the wave [s]

    Raises
    ------
    ModelError : where a value is not finite, a speed negative or the period not positive
    """

    high: float = 30.0
    low: float = 30.0
    begin: float = 10.0
    period: float = 40.0

    def __post_init__(self) -> None:
        for name, unit in (("high", "m/s"), ("low", "m/s"), ("begin", "s"), ("period", "s")):
            if not isfinite(getattr(self, name)):
                raise ModelError("finite", name, getattr(self, name), unit)
        if not 0 <= self.low <= self.high or not self.period > 0:
            raise ModelError("wave", self.low, self.high, self.period)

    def speed(self, time: float) -> float:
        """Speed of the leader [m/s].

        Parameters
        ----------
        time : since the start [s]
        """
        if time < self.begin:
            return self.high
        middle, half = 0.5 * (self.high + self.low), 0.5 * (self.high - self.low)
        return middle + half * cos(2 * pi * (time - self.begin) / self.period)
