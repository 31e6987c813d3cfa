"""The pythonfmu slave `PspLeader`: a leader's speed, to be the controller's desired speed."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import Any

from psp_model.errors import ModelError
from psp_model.sampling.clock import Clock
from psp_model.vehicles.leader import Profile, Wave, read_profile

from ..interface.leader import leader_table
from ..interface.variables import Variable
from .state_check import flag, record, restored_basics
from .table_slave import TableSlave, logged

_SAVED = ("_values", "_clock", "_initialising")
_SECOND = 1.0  # [s] the period of its clock: it samples nothing, but meets whole seconds as others meet instants


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

    def _state(self) -> dict[str, Any]:
        state = {name: getattr(self, name) for name in _SAVED} | {"_values": tuple(self._values)}
        return state | {"ready": self._part is not None}

    def _become_state(self, state: dict[str, Any]) -> None:
        for name in _SAVED:
            setattr(self, name, state[name])
        self._values, self._clock, self._stale = list(state["_values"]), Clock(*state["_clock"]), True
        self._part = self._initialise() if state["ready"] else None

    @staticmethod
    def _as_json(state: dict[str, Any]) -> dict[str, Any]:
        return state

    def _restore(self, data: Any) -> dict[str, Any]:
        state = record(data, (*_SAVED, "ready"))
        found = restored_basics(state, self._integers) | {"ready": flag(state["ready"])}
        if found["ready"]:
            with self._with_values(found["_values"]):
                self._initialise()  # raises where the parameters cannot have been taken
        return found
