"""Vehicles that join and leave on the way, for which the paper computes parameters on line."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from .errors import ModelError
from .law.controller import Controller
from .law.extended import Engaged, ExtendedLaw
from .law.potential import Potential
from .platoon import Observation, SampledPlatoon
from .sampling.loop import Loop, Vector, Verdict, resample, with_potential
from .sampling.period import room
from .state import read_only
from .vehicles.braking import Braking, brake_margin
from .vehicles.membership import taken

_PROBES = 100  # spacings that are tried for one that would be accepted
_TRUSTED = 5  # of these, how many are checked with the potential selected for them


@dataclass(frozen=True)
class Refusal:
    """Why a join or a leave is rejected.

    Attributes
    ----------
    sentence : problem and remedy
    spacing : a spacing at which the vehicle may join at this speed and time, NaN if there is none [m]
    """

    sentence: str
    spacing: float = np.nan


@dataclass(frozen=True)
class JoinMargin:
    """What joining asks for beside the certificate (ours).

    Attributes
    ----------
    brake_margin : least `brake_margin` of the platoon with the vehicle, 0 for none [m/s2]
    a_min : what its vehicles can brake with, below 0 [m/s2]
    """

    brake_margin: float = 0.0
    a_min: float = -8.0


@dataclass(frozen=True)
class _Joining:
    """A vehicle that wants to join, and the platoon that it sees.

    Attributes
    ----------
    seen : the platoon at that time
    at : the time, as period and fraction
    place : of the vehicle ahead, 0 for none
    spacing : to it, or with 0 to the old leader [m]
    speed, length : [m/s], [m]
    lengths : (n + 1,) of all vehicles with it [m]
    """

    seen: Observation
    at: tuple[int, float]
    place: int
    spacing: float
    speed: float
    length: float
    lengths: Vector

    @property
    def members(self) -> list[int | None]:
        """For each vehicle from here on its place before, counted from 0."""
        n = self.seen.v.size
        return [*range(self.place), None, *range(self.place, n)]


@dataclass(frozen=True)
class OpenPlatoon:
    """A platoon whose vehicles change; each change is a sampling instant and replans alpha, r, p (ours).

    Attributes
    ----------
    platoon : the vehicles there are, with their clock
    capacity : most vehicles N
    choose : the potential for new initial spacings (n-1,), with the lengths ahead taken for L, and speeds (n,), n >= 1
    vehicles : number of each vehicle, leader first; the first ones are 1 to n, later ones count on
    joined : vehicles there have been so far
    asked : what joining asks for beside the certificate
    """

    platoon: SampledPlatoon
    capacity: int
    choose: Callable[[Vector, Vector], Potential]
    vehicles: tuple[int, ...]
    joined: int
    asked: JoinMargin = JoinMargin()

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
        self, behind: float, spacing: float, speed: float, period: int, fraction: float, length: float = 0.0
    ) -> tuple[OpenPlatoon, Refusal | None]:
        """Let a vehicle join, if T is certified for the platoon with it, under any policy.

        Parameters
        ----------
        behind : place of the vehicle it joins behind, 1 for the leader; 0: it becomes the leader
        spacing : to the vehicle at that place, or with 0 to the old leader [m]
        speed : of the joining vehicle [m/s]
        period, fraction : the time, as `SampledPlatoon.take_over` takes it; instants up to it have been passed
        length : of the joining vehicle, 0 for L; other lengths need an `ExtendedLaw` [m]

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
            if not 0.0 <= length < np.inf:
                raise ModelError("insert_length", length)
        except ModelError as error:
            return self, Refusal(str(error))
        seen, length = self.platoon.observe(period, fraction), length or constants.L
        lengths = np.insert(self._lengths(), place, length)
        joining = _Joining(seen, (period, fraction), place, spacing, speed, length, lengths)
        with_it = self._certified(joining, True)
        if with_it is None or not self._can_brake(with_it):
            return self, self._what_would_do(joining, with_it is None)
        number = self.joined + 1
        vehicles = (*self.vehicles[:place], number, *self.vehicles[place:])
        return replace(self, platoon=with_it, joined=number, vehicles=vehicles), None

    def remove(self, place: float, period: int, fraction: float) -> tuple[OpenPlatoon, Refusal | None]:
        """Let a vehicle leave; only under policy 1 the certificate may object.

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
        members = [place for place in range(len(self.vehicles)) if place != gone]
        loop, memory = self._rearranged(members, self._lengths()[members])
        shape = self.choose(room(loop.controller, s), v)
        try:
            without = self.platoon.take_over(period, fraction, float(x[0]), s, v, shape, loop=loop, memory=memory)
        except ModelError as error:
            return self, Refusal(str(error))
        vehicles = self.vehicles[:gone] + self.vehicles[gone + 1 :]
        return replace(self, platoon=without, vehicles=vehicles), None

    def _place(self, name: str, place: float, first: int) -> int:
        if not (first <= place <= len(self.vehicles) and place == int(place)):
            raise ModelError("place", name, place, first, len(self.vehicles))
        return int(place)

    def _lengths(self) -> Vector:
        """Lengths of the vehicles, (n,) [m]."""
        law, n = self.platoon.loop.controller, len(self.vehicles)
        length = law.cooperation.length if isinstance(law, ExtendedLaw) else None
        return np.full(n, self.platoon.constants.L) if length is None else np.broadcast_to(length, (n,))

    def _rearranged(self, members: list[int | None] | list[int], lengths: Vector) -> tuple[Loop, object]:
        """Loop and memory for other vehicles."""
        loop, memory = self.platoon.loop, self.platoon.now.memory
        law: object = loop.controller
        if not isinstance(law, ExtendedLaw):
            return loop, None
        length = None if (lengths == law.constants.L).all() else read_only(lengths)
        if not (length is None and law.cooperation.length is None):
            law = replace(law, cooperation=replace(law.cooperation, length=length))
            loop = replace(loop, controller=cast(Controller[object], law))
        if isinstance(memory, Engaged):
            closing = None if memory.closing is None else taken(memory.closing, members)
            memory = Engaged(closing, memory.leader if members[0] == 0 else None)
        return loop, memory

    def _with(self, joining: _Joining) -> tuple[float, Vector, Vector] | None:
        """Leader's position, spacings and speeds with one more vehicle; None where vehicles would touch."""
        seen, place, spacing, L = joining.seen, joining.place, joining.spacing, self.platoon.constants.L
        v = np.insert(seen.v, place, joining.speed)
        x = float(seen.x[0]) + (spacing if place == 0 else 0.0)
        s = np.insert(seen.s, max(place - 1, 0), spacing)
        if 0 < place < len(self.vehicles):
            s[place] = s[place] - spacing
        return (x, s, v) if np.isfinite(spacing) and (s - (joining.lengths[:-1] - L) > L).all() else None

    def _certified(self, joining: _Joining, anew: bool) -> SampledPlatoon | None:
        """The platoon with one more vehicle if T is certified; with the potential in use unless chosen `anew`."""
        motion = self._with(joining)
        if motion is None:
            return None
        _, s, v = motion
        loop, memory = self._rearranged(joining.members, joining.lengths)
        if anew:
            loop = with_potential(loop, self.choose(room(loop.controller, s), v))
        now, verdict = resample(loop, self.platoon.now, joining.at, motion, memory)
        return replace(self.platoon, loop=loop, now=now) if verdict is Verdict.CERTIFIED else None

    def _can_brake(self, platoon: SampledPlatoon) -> bool:
        """Whether a platoon has the brake margin that joining asks for."""
        if not self.asked.brake_margin > 0.0:
            return True
        now, L = platoon.now, platoon.constants.L
        braking = Braking(now.v, now.a, 0.0, 0.0, self.asked.a_min)
        return bool(brake_margin(room(platoon.loop.controller, now.s) - L, braking) >= self.asked.brake_margin)

    def _may_join(self, joining: _Joining, anew: bool) -> bool:
        with_it = self._certified(joining, anew)
        return with_it is not None and self._can_brake(with_it)

    def _what_would_do(self, joining: _Joining, certificate: bool) -> Refusal:
        """The rejection of a join, with the nearest spacing found at which it may join."""
        constants, place, spacing = self.platoon.constants, joining.place, joining.spacing
        inside = 0 < place < len(self.vehicles)
        least = float(joining.lengths[max(place - 1, 0)])
        most = float(joining.seen.s[place - 1]) - joining.length if inside else least + 5 * constants.lam
        probes = np.linspace(least, most, _PROBES + 2)[1:-1] if most > least else np.empty(0)
        wanted = spacing if np.isfinite(spacing) else constants.lam
        found = []
        for probe in probes[np.argsort(abs(probes - wanted), kind="stable")].tolist():
            if self._may_join(replace(joining, spacing=probe), False):
                found.append(probe)
            if len(found) == _TRUSTED:
                break
        key, limit = "_margin", self.asked.brake_margin
        if certificate:
            key, limit = "_exact" if self.platoon.loop.exact else "", self.platoon.loop.T
        for probe in found:
            if self._may_join(replace(joining, spacing=probe), True):
                error = ModelError(f"insert_spacing{key}", place + 1, spacing, joining.speed, limit, probe)
                return Refusal(str(error), probe)
        return Refusal(str(ModelError(f"insert_none{key}", place + 1, spacing, joining.speed, limit)))


def _merged(s: Vector, gone: int) -> Vector:
    """Spacings after the vehicle at index `gone`, neither first nor last, has left."""
    return np.concatenate([s[: gone - 1], [s[gone - 1] + s[gone]], s[gone + 1 :]])
