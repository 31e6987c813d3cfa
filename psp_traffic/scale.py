"""Many platoons in one SUMO run: the cost of the controller compared with SUMO's own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any, ClassVar

import numpy as np

from psp_model.state import StartDomain

from .controller_fmu import ControllerFmu, Fleet, Vector
from .driver import Driver
from .errors import TrafficError
from .road import write_road, write_vehicles
from .scenario import ROAD_END, Scenario
from .simulation import running_sumo

SIZE, SPACING = 10, 250.0  # vehicles in a platoon; [m] between leaders


@dataclass(frozen=True)
class Cost:
    """Wall time of one run.

    Attributes
    ----------
    vehicles, steps : in the run
    sumo, exchange, controller : [s] in SUMO's step, in reading and setting its vehicles, in the FMUs
    """

    vehicles: int
    steps: int
    sumo: float
    exchange: float
    controller: float

    PARTS: ClassVar = ("sumo", "exchange", "controller")

    @property
    def total(self) -> float:
        """All of it [s]."""
        return self.sumo + self.exchange + self.controller

    @property
    def rate(self) -> float:
        """Thousand vehicle-steps per second."""
        return 1e-3 * self.vehicles * self.steps / self.total


def many(platoons: int, road_end: float) -> Scenario:
    """Platoons one behind the other.

    Parameters
    ----------
    platoons : how many
    road_end : where the road ends [m]
    """
    s, v = StartDomain().draw(np.random.default_rng(1), SIZE, platoons)
    spacings = np.concatenate([np.r_[SPACING - s[:, k].sum(), s[:, k]] for k in range(platoons)])
    start = platoons * SPACING + 100.0
    if start > road_end - 1000.0:
        raise TrafficError(f"{platoons} platoons do not fit on a road of {road_end:g} m", "put fewer on it")
    return Scenario("many", spacings[1:], v.T.ravel(), x_leader=start)


def cost(platoons: int, steps: int, driver: Driver, *, exchange: bool = False, step: float = 0.01) -> Cost:
    """Run platoons of ten for some steps and measure the time of each part.

    Parameters
    ----------
    platoons, steps : how many
    driver : the controller, or a model of SUMO's, which then drives alone
    exchange : every vehicle is read and its speed set, as for the controller, but no command is computed: what a
        controller outside SUMO costs at least
    step : of SUMO [s]
    """
    scenario = many(platoons, ROAD_END)
    with TemporaryDirectory() as name:
        folder = Path(name)
        vehicles = write_vehicles(folder, scenario, driver)
        with running_sumo(write_road(folder, scenario), vehicles, step, 1, False) as sumo:
            sumo.simulationStep()
            names = [str(i) for i in range(scenario.v.size)]
            for one in names:
                sumo.vehicle.setLaneChangeMode(one, 0)
                if driver.fmu is None and not exchange:
                    sumo.vehicle.setMaxSpeed(one, scenario.v_star)
                else:
                    sumo.vehicle.setSpeedMode(one, 0)
            if exchange:
                return _with_exchange(sumo, names, lambda s, v, time: (scenario.v_star - v) / step, steps, step)
            if driver.fmu is None:
                return _of_sumo(sumo, len(names), steps)
            fleet = Fleet(ControllerFmu(driver.fmu, folder / "fmu"), platoons, driver.parameters, step)
            found = _with_exchange(sumo, names, fleet.command, steps, step)
            fleet.close()
            return found


def _of_sumo(sumo: Any, vehicles: int, steps: int) -> Cost:
    begin = perf_counter()
    for _ in range(steps):
        sumo.simulationStep()
    return Cost(vehicles, steps, perf_counter() - begin, 0.0, 0.0)


def _with_exchange(
    sumo: Any, names: list[str], decide: Callable[[Vector, Vector, float], Vector], steps: int, step: float
) -> Cost:
    """Read all vehicles, decide from spacings, speeds and time, set all speeds, and let SUMO step.

    Positions come from the distance driven, which is cheaper to read from SUMO than the position on the map.
    """
    of_sumo = of_exchange = of_controllers = 0.0
    driven, speed_of, set_speed = sumo.vehicle.getDistance, sumo.vehicle.getSpeed, sumo.vehicle.setSpeed
    begins = np.array([sumo.vehicle.getPosition(name)[0] - driven(name) for name in names])
    for k in range(steps):
        begin = perf_counter()
        x = (begins + list(map(driven, names))).reshape(-1, SIZE)
        v = np.array(list(map(speed_of, names))).reshape(-1, SIZE)
        read = perf_counter()
        a = decide(x[:, :-1] - x[:, 1:], v, k * step)
        decided = perf_counter()
        for name, speed in zip(names, (v + step * a).ravel().tolist(), strict=True):
            set_speed(name, speed)
        written = perf_counter()
        sumo.simulationStep()
        of_sumo += perf_counter() - written
        of_exchange += read - begin + written - decided
        of_controllers += decided - read
    return Cost(len(names), steps, of_sumo, of_exchange, of_controllers)
