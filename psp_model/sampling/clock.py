"""How far the sampling has come, from the communication steps of any master; state in, state out.

A master hands over where a step begins and how long it is, both rounded in its own way: times are sums of 0.01 s that
have drifted, or a Unix clock that resolves 2.4e-7 s; step sizes are nominal, or differences of such times.  The clock
therefore adds up the step sizes, in sampling periods, and takes a communication point for a sampling instant where the
rest is no more than the rounding of what it was told.  That rest is then dropped, so that it never adds up.  Rounding
is measured by the place of the last digit that a step size carries.

fmu_src/native/c/clock.c does the same, bit for bit.  Everything here is ours.
"""

from __future__ import annotations

from math import copysign, floor, frexp, isfinite, ldexp
from sys import float_info
from typing import NamedTuple

from ..errors import ModelError

MOST_PERIODS = 9e15  # more cannot be told apart in double precision
TIME_TOLERANCE = 1e-6  # [sampling periods] a time this close to a nominal sampling instant is that instant

_EPSILON = float_info.epsilon
_SINGLE_EPSILON = 2.0**-23  # of single precision
_ULPS = 4.0  # [units in the last place] rounding of a time that is computed in another way than ours
_MIXED = 16.0  # [last places] that steps of different sizes may drift; equal ones drift without an end
_NANOSECONDS = 2e-9  # [s] what a master that counts nanoseconds rounds off in a few steps
_AIM = 1 / 64  # [sampling periods] most drift of a master's time that a step to an absolute time makes up for


class Clock(NamedTuple):
    """The instance's own time, which sampling instants are at whole numbers of; (period + offset) T since the first.

    Attributes
    ----------
    first : the first sampling instant as the master has it [s]
    time : the last communication point as the master has it [s]
    period, offset : the nearest sampling instant, and how far behind it the communication point is [sampling periods]
    last : size of the last step [s]
    doubt : what the steps may have drifted since the last instant that was met, half a last place each
        [sampling periods]
    """

    first: float = 0.0
    time: float = 0.0
    period: int = 0
    offset: float = 0.0
    last: float = 0.0
    doubt: float = 0.0

    @classmethod
    def begin(cls, start: float, phase: float = 0.0, T: float = 1.0) -> Clock:
        """The clock at the start.

        Parameters
        ----------
        start : as the master has it [s]
        phase : of the first sampling instant, from 0 to T [s]
        T : sampling period [s]
        """
        return cls(start + phase, start, *_nearest(-phase / T))

    def at(self) -> tuple[int, float]:
        """The communication point as whole sampling periods since the first instant and a fraction in [0, 1)."""
        if abs(self.offset) <= TIME_TOLERANCE:
            return self.period, 0.0
        return (self.period, self.offset) if self.offset > 0.0 else (self.period - 1, 1.0 + self.offset)

    def time_of(self, instant: int, T: float) -> float:
        """A sampling instant as the master has it, reckoned from the communication point [s].

        Parameters
        ----------
        instant : its number
        T : sampling period [s]
        """
        period, fraction = self.at()
        return self.time + (instant - period - fraction) * T

    def age_rounding(self, age: float, T: float) -> float:
        """How far an age may be off because of the master's rounding [s].

        Parameters
        ----------
        age : difference of two times [s]
        T : sampling period [s]
        """
        periods = min(max(age, 0.0) / T, MOST_PERIODS)  # which the master's time may have drifted in
        return TIME_TOLERANCE * T + _ULPS * _EPSILON * abs(self.time) * (1.0 + periods)

    def after(self, begin: float, size: float, T: float) -> Clock:
        """The clock after a communication step.

        Parameters
        ----------
        begin : where the step begins as the master has it [s]
        size : of the step, not negative [s]
        T : sampling period [s]

        Raises
        ------
        ModelError : where that is more sampling periods than can be counted
        """
        end, moved = begin + size, self._moved(begin, size)
        one = size == T and moved == 0.0  # what most masters do
        periods = 1.0 if one else max(size + moved, 0.0) / T
        if not (abs(self.period + periods) < MOST_PERIODS and isfinite(end)):
            raise ModelError("periods", end - self.first, T)
        if one and self.offset == 0.0:  # with the result of what follows
            return Clock(self.first, end, self.period + 1, 0.0, size)
        if periods == 0.0:
            return self._replace(time=end)
        whole, offset = _nearest(self.offset + periods)
        place = _last_place(begin, size)
        again = abs(size - self.last) <= place
        doubt = self.doubt
        if again or doubt < _MIXED * place / T:
            doubt += 0.5 * place / T
        reach = max(place / T + doubt, min(_NANOSECONDS / T, TIME_TOLERANCE))
        there = Clock(self.first, end, self.period + whole, offset, size, doubt)
        if whole == 0 and abs(self.offset) <= TIME_TOLERANCE:
            return there  # that instant has been met
        return there._settled(periods, reach, again, T)

    def _moved(self, begin: float, size: float) -> float:
        """By how much more than its rounding the master's time has moved since the last step ended [s]."""
        moved = begin - self.time
        if abs(moved) <= _ULPS * _EPSILON * abs(begin):
            return 0.0
        single = _digits(begin) <= 24 and _digits(size) <= 24  # it keeps time in single precision
        return 0.0 if single and abs(moved) <= _SINGLE_EPSILON * abs(begin) else moved

    def _settled(self, periods: float, reach: float, again: bool, T: float) -> Clock:
        """The clock with the rounding dropped, if the nearest sampling instant is met here.

        Of the points before and behind an instant that are within reach, the nearer one meets it: hence half a step.
        """
        apart, half = abs(self.offset), 0.5 * periods
        if not (apart <= TIME_TOLERANCE or apart <= min(TIME_TOLERANCE + reach, half)):
            if again or not apart <= min(_AIM, half):
                return self
            # a step unlike the last one may aim at a time; the master's, which has drifted from the sum of its steps
            rounding = _ULPS * _EPSILON * abs(self.time) / T
            off = abs((self.time - self.first) / T - self.period)
            if not (rounding <= 0.25 * apart and off <= min(TIME_TOLERANCE, 0.5 * apart) + rounding):
                return self
            reach = apart
        rest = min(max(apart - min(reach, half), 0.0), TIME_TOLERANCE)
        return self._replace(offset=copysign(rest, self.offset), doubt=0.0)


