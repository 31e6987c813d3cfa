"""The pythonfmu slave `PspLeader`: a leader's speed, to be the controller's desired speed, or the first vehicle's."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import Any

from psp_model.errors import ModelError
from psp_model.sampling.clock import Clock
from psp_model.sampling.policy import Sampling
from psp_model.validate import validate
from psp_model.vehicles.leader import LeaderSpeed, Profile, Wave, held_for, read_profile

from ..interface.leader import leader_table
from ..interface.variables import Variable
from .slave_state import IN_MEMORY
from .state_check import record
from .table_slave import TableSlave, logged

_SECOND = 1.0  # [s] the period of its clock: it samples nothing, but meets whole seconds as others meet instants


@dataclass(frozen=True)
class _Driving:
    """A leader as the parameters say; a state keeps of it that there is one.

    Attributes
    ----------
    leader : the speed over the time since `begin`
    begin : when that time is 0, since the start [s]
    T : for how long an acceleration is held [s]
    """

    leader: LeaderSpeed = field(metadata=IN_MEMORY)
    begin: float = field(metadata=IN_MEMORY)
    T: float = field(metadata=IN_MEMORY)

    def speed(self, time: float) -> float:
        """Speed [m/s] at a time since the start [s]."""
        return self.leader.speed(time - self.begin)


class PspLeader(TableSlave):
    """A speed over time; see `Wave` and, with a file in the FMU, `Profile` in `psp_model.vehicles.leader`."""

    _part: _Driving | None

    def _make_table(self) -> tuple[Variable, ...]:
        return leader_table("profile" in self._config)

    @cached_property
    def _profile(self) -> Profile:
        return read_profile(Path(self.resources) / self._config["profile"])

    def _initialise(self) -> _Driving:
        T = validate(Sampling(self._value("T"))).T
        if "profile" not in self._config:
            wave = Wave(*(self._value(name) for name in ("v_high", "v_low", "begin", "period")))
            return _Driving(wave, 0.0, T)
        begin, profile = self._value("begin"), self._profile
        if not isfinite(begin):
            raise ModelError("finite", "begin", begin, "s")
        return _Driving(profile, begin, T)

    def _outputs(self, driving: _Driving) -> list[float]:
        time = (self._clock.period + self._clock.offset) * _SECOND
        now, later = driving.speed(time), driving.speed(time + driving.T)
        return [now, held_for(now, later, driving.T), 0.0]  # and nothing is commanded to him

    @logged
    def do_step(self, current_time: float, step_size: float) -> bool:
        self._require_here(current_time, step_size)
        self._clock, self._stale = self._clock.after(current_time, step_size, _SECOND), True
        return True

    # the whole state: nothing but the time and what the parameters say

    def _kept(self, driving: _Driving) -> _Driving:
        return driving

    def _taken_up(self, kept: _Driving) -> _Driving:
        return kept

    def _restored(self, data: Any, here: Clock) -> _Driving:
        record(data, ())
        return self._initialise()  # raises where the parameters cannot have been taken
