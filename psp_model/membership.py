"""Vehicles that join and leave on the way, for which the paper computes parameters on line."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .errors import ModelError
from .law.potential import Potential
from .platoon import Observation, SampledPlatoon
from .sampling.loop import Vector, Verdict, resample, with_potential

_PROBES = 100  # spacings that are tried for one that would be accepted
_TRUSTED = 5  # of these, how many are checked with the potential selected for them


@dataclass(frozen=True)
class Refusal:
    """Why a join or a leave is rejected.

    Attributes
    ----------
    sentence : problem and remedy
    gap : a spacing at which the vehicle may join at this speed and time, NaN if there is none [m]
    """

    sentence: str
    gap: float = np.nan


@dataclass(frozen=True)
class OpenPlatoon:
    """A platoon whose vehicles change; each change is a sampling instant and replans alpha, r, p (ours).

    Attributes
    ----------
    platoon : the vehicles there are, with their clock
    capacity : most vehicles N
    choose : the potential for new initial spacings (n-1,) and speeds (n,), n >= 1
    vehicles : number of each vehicle, leader first; the first ones are 1 to n, later ones count on
    joined : vehicles there have been so far
    """

    platoon: SampledPlatoon
    capacity: int
    choose: Callable[[Vector, Vector], Potential]
    vehicles: tuple[int, ...]
    joined: int

    @classmethod
    def begin(
        cls, platoon: SampledPlatoon, capacity: int, choose: Callable[[Vector, Vector], Potential]
    ) -> OpenPlatoon:
        """A platoon before the first change.

        Parameters
        ----------
        platoon, capacity, choose : as the attributes
        """
        n = platoon.now.v.size
        return cls(platoon, capacity, choose, tuple(range(1, n + 1)), n)

    def insert(
        self, behind: float, gap: float, speed: float, period: int, fraction: float
    ) -> tuple[OpenPlatoon, Refusal | None]:
        """Let a vehicle join, if Lemma 1 certifies T for the platoon with it, under any policy.

        Parameters
        ----------
        behind : place of the vehicle it joins behind, 1 for the leader; 0: it becomes the leader
        gap : to the vehicle at that place, or with 0 to the old leader [m]
        speed : of the joining vehicle [m/s]
        period, fraction : the time, as `SampledPlatoon.take_over` takes it; instants up to it have been passed

        Returns
        -------
        the platoon with it and None, or this platoon and why it is rejected
        """
        n, constants = len(self.vehicles), self.platoon.constants
        try:
            place = self._place("insert_behind", behind, 0)
            if n == self.capacity:
                raise ModelError("full", self.capacity)
            if not np.isfinite(speed):
                raise ModelError("insert_finite", speed, constants.v_max)
            if speed < 0:
                raise ModelError("insert_backwards", speed, constants.v_max)
            if speed > constants.v_max:
                raise ModelError("insert_speed", speed, constants.v_max)
        except ModelError as error:
            return self, Refusal(str(error))
        seen = self.platoon.observe(period, fraction)
        with_it = self._certified(seen, place, gap, speed, period, fraction, True)
        if with_it is None:
            return self, self._what_would_do(seen, place, gap, speed, period, fraction)
        number = self.joined + 1
        vehicles = (*self.vehicles[:place], number, *self.vehicles[place:])
        return replace(self, platoon=with_it, joined=number, vehicles=vehicles), None

    def remove(self, place: float, period: int, fraction: float) -> tuple[OpenPlatoon, Refusal | None]:
        """Let a vehicle leave; only under policy 1 Lemma 1 may object.

        Parameters
        ----------
        place : of the vehicle, 1 for the leader
        period, fraction : the time, as for `insert`

        Returns
        -------
        the platoon without it and None, or this platoon and why it is rejected
        """
        try:
            gone = self._place("remove_place", place, 1) - 1
            if len(self.vehicles) == 1:
                raise ModelError("last")
        except ModelError as error:
            return self, Refusal(str(error))
        seen = self.platoon.observe(period, fraction)
        x, v = np.delete(seen.x, gone), np.delete(seen.v, gone)
        s = seen.s[1:] if gone == 0 else seen.s[:-1] if gone == len(self.vehicles) - 1 else _merged(seen.s, gone)
        shape = self.choose(s, v)
        try:
            without = self.platoon.take_over(period, fraction, float(x[0]), s, v, shape)
        except ModelError as error:
            return self, Refusal(str(error))
        vehicles = self.vehicles[:gone] + self.vehicles[gone + 1 :]
        return replace(self, platoon=without, vehicles=vehicles), None

    def _place(self, name: str, place: float, first: int) -> int:
        if not (first <= place <= len(self.vehicles) and place == int(place)):
            raise ModelError("place", name, place, first, len(self.vehicles))
        return int(place)

    def _with(self, seen: Observation, place: int, gap: float, speed: float) -> tuple[float, Vector, Vector] | None:
        """Leader's position, spacings and speeds with one more vehicle; None where a spacing would not exceed L."""
        L = self.platoon.constants.L
        v = np.insert(seen.v, place, speed)
        x = float(seen.x[0]) + (gap if place == 0 else 0.0)
        s = np.insert(seen.s, max(place - 1, 0), gap)
        if 0 < place < len(self.vehicles):
            s[place] = s[place] - gap
        return (x, s, v) if np.isfinite(gap) and (s > L).all() else None

    def _certified(
        self, seen: Observation, place: int, gap: float, speed: float, period: int, fraction: float, anew: bool
    ) -> SampledPlatoon | None:
        """The platoon with one more vehicle if T is certified; with the potential in use unless chosen `anew`."""
        motion = self._with(seen, place, gap, speed)
        if motion is None:
            return None
        _, s, v = motion
        loop = with_potential(self.platoon.loop, self.choose(s, v)) if anew else self.platoon.loop
        now, verdict = resample(loop, self.platoon.now, (period, fraction), motion)
        return replace(self.platoon, loop=loop, now=now) if verdict is Verdict.CERTIFIED else None

    def _what_would_do(
        self, seen: Observation, place: int, gap: float, speed: float, period: int, fraction: float
    ) -> Refusal:
        """The rejection of a join, with the nearest spacing found at which it may join."""
        constants, T = self.platoon.constants, self.platoon.loop.T
        inside = 0 < place < len(self.vehicles)
        room = float(seen.s[place - 1]) - constants.L if inside else constants.L + 5 * constants.lam
        probes = np.linspace(constants.L, room, _PROBES + 2)[1:-1] if room > constants.L else np.empty(0)
        wanted = gap if np.isfinite(gap) else constants.lam
        found = []
        for probe in probes[np.argsort(abs(probes - wanted), kind="stable")].tolist():
            if self._certified(seen, place, probe, speed, period, fraction, False) is not None:
                found.append(probe)
            if len(found) == _TRUSTED:
                break
        for probe in found:
            if self._certified(seen, place, probe, speed, period, fraction, True) is not None:
                return Refusal(str(ModelError("insert_gap", place + 1, gap, speed, T, probe)), probe)
        return Refusal(str(ModelError("insert_none", place + 1, gap, speed, T)))


def _merged(s: Vector, gone: int) -> Vector:
    """Spacings after the vehicle at index `gone`, neither first nor last, has left."""
    return np.concatenate([s[: gone - 1], [s[gone - 1] + s[gone]], s[gone + 1 :]])