def _nearest(periods: float) -> tuple[int, float]:
    """The nearest whole number, and what is behind it."""
    whole = floor(periods + 0.5)
    return whole, periods - whole


def _digits(value: float) -> int:
    """How many binary digits a number needs, at most: 16, those of a round number; 24, of single precision; or 53."""
    mantissa = frexp(value)[0]
    return next((digits for digits in (16, 24) if (mantissa * 2.0**digits).is_integer()), 53)


def _spacing(value: float, digits: int) -> float:
    """The place of the last of so many binary digits."""
    return max(ldexp(1.0, frexp(value)[1] - digits), 2.0**-1074)


def _last_place(begin: float, size: float) -> float:
    """The place of the last digit that a step size carries [s]: its own, or that of the times it is a difference of."""
    place = _spacing(size, 24 if _digits(size) == 24 else 53)
    low, high = sorted((abs(begin), abs(begin + size)))
    count = size / _spacing(low or high, 53)
    return max(place, _spacing(high, 53)) if count >= 2.0**53 or count.is_integer() else place


def locate(time: float, T: float) -> tuple[int, float]:
    """Time as whole sampling periods and a fraction in [0, 1), rounded to a nominal instant within TIME_TOLERANCE.

    Ours, because masters add their steps up and arrive at a sampling instant with rounding errors.

    Parameters
    ----------
    time : time since the start [s]
    T : sampling period [s]

    Raises
    ------
    ModelError : where that is more sampling periods than can be counted
    """
    periods = time / T
    if not abs(periods) < MOST_PERIODS:
        raise ModelError("periods", time, T)
    nearest = round(periods)
    if abs(periods - nearest) <= TIME_TOLERANCE:
        return nearest, 0.0
    return floor(periods), periods - floor(periods)
