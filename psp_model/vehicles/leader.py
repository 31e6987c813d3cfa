"""A leader's speed over time: steady, on a stop-and-go wave, or from a table."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import cos, isfinite, pi
from pathlib import Path
from typing import Protocol

from ..errors import ModelError
from ..parameters import PlatoonParameters


class LeaderSpeed(Protocol):
    """The speed of a leader over time."""

    def speed(self, time: float) -> float:
        """Speed of the leader [m/s].

        Parameters
        ----------
        time : since the start [s]
        """


def between(high: float, low: float, cosine: float) -> float:
    """The speed on a wave where its cosine has some value (ours).

    Parameters
    ----------
    high, low : speeds at its top and bottom [m/s]
    cosine : from -1 to 1 [1]
    """
    return 0.5 * (high + low) + 0.5 * (high - low) * cosine


def on_line(time: float, begin: float, end: float, first: float, last: float) -> float:
    """The speed on a straight line at some time (ours).

    Parameters
    ----------
    time : of the speed [s]
    begin, end : of the line [s]
    first, last : speeds there [m/s]
    """
    return first + (time - begin) / (end - begin) * (last - first)


def held_for(now: float, later: float, T: float) -> float:
    """The acceleration that, held for T, takes a vehicle from its speed now to the one later (ours).

    Parameters
    ----------
    now, later : speeds [m/s]
    T : time between them [s]
    """
    return (later - now) / T


@dataclass(frozen=True)
class Wave:
    """A cosine between two speeds after a while at the higher one (ours).

    Attributes
    ----------
    high, low : speeds [m/s]; equal for a steady leader
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
        named = {"v_high": self.high, "v_low": self.low, "begin": self.begin, "period": self.period}
        for name, value in named.items():
            if not isfinite(value):
                raise ModelError("finite", name, value, "m/s" if name.startswith("v") else "s")
        if self.low < 0:
            raise ModelError("wave_backwards", self.low)
        if self.low > self.high:
            raise ModelError("wave", self.low, self.high)
        if not self.period > 0:
            raise ModelError("wave_period", self.period)

    def speed(self, time: float) -> float:
        """Speed of the leader [m/s].

        Parameters
        ----------
        time : since the start [s]
        """
        if time < self.begin:
            return self.high
        angle = 2 * pi * (time - self.begin) / self.period
        return between(self.high, self.low, cos(angle) if isfinite(angle) else 1.0)  # beyond what can be counted


@dataclass(frozen=True)
class Profile:
    """Speeds at given times, straight lines between them (ours); before the first and after the last they are held.

    Attributes
    ----------
    times : increasing [s]
    speeds : as many, from 0 to v_max [m/s]
    name : for messages
    v_max : largest speed of the state space [m/s]

    Raises
    ------
    ModelError : where there are fewer than two rows, a number is not finite, times do not increase or a speed is not in
        the state space
    """

    times: Sequence[float]
    speeds: Sequence[float]
    name: str = "profile"
    v_max: float = PlatoonParameters.v_max

    def __post_init__(self) -> None:
        object.__setattr__(self, "times", tuple(self.times))
        object.__setattr__(self, "speeds", tuple(self.speeds))
        if not len(self.times) == len(self.speeds) >= 2:
            raise ModelError("profile_rows", self.name, min(len(self.times), len(self.speeds)))
        for number, (time, speed) in enumerate(zip(self.times, self.speeds, strict=True), start=1):
            if not isfinite(time):
                raise ModelError("finite", f"the time in row {number} of {self.name}", time, "s")
            if not isfinite(speed):
                raise ModelError("finite", f"the speed in row {number} of {self.name}", speed, "m/s")
            if speed < 0:
                raise ModelError("profile_backwards", speed, number, self.name, self.v_max)
            if speed > self.v_max:
                raise ModelError("profile_speed", speed, number, self.name, self.v_max)
        for number, (before, time) in enumerate(pairwise(self.times), start=2):
            if time <= before:
                raise ModelError("profile_time", time, number, self.name, before)

    def speed(self, time: float) -> float:
        """Speed of the leader [m/s].

        Parameters
        ----------
        time : since the start [s]
        """
        times, speeds = self.times, self.speeds
        k = bisect_right(times, time)
        if k in (0, len(times)):
            return speeds[0] if k == 0 else speeds[-1]
        return on_line(time, times[k - 1], times[k], speeds[k - 1], speeds[k])


def read_profile(path: Path, v_max: float = PlatoonParameters.v_max) -> Profile:
    """A speed profile from a CSV file: time [s] and speed [m/s] in two columns, below any comments (#) and one heading.

    Of more columns those that the heading calls time and speed count, or speed1 where there are several vehicles.  Time
    counts from the first row: recorded clocks begin anywhere.

    Parameters
    ----------
    path : the file
    v_max : largest speed of the state space [m/s]

    Raises
    ------
    ModelError : where the file cannot be read or is not such a table
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, ValueError) as error:
        raise ModelError("profile_file", path.name, getattr(error, "strerror", None) or "not UTF-8 text") from None
    return profile_of(text, path.name, v_max)


def profile_of(text: str, name: str = "profile", v_max: float = PlatoonParameters.v_max) -> Profile:
    """A speed profile from the text of such a file.

    Parameters
    ----------
    text : of the file
    name : for messages
    v_max : largest speed of the state space [m/s]

    Raises
    ------
    ModelError : where it is not such a table
    """
    lines = [(number, line.strip()) for number, line in enumerate(text.splitlines(), start=1)]
    filled = [(number, line) for number, line in lines if line and not line.startswith("#")]
    columns = _columns(filled[0][1]) if filled else None
    rows = []
    for place, (number, line) in enumerate(filled):
        try:
            cells = line.split(",")
            time, speed = map(float, cells if columns is None else (cells[column] for column in columns))
        except (ValueError, IndexError):
            if place == 0:
                continue  # the heading
            raise ModelError("profile_line", number, name, line[:40]) from None
        rows.append((time, speed))
    found = Profile([time for time, _ in rows], [speed for _, speed in rows], name, v_max)
    return replace(found, times=[time - found.times[0] for time in found.times])


def _columns(heading: str) -> tuple[int, int] | None:
    """Where time and speed stand in a table of more than two columns; None where the heading does not say."""
    names = [name.strip().strip('"').lower() for name in heading.split(",")]
    speed = next((name for name in ("speed", "speed1", "v") if name in names), None)
    return (names.index("time"), names.index(speed)) if len(names) > 2 and "time" in names and speed else None
