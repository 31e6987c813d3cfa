"""One run of a scenario in SUMO."""

from __future__ import annotations

import io
import warnings
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .controller_fmu import ControllerFmu, Platoon, Vector
from .driver import Driver
from .road import sumo_home, through_lanes, write_road, write_vehicles
from .scenario import LENGTH, Scenario

_STAY, _CHANGE = 0, 1621  # lane change modes: only on command; SUMO's default
JOIN_ROOM, LANE_CHANGE_ROOM = 1.0, 3.0  # [m] free behind and ahead beyond L: to be counted in, to change lanes

_EASE = 1.0  # [m/s2] at which SUMO's drivers that start faster than v_star are slowed to it
_DESIRED = (0.0, 35.0)  # [m/s] desired speeds are between 0 and v_max


@dataclass(frozen=True)
class Disturbance:
    """The disturbance between the controller and the vehicles.

    Attributes
    ----------
    delay : age of what is measured [s], in whole steps
    lag : time constant of the actuators [s]
    ballistic : SUMO's ballistic instead of its Euler step
    """

    delay: float = 0.0
    lag: float = 0.0
    ballistic: bool = False


@dataclass(frozen=True, eq=False)
class Record:
    """What happened; vehicles by their names 0, 1, ... along the second axis.

    Attributes
    ----------
    time : (K,) [s]
    x, v : (K, n) positions of the fronts [m] and speeds [m/s]
    on_road : (K, n) whether on the through lane
    co2, fuel : (n,) emitted and used in all [g]
    reports : figures reported by the controller, empty if SUMO drives
    """

    time: Vector
    x: Vector
    v: Vector
    on_road: NDArray[np.bool_]
    co2: Vector
    fuel: Vector
    reports: dict[str, float]


@contextmanager
def running_sumo(network: Path, vehicles: Path, step: float, seed: int, ballistic: bool) -> Iterator[Any]:
    """libsumo with a simulation loaded, closed at the end."""
    sumo_home()
    with warnings.catch_warnings(), redirect_stdout(io.StringIO()):  # it prints a message about pyarrow
        warnings.simplefilter("ignore")
        import libsumo
    options = ["--no-step-log", "--no-warnings", "--collision.action", "none", "--time-to-teleport", "-1"]
    options += ["--step-method.ballistic", "true"] if ballistic else []
    files = ["-n", str(network), "-r", str(vehicles)]
    libsumo.start(["sumo", *files, "--step-length", repr(step), "--seed", str(seed), *options])
    try:
        yield libsumo
    finally:
        libsumo.close()


def simulate(
    scenario: Scenario,
    driver: Driver,
    *,
    step: float = 0.01,
    seed: int = 1,
    disturbance: Disturbance | None = None,
    to_contact: bool = False,
) -> Record:
    """Run a scenario, headless; the same arguments give the same record.

    Parameters
    ----------
    scenario : what happens
    driver : who drives
    step : of SUMO, and the controller's sampling period [s]
    seed : of SUMO
    disturbance : between controller and vehicles; none by default
    to_contact : end when two vehicles touch
    """
    disturbance = disturbance or Disturbance()
    with TemporaryDirectory() as name:
        folder = Path(name)
        vehicles = write_vehicles(folder, scenario, driver)
        with running_sumo(write_road(folder, scenario), vehicles, step, seed, disturbance.ballistic) as sumo:
            label = f"{scenario.name}, {driver.name}, start {seed}"
            return _Run(sumo, scenario, driver, step, disturbance, folder, label).go(to_contact)


