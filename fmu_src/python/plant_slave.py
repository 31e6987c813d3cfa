"""The pythonfmu slave `PspPlant`: ideal vehicles to test a controller with."""

from __future__ import annotations

from copy import copy
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
from .state_check import count, number, record, require, vector
from .table_slave import TableSlave, logged

_LEAST, _MOST = nextafter(0.0, 1.0), float_info.max


class PspPlant(TableSlave):
    """n double integrators; see `psp_model.IdealPlant`."""

    _part: IdealPlant | None

    def _make_table(self) -> tuple[Variable, ...]:
        return plant_table(self.vehicles)

    def _initialise(self) -> IdealPlant:
        n, free = self.vehicles, PlatoonParameters(L=_LEAST, v_max=_MOST)  # only order and forward motion are required
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

    def _kept(self, plant: IdealPlant) -> IdealPlant:
        return copy(plant)

    def _taken_up(self, kept: IdealPlant) -> IdealPlant:
        return copy(kept)

    def _restored(self, data: Any, here: Clock) -> IdealPlant:
        plant, n = record(data, IdealPlant.__dataclass_fields__), self.vehicles
        now, T, period = record(plant["now"], Motion._fields), number(plant["T"]), count(plant["period"])
        require(T > 0.0 and abs(here.period - period) <= 2)
        return IdealPlant(Motion(number(now["x"]), vector(now["s"], n - 1), vector(now["v"], n)), T, period)
