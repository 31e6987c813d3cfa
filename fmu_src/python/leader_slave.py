"""The pythonfmu slave `PspLeader`: a leader's speed, to be the controller's desired speed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import Any

from psp_model.errors import ModelError
from psp_model.sampling.clock import Clock
from psp_model.vehicles.leader import Profile, Wave, read_profile

from ..interface.leader import leader_table
from ..interface.variables import Variable
from .slave_state import IN_MEMORY
from .state_check import record
from .table_slave import TableSlave, logged

_SECOND = 1.0  # [s] the period of its clock: it samples nothing, but meets whole seconds as others meet instants


@dataclass(frozen=True)
class _Ready:
    """What a state keeps of a leader: that there is one.

    Attributes
    ----------
    speed : what the parameters say
    """

    speed: Callable[[float], float] = field(metadata=IN_MEMORY)


class PspLeader(TableSlave):
    """A speed over time; see `Wave` and, with a file in the FMU, `Profile` in `psp_model.vehicles.leader`."""

    _part: Callable[[float], float] | None

    def _make_table(self) -> tuple[Variable, ...]:
        return leader_table("profile" in self._config)

    @cached_property
    def _profile(self) -> Profile:
        return read_profile(Path(self.resources) / self._config["profile"])

    def _initialise(self) -> Callable[[float], float]:
        """The speed [m/s] over the time since the start [s]."""
        if "profile" not in self._config:
            return Wave(*(self._value(name) for name in ("v_high", "v_low", "begin", "period"))).speed
        begin, profile = self._value("begin"), self._profile
        if not isfinite(begin):
            raise ModelError("finite", "begin", begin, "s")
        return lambda time: profile.speed(time - begin)

    def _outputs(self, speed: Callable[[float], float]) -> list[float]:
        return [speed((self._clock.period + self._clock.offset) * _SECOND)]

    @logged
    def do_step(self, current_time: float, step_size: float) -> bool:
        self._require_here(current_time, step_size)
        self._clock, self._stale = self._clock.after(current_time, step_size, _SECOND), True
        return True

    # the whole state: nothing but the time and what the parameters say

    def _kept(self, speed: Callable[[float], float]) -> _Ready:
        return _Ready(speed)

    def _taken_up(self, kept: _Ready) -> Callable[[float], float]:
        return kept.speed

    def _restored(self, data: Any, here: Clock) -> _Ready:
        record(data, ())
        return _Ready(self._initialise())  # raises where the parameters cannot have been taken
