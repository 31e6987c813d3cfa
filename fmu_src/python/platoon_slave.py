"""The pythonfmu slave `PspPlatoon`: a thin shim between FMI and `psp_model.SampledPlatoon`.

Nothing here raises: every failure is logged as one sentence with its status, and the launcher, the C library
around this slave, returns that status from the FMI call.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import inf, nextafter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from psp_model.errors import ModelError
from psp_model.law.cooperation import contact_spacing
from psp_model.law.extended import ExtendedLaw
from psp_model.law.potential import PotentialParameters
from psp_model.membership import OpenPlatoon, Refusal
from psp_model.platoon import SampledPlatoon
from psp_model.sampling.clock import Clock
from psp_model.sampling.period import exact_period_of, room
from psp_model.sampling.policy import Sampling
from psp_model.selection.feasible import require_feasible
from psp_model.selection.selectors import Selector, lies_in_domain, selector_for
from psp_model.validate import validate_law

from ..interface.meaning import constants_of, cooperation_of, join_margin_of, leader_of, start_of, weights_of
from ..interface.platoon import platoon_table
from ..interface.variables import Variable
from .network_files import networks_of
from .platoon_state import Description, Kept, Members, kept_of, restored
from .slave_state import SlaveState
from .table_slave import LONGEST, TableSlave, logged

Vector = NDArray[np.float64]


class PspPlatoon(TableSlave):
    """The closed loop of up to N vehicles as an FMI 2.0 co-simulation slave (design, section 3).

    Vehicles join and leave at the beginning of a communication step.
    """

    _part: SampledPlatoon | None

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._networks, self._trained = networks_of(Path(self.resources), self._config["networks"])
        self._in_domain = 0.0
        self._insert, self._remove = self._place["insert"], self._place["remove"]
        self._leader = slice(self._place["leader_automated"], self._place["leader_acceleration"] + 1)
        self._leader_told: list[float] = []  # the inputs of the leader when they were looked at last
        self._exact, self._exact_known = self._place["T_exact"], False  # whether T_exact in _values is up to date
        self._become(Members())

    def _become(self, members: Members) -> None:
        self._members, self._told = members, members.told(self.vehicles)

    def _make_table(self) -> tuple[Variable, ...]:
        return platoon_table(self.vehicles, self._config["default_source"])

    # initialisation

    def _describe(self) -> Description:
        """The settings given by the parameters, checked."""
        n, sampling, constants = self._chosen("n_start"), self._sampling(), constants_of(self._value)
        cooperation = cooperation_of(self._value, self._rows, n, constants.L)
        validate_law(cooperation, constants)
        asked = join_margin_of(self._value)
        start = start_of(self._value, n, constants, cooperation)
        request = self._request()
        if request.asks_network:
            if not self._networks:
                raise ModelError("no_network", n)
            require_feasible(request.fixed, start.constants)  # otherwise a later change might find no potential
        return Description(start, weights_of(self._value), sampling, request.old, cooperation, asked)

    def _initialise(self) -> SampledPlatoon:
        """The platoon that the parameters describe, at its first sampling instant."""
        described = self._describe()
        start, n, constants = described.start, described.start.v.size, described.start.constants
        leader = leader_of(self._value, constants.v_max)
        s = contact_spacing(start.s, described.cooperation, constants)
        selection = self._selector(described.sampling).select(s, start.v, constants)
        if selection.warning:
            self._warn(selection.warning)
        shape, sampling = selection.potential, described.sampling
        make = described.law(leader)
        platoon = SampledPlatoon.begin(start, shape, described.weights, sampling, self._warn, controller=make)
        self._in_domain = self._lies_in_domain(platoon)
        self._become(Members(tuple(range(1, n + 1)), n))
        return platoon

    def _selector(self, sampling: Sampling) -> Selector:
        """The selector of the potential for a new set of vehicles."""
        return selector_for(self._request(), self._networks, weights_of(self._value), sampling)

    def _lies_in_domain(self, platoon: SampledPlatoon) -> float:
        """1.0 if there is a network for this number of vehicles and they are in its training domain, else 0.0."""
        return float(lies_in_domain(self._trained, *_seen(platoon), platoon.constants))

    # a leader that drives itself

    def _take_leader(self) -> None:
        """Take what is told of the leader, from the last sampling instant on if the communication point is that one."""
        platoon, told = self._part, self._values[self._leader]
        if told == self._leader_told:
            return
        assert platoon is not None
        loop, now = platoon.loop, platoon.now
        law = loop.controller
        assert isinstance(law, ExtendedLaw)
        leader = leader_of(self._value, law.constants.v_max)
        self._leader_told = told
        if leader == law.leader:
            return
        loop = replace(loop, controller=replace(law, leader=leader))
        if self._clock.at() == (now.period, now.fraction):
            platoon.redecide(loop)
        else:
            platoon.loop = loop

    # joining and leaving

    def _make_changes(self) -> None:
        """Let a vehicle leave, then one join, if the triggers have risen."""
        before, values = self._members, self._values
        insert, remove = values[self._insert], values[self._remove]
        if insert == before.insert and remove == before.remove:
            return
        at = self._clock.at()
        if remove > 0.5 and not before.remove > 0.5:
            self._make(lambda road: road.remove(self._value("remove_place"), *at))
        if insert > 0.5 and not before.insert > 0.5:
            behind, spacing, speed, length = (
                self._value(f"insert_{name}") for name in ("behind", "gap", "speed", "length")
            )
            self._make(lambda road: road.insert(behind, spacing, speed, *at, length))
        self._become(replace(self._members, insert=insert, remove=remove))

    def _make(self, change: Callable[[OpenPlatoon], tuple[OpenPlatoon, Refusal | None]]) -> None:
        """Make a change or record why it was rejected."""
        platoon = self._part
        assert platoon is not None
        members, selector, warning = self._members, self._selector(platoon.sampling), None

        def choose(s: Vector, v: Vector) -> PotentialParameters:
            nonlocal warning
            selection = selector.select(s, v, platoon.constants)
            warning = selection.warning  # warnings of earlier trials are dropped
            return selection.potential

        asked = join_margin_of(self._value)
        road = OpenPlatoon(platoon, self.vehicles, choose, members.vehicles, members.joined, asked)
        road, refused = change(road)
        if refused:
            self._warn(refused.sentence)
            counted = replace(members, gap_offered=float(np.nan_to_num(refused.spacing)), refusals=members.refusals + 1)
            self._become(replace(counted, change_ok=0.0))
            return
        if warning:
            self._warn(warning)
        self._part, self._in_domain = road.platoon, self._lies_in_domain(road.platoon)
        counted = replace(members, vehicles=road.vehicles, joined=road.joined, changes=members.changes + 1)
        self._become(replace(counted, change_ok=1.0))

    # time

    @logged
    def do_step(self, current_time: float, step_size: float) -> bool:
        self._require_here(current_time, step_size)
        if step_size > 0.0:
            self._stale = True
            self._take_leader()
            self._make_changes()
        platoon = self._part
        assert platoon is not None
        before = self._clock
        self._stale = True
        try:
            self._clock = before.after(current_time, step_size, platoon.sampling.T)
            platoon.advance_to(*self._clock.at())
        except ModelError as error:
            if platoon.partway is not None:  # the outputs then show the last valid instant
                platoon.now = platoon.partway
                self._clock = _gone_back(platoon, before, current_time)
                return self._discard(error)
            # the outputs then show the rejected instant
            self._clock = self._clock._replace(period=platoon.now.period, offset=platoon.now.fraction)
            raise
        return True

    def _outputs(self, platoon: SampledPlatoon) -> list[float]:
        seen = platoon.observe(*self._clock.at())
        parts = [part.tolist() for part in (seen.x, seen.v, seen.a, seen.s)]
        if missing := [0.0] * (self.vehicles - seen.v.size):
            parts = [part + missing for part in parts]
        reported = self._reported(platoon, seen.cost.tolist())
        return [value for part in (*parts, reported, self._told) for value in part]

    def _reported(self, platoon: SampledPlatoon, cost: list[float]) -> list[float]:
        """The outputs after the motion, in the order of the table."""
        now, shape = platoon.now, platoon.shape
        assert isinstance(shape, PotentialParameters)
        of_acceleration, of_spacings = cost
        T, self._exact_known = platoon.sampling.T, now.T_exact is not None
        lemma1 = (min(now.T_max, LONGEST), float(now.T_max > T))
        verdict = (min(now.T_exact or 0.0, LONGEST), float(now.bound > T), float(now.violations))
        reports = (shape.alpha, shape.r, shape.p, self._in_domain, *lemma1, *verdict)
        return [*reports, of_acceleration + of_spacings, of_acceleration, of_spacings]

    def _get(self, references: list[int], integer: bool) -> list[float]:
        """The values; T_exact takes long, and is computed where it is read unless a verdict depends on it."""
        values, platoon = super()._get(references, integer), self._part
        if self._exact_known or platoon is None or self._exact not in references:
            return values
        now = platoon.now
        found = exact_period_of(platoon.loop.controller, now.vehicles, now.a, now.memory)
        self._values[self._exact] = min(float(found), LONGEST)
        self._exact_known = True
        return super()._get(references, integer)

    # the whole state

    def _kept(self, platoon: SampledPlatoon) -> Kept:
        return kept_of(platoon, self._members, self._in_domain)

    def _taken_up(self, kept: Kept) -> SampledPlatoon:
        self._in_domain, self._leader_told = kept.in_domain, []
        self._become(kept.members)
        return SampledPlatoon(kept.loop, kept.sampling, kept.now, self._warn)

    def _become_state(self, state: SlaveState) -> None:
        self._in_domain = 0.0
        self._become(Members())
        super()._become_state(state)

    def _restored(self, data: Any, here: Clock) -> Kept:
        return restored(data, here, self.vehicles, self._describe())


def _seen(platoon: SampledPlatoon) -> tuple[Vector, Vector]:
    """Spacings, with the lengths ahead taken for L, and speeds."""
    return room(platoon.loop.controller, platoon.now.s), platoon.now.v


def _gone_back(platoon: SampledPlatoon, before: Clock, begin: float) -> Clock:
    """The clock at the last instant, at a time to which a step from `begin` passes that instant despite rounding.

    An instant just after a nominal one, as with policy 3, may have no representable time of its own.
    """
    now, T, (period, fraction) = platoon.now, platoon.sampling.T, before.at()
    time = before.time + (now.period - period + (now.fraction - fraction)) * T
    for _ in range(5):
        clock = before.after(begin, time - begin, T)
        if clock.at() >= (now.period, now.fraction):
            break
        time = nextafter(time, inf)
    return clock
