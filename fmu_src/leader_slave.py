"""The pythonfmu slave `PspLeader`: a leader's speed, to be the controller's desired speed."""

from __future__ import annotations

from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import Any

from psp_model.errors import ModelError
from psp_model.leader import Profile, Wave, read_profile

from .controller_variables import leader_table
from .table_slave import TableSlave, logged
from .variables import Variable

_SAVED = ("_values", "_start_time", "_time", "_initialising", "_ready")


class PspLeader(TableSlave):
    """A speed over time; see `psp_model.leader.Wave` and, with a file in the FMU, `psp_model.leader.Profile`."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._ready = False

    def _make_table(self) -> tuple[Variable, ...]:
        return leader_table("profile" in self._config)

    def _running(self) -> bool:
        return self._ready

    def _changed(self, inputs: bool) -> None:
        self._stale = True

    @cached_property
    def _profile(self) -> Profile:
        return read_profile(Path(self.resources) / self._config["profile"])

    def _speed(self, time: float) -> float:
        """What the parameters, and the file in the FMU if there is one, say [m/s]."""
        if "profile" in self._config:
            begin = self._value("begin")
            if not isfinite(begin):
                raise ModelError("finite", "begin", begin, "s")
            return self._profile.speed(time - begin)
        return Wave(*(self._value(name) for name in ("v_high", "v_low", "begin", "period"))).speed(time)

    @logged
    def exit_initialization_mode(self) -> None:
        self._speed(0.0)
        self._ready, self._initialising, self._stale = True, False, True

    @logged
    def do_step(self, current_time: float, step_size: float) -> bool:
        self._time, self._stale = current_time + step_size, True
        return True

    def _refresh(self) -> None:
        if self._ready or self._initialising:
            self._values[self._first_output] = self._speed(self._time - self._start_time)
            self._stale = False

    @logged
    def _get_fmu_state(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in _SAVED} | {"_values": tuple(self._values)}

    @logged
    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        for name in _SAVED:
            setattr(self, name, state[name])
        self._values, self._stale = list(state["_values"]), True