class _Run:
    """The loop around SUMO's step."""

    def __init__(
        self,
        sumo: Any,
        scenario: Scenario,
        driver: Driver,
        step: float,
        disturbance: Disturbance,
        folder: Path,
        label: str,
    ):
        self.sumo, self.scenario, self.driver, self.step = sumo, scenario, driver, step
        self.names = [str(i) for i in range(scenario.vehicles)]
        self.members = list(range(scenario.v.size))  # in the platoon, leader first
        self.waiting = [i for i in range(scenario.vehicles) if i not in self.members]
        self.platoon: Platoon | None = None
        if driver.fmu is not None:
            fmu = ControllerFmu(driver.fmu, folder / "fmu")
            values = dict(driver.parameters) | {"v_star": scenario.v_star}
            self.platoon = Platoon(fmu, label, values, step)
        self.lag, self.ballistic = disturbance.lag, disturbance.ballistic
        self.past: deque[tuple[float, Vector, Vector]] = deque(maxlen=1 + round(disturbance.delay / step))
        lengths = [sumo.lane.getLength(f"{edge}_0") for edge in ("before", "beside")]
        self.begins = {"before": 0.0, "beside": lengths[0], "after": sum(lengths)}  # [m] of each edge
        self.through = {f"{edge}_{lane}" for edge, lane in through_lanes(scenario).items()}
        self.changing = set(self.waiting) if driver.fmu is None else set()  # SUMO decides when these change lanes
        self.actual = np.zeros(scenario.vehicles)  # [m/s2] what the actuators do

    def go(self, to_contact: bool) -> Record:
        n, platoon, leader = len(self.names), self.platoon, self.scenario.leader
        self.sumo.simulationStep()  # puts the vehicles on the road
        self._hand_over()
        time = self.step * np.arange(round(self.scenario.duration / self.step), dtype=np.float64)
        x, v, road = np.zeros((time.size, n)), np.zeros((time.size, n)), np.zeros((time.size, n), dtype=bool)
        emitted = np.zeros((2, n))  # [g] CO2 and fuel
        done = time.size
        for k in range(time.size):
            self._read(x[k], v[k], road[k], emitted)
            if leader is not None:
                self.sumo.vehicle.setSpeed("0", leader.speed((k + 1) * self.step))
            if platoon is not None:
                self._control(platoon, time[k], x[k], v[k], road[k])
            else:
                self._ease(time[k] + self.step, v[0])
                self._stay(road[k])
            if to_contact and np.diff(np.sort(x[k, road[k]])).min() <= LENGTH:
                done = k + 1
                break
            self.sumo.simulationStep()
        reports = {} if platoon is None else platoon.reports()
        if platoon is not None:
            platoon.close()
        return Record(time[:done], x[:done], v[:done], road[:done], emitted[0], emitted[1], reports)

    def _read(self, x: Vector, v: Vector, on_road: NDArray[np.bool_], emitted: Vector) -> None:
        """Positions and speeds of all vehicles, into the given rows; emissions since the last step are added."""
        vehicle = self.sumo.vehicle
        for i, name in enumerate(self.names):
            lane = vehicle.getLaneID(name)
            x[i] = self.begins[lane.partition("_")[0]] + vehicle.getLanePosition(name)
            v[i] = vehicle.getSpeed(name)
            on_road[i] = lane in self.through
            emitted[0, i] += 1e-3 * self.step * vehicle.getCO2Emission(name)
            emitted[1, i] += 1e-3 * self.step * vehicle.getFuelConsumption(name)

    def _hand_over(self) -> None:
        """Set in SUMO who controls each vehicle."""
        vehicle = self.sumo.vehicle
        for i, name in enumerate(self.names):
            vehicle.setLaneChangeMode(name, _CHANGE if i in self.changing else _STAY)
            if self.platoon is not None:
                vehicle.setSpeedMode(name, 0)
        if self.scenario.leader is not None:
            vehicle.setSpeedMode("0", 0)

    def _ease(self, time: float, v_start: Vector) -> None:
        """Lower the desired speed of SUMO's drivers to v_star gently: SUMO itself brakes faster vehicles at 9 m/s2."""
        for name, speed in zip(self.names, v_start, strict=True):
            before, now = (speed - _EASE * at for at in (time - self.step, time))
            if time <= self.step or before > self.scenario.v_star:
                self.sumo.vehicle.setMaxSpeed(name, max(now, self.scenario.v_star))

    def _stay(self, on_road: NDArray[np.bool_]) -> None:
        """Vehicles on the through lane stay there, including those that have merged from the ramp."""
        for i in [i for i in self.changing if on_road[i]]:
            self.sumo.vehicle.setLaneChangeMode(self.names[i], _STAY)
            self.changing.remove(i)

    def _control(self, platoon: Platoon, time: float, x: Vector, v: Vector, on_road: NDArray[np.bool_]) -> None:
        """Measure, ask the controller, and set the speeds that its accelerations lead to within a step."""
        self._count_in(x, v)
        self.past.append((time, x.copy(), v.copy()))
        measured_at, x_seen, v_seen = self.past[0]
        order = self.members
        v_desired = float(np.clip(v_seen[0], *_DESIRED)) if self.driver.follows else -1.0
        a = platoon.command(-np.diff(x_seen[order]), v_seen[order], measured_at, v_desired)
        share = 1.0 if self.lag <= 0.0 else -np.expm1(-self.step / self.lag)
        for i, command in zip(order, a, strict=True):
            self.actual[i] += share * (command - self.actual[i])
            if i == 0 and self.scenario.leader is not None:
                continue
            self.sumo.vehicle.setSpeed(self.names[i], max(v[i] + self.step * self.actual[i], 0.0))
            if not on_road[i]:
                self._change_lane(i, order, x)
        for i in self.waiting:  # at constant speed until there is a gap beside
            self.sumo.vehicle.setSpeed(self.names[i], v[i])

    def _count_in(self, x: Vector, v: Vector) -> None:
        """A vehicle on the acceleration lane joins the platoon as soon as it is beside a gap (virtual vehicle)."""
        for i in list(self.waiting):
            ahead = [j for j in self.members if x[j] > x[i]]
            behind = [j for j in self.members if x[j] <= x[i]]
            least = LENGTH + JOIN_ROOM
            if (not ahead or x[ahead[-1]] - x[i] > least) and (not behind or x[i] - x[behind[0]] > least):
                self.members.insert(len(ahead), i)
                self.waiting.remove(i)

    def _change_lane(self, i: int, order: list[int], x: Vector) -> None:
        """Change to the through lane if there is room."""
        place, least = order.index(i), LENGTH + LANE_CHANGE_ROOM
        free_ahead = place == 0 or x[order[place - 1]] - x[i] > least
        free_behind = place == len(order) - 1 or x[i] - x[order[place + 1]] > least
        if free_ahead and free_behind and x[i] < self.begins["after"] - 10.0:
            self.sumo.vehicle.changeLane(self.names[i], 1, 1000.0)
