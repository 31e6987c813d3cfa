"""The pythonfmu slave `PspPlant`: vehicles to test a controller with."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import isfinite
from typing import Any

from psp_model.errors import ModelError
from psp_model.sampling.clock import Clock
from psp_model.vehicles.actuation import Actuators
from psp_model.vehicles.delayed import Delayed
from psp_model.vehicles.road_plant import LONGEST_DEAD_TIME, RoadPlant

from ..interface.plant import plant_table
from ..interface.road import plant_of
from ..interface.variables import Variable
from .slave_state import IN_MEMORY
from .state_check import count, number, record, require, vector
from .table_slave import TableSlave, logged


@dataclass(frozen=True, eq=False)
class _Kept:
    """What a state keeps of a plant.

    Attributes
    ----------
    now, period : as the plant has them
    plant : with what the parameters say
    """

    now: Delayed
    period: int
    plant: RoadPlant = field(metadata=IN_MEMORY)


class PspPlant(TableSlave):
    """n vehicles; see `psp_model.RoadPlant`."""

    _part: RoadPlant | None

    def _make_table(self) -> tuple[Variable, ...]:
        return plant_table(self.vehicles)

    def _initialise(self) -> RoadPlant:
        return plant_of(self._value, self.vehicles)

    def _input(self, name: str, unit: str) -> list[float]:
        """The values of an input of all vehicles, finite."""
        values = self._numbers(name, 1, self.vehicles)
        for i, value in enumerate(values, start=1):
            if not isfinite(value):
                raise ModelError("finite", f"{name}[{i}]", value, unit)
        return values

    @logged
    def do_step(self, current_time: float, step_size: float) -> bool:
        self._require_here(current_time, step_size)
        plant = self._part
        assert plant is not None
        a, automated = self._input("a", "m/s2"), self._input("automated", "1")
        self._clock = self._clock.after(current_time, step_size, plant.T)
        self._part = plant.advanced_to(self._clock.at()[0], a, automated)
        self._stale = True
        return True

    def _outputs(self, plant: RoadPlant) -> list[float]:
        now = plant.now
        seen = (plant.positions(), now.v, now.s, plant.clearances(), plant.accelerations())
        return [value for group in seen for value in group.tolist()]

    # the whole state

    def _kept(self, plant: RoadPlant) -> _Kept:
        return _Kept(plant.now, plant.period, plant)

    def _taken_up(self, kept: _Kept) -> RoadPlant:
        return replace(kept.plant, now=kept.now, period=kept.period)

    def _restored(self, data: Any, here: Clock) -> _Kept:
        kept, plant = record(data, ("now", "period")), self._initialise()
        period = count(kept["period"])
        require(abs(here.period - period) <= 2)
        return _Kept(_moving(kept["now"], plant), period, plant)


def _moving(data: Any, plant: RoadPlant) -> Delayed:
    """Where the vehicles are and what their actuators do, every field checked."""
    n, now = plant.now.v.size, record(data, Delayed._fields)
    v = vector(now["v"], n)
    require(bool((v >= 0.0).all()))
    return Delayed(number(now["x"]), vector(now["s"], n - 1), v, _acting(now["actuators"], plant))


def _acting(data: Any, plant: RoadPlant) -> Actuators:
    n, kept = plant.now.v.size, record(data, Actuators._fields)
    queue = kept["queue"]
    require(isinstance(queue, list) and len(queue) <= (0 if plant.is_ideal else LONGEST_DEAD_TIME + 1))
    found, before = [], 0.0
    for row in queue:
        require(isinstance(row, list) and len(row) == 2)
        due = number(row[0])
        require(before < due <= plant.actuation.actuation_delay)
        found.append((due, vector(row[1], n)))
        before = due
    return Actuators(vector(kept["a"], n), vector(kept["command"], n), tuple(found))
