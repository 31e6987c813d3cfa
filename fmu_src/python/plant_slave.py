"""The pythonfmu slave `PspPlant`: ideal vehicles to try a controller on."""

from __future__ import annotations

from math import nextafter
from sys import float_info
from typing import Any

import numpy as np

from psp_model.errors import ModelError
from psp_model.parameters import PlatoonParameters
from psp_model.sampling.clock import Clock
from psp_model.sampling.hold import Motion
from psp_model.sampling.policy import Sampling
from psp_model.state import PlatoonState
from psp_model.validate import validate
from psp_model.vehicles.ideal import IdealPlant

from ..interface.plant import plant_table
from ..interface.variables import Variable
from .state_check import count, fresh, number, record, require, restored_basics, vector
from .table_slave import TableSlave, logged

_LEAST, _MOST = nextafter(0.0, 1.0), float_info.max
_SAVED = ("_values", "_clock", "_initialising")


class PspPlant(TableSlave):
    """n double integrators; see `psp_model.IdealPlant`."""

    _part: IdealPlant | None

    def _make_table(self) -> tuple[Variable, ...]:
        return plant_table(self.vehicles)

    def _initialise(self) -> IdealPlant:
        n, free = self.vehicles, PlatoonParameters(L=_LEAST, v_max=_MOST)  # nothing but order and motion forward
        gaps, speeds = np.array(self._numbers("s_start", 2, n)), np.array(self._numbers("v_start", 1, n))
        start = validate(PlatoonState(gaps, speeds, free, self._value("x_start")))
        return IdealPlant.begin(start, validate(Sampling(self._value("T"))).T)

    @logged
    def do_step(self, current_time: float, step_size: float) -> bool:
        self._require_here(current_time, step_size)
        plant = self._part
        assert plant is not None
        a = np.array(self._numbers("a", 1, self.vehicles))
        for i in np.flatnonzero(~np.isfinite(a)).tolist():
            raise ModelError("finite", f"a[{i + 1}]", a[i], "m/s2")
        self._clock = self._clock.after(current_time, step_size, plant.T)
        self._part = plant.advanced_to(self._clock.at()[0], a)
        self._stale = True
        return True

    def _outputs(self, plant: IdealPlant) -> list[float]:
        seen = plant.now
        return [*seen.positions().tolist(), *seen.v.tolist(), *seen.s.tolist()]

    # the whole state

    def _state(self) -> dict[str, Any]:
        state = {name: getattr(self, name) for name in _SAVED} | {"_values": tuple(self._values)}
        plant = self._part and {"T": self._part.T, "period": self._part.period, "now": _pack(self._part.now)}
        return state | {"plant": plant}

    def _become_state(self, state: dict[str, Any]) -> None:
        for name in _SAVED:
            setattr(self, name, state[name])
        self._values, self._stale, plant = list(state["_values"]), True, state["plant"]
        self._clock = Clock(*state["_clock"])
        self._part = plant and IdealPlant(_unpack(plant["now"]), plant["T"], plant["period"])

    @staticmethod
    def _as_json(state: dict[str, Any]) -> dict[str, Any]:
        return state

    def _restore(self, data: Any) -> dict[str, Any]:
        state = record(data, (*_SAVED, "plant"))
        found = restored_basics(state, self._integers)
        if state["plant"] is None:
            fresh(found["_clock"])
            return found | {"plant": None}
        plant = record(state["plant"], ("T", "period", "now"))
        now, T, period = record(plant["now"], ("x", "s", "v")), number(plant["T"]), count(plant["period"])
        require(T > 0.0 and abs(found["_clock"].period - period) <= 2)
        n = self.vehicles
        number(now["x"]), vector(now["s"], n - 1), vector(now["v"], n)
        return found | {"plant": plant}


def _pack(motion: Motion) -> dict[str, Any]:
    return {"x": motion.x, "s": motion.s.tolist(), "v": motion.v.tolist()}


def _unpack(packed: dict[str, Any]) -> Motion:
    return Motion(packed["x"], np.array(packed["s"]), np.array(packed["v"]))
