"""The pythonfmu slave `PspLeader`: a leader's speed, to be the controller's desired speed."""

from __future__ import annotations

from typing import Any

from psp_model.leader import Wave

from .controller_variables import leader_table
from .table_slave import TableSlave, logged
from .variables import Variable

_SAVED = ("_values", "_start_time", "_time", "_initialising", "_ready")


class PspLeader(TableSlave):
    """A speed over time; see `psp_model.leader.Wave`."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._ready = False

    def _make_table(self) -> tuple[Variable, ...]:
        return leader_table()

    def _running(self) -> bool:
        return self._ready

    def _changed(self, inputs: bool) -> None:
        self._stale = True

    def _wave(self) -> Wave:
        return Wave(*(self._value(name) for name in ("v_high", "v_low", "begin", "period")))

    @logged
    def exit_initialization_mode(self) -> None:
        self._wave()
        self._ready, self._initialising, self._stale = True, False, True

    @logged
    def do_step(self, current_time: float, step_size: float) -> bool:
        self._time, self._stale = current_time + step_size, True
        return True

    def _refresh(self) -> None:
        if self._ready or self._initialising:
            self._values[self._first_output] = self._wave().speed(self._time - self._start_time)
            self._stale = False

    @logged
    def _get_fmu_state(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in _SAVED} | {"_values": tuple(self._values)}

    @logged
    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        for name in _SAVED:
            setattr(self, name, state[name])
        self._values, self._stale = list(state["_values"]), True
