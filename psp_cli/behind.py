"""`psp simulate --leader`: controller, plant and leader FMUs of real vehicles, stepped together by fmpy."""

from __future__ import annotations

import difflib
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from math import ceil, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .bad_input import BadInput
from .instances import Instance
from .quantities import quantity

if TYPE_CHECKING:
    from psp_model.analysis.behind import BehindLeader

START = {  # where the FMUs start with the paper's values, which knows no such vehicles (docs/road.md)
    "kappa": 1.0,
    "parameter_source": 2.0,
    "lemma1_policy": 2.0,
    "bad_input": 2.0,
    "a_safe": -4.0,
    "a_min": -8.0,
    "a_max": 4.0,
}
CLEARANCE = 9.0  # [m] at the start, beyond the time gap, where no spacing is given
_REPORTS = ("T_max", "T_exact", "brake_margin", "certified", "in_order")  # of the controller, fields of BehindLeader
_BELIEF = ("actuation_delay", "actuator_lag")  # of the controller; the vehicles have --delay and --lag


@dataclass(frozen=True)
class Behind:
    """What is to be run.

    Attributes
    ----------
    leader : CSV file of a speed profile, time [s] and speed [m/s]
    vehicles : n, the leader included
    delay, lag : dead time and time constant of the vehicles [s]
    age : of what the controller measures [s]; whole sampling periods count, rounded up
    runtime : of the FMUs
    values : parameters by name, from `parameters`
    duration : [s], None for that of the profile
    """

    leader: Path
    vehicles: int = 7
    delay: float = 0.0
    lag: float = 0.0
    age: float = 0.0
    runtime: Literal["python", "native"] = "python"
    values: Mapping[str, float] = field(default_factory=dict)
    duration: float | None = None


def parameters(given: Mapping[str, str | float], vehicles: int) -> dict[str, float]:
    """Values in SI units of parameters of controller and plant, and of a_known; of START where nothing else is given.

    Parameters
    ----------
    given : numbers or texts of number and unit by name; a name without an index stands for all vehicles
    vehicles : n

    Raises
    ------
    BadInput : where a name is none of a parameter or a value is no good
    """
    from fmu_src.interface.controller import controller_table
    from fmu_src.interface.plant import plant_table

    rows = (*controller_table(vehicles), *plant_table(vehicles))
    units = {row.name: row.unit for row in rows if row.causality == "parameter" or row.name.startswith("a_known[")}
    found: dict[str, float] = {}
    for name, value in (START | dict(given)).items():
        names = [name] if name in units else [one for one in units if one.partition("[")[0] == name]
        if not names:
            close = difflib.get_close_matches(name, units, n=3, cutoff=0.5)
            hint = f"did you mean {' or '.join(close)}?" if close else "docs/road.md shows the names"
            raise BadInput(f"{name!r} is not a parameter of a controller or plant of {vehicles} vehicles: {hint}")
        found |= {one: quantity(value, units[one], one) for one in names}
    for name in (row.name for row in rows if row.integer and row.name in found):
        if not float(found[name]).is_integer():
            raise BadInput(f"{name} = {found[name]:g} is not one of its choices: give it a whole number")
    return found


def columns_of(run: BehindLeader) -> Any:
    """A run as a structured array, `time` first, for a CSV file.

    Parameters
    ----------
    run : what became of the platoon
    """
    columns = {"time": run.time}
    for name, first in (("x", 1), ("v", 1), ("s", 2), ("clearance", 2), ("a", 1), ("command", 1)):
        table = getattr(run, name)
        columns |= {f"{name}[{i}]": table[:, i - first] for i in range(first, first + table.shape[1])}
    columns |= {name: getattr(run, name) for name in _REPORTS}
    result = np.empty(len(run.time), dtype=[(name, float) for name in columns])
    for name, column in columns.items():
        result[name] = column
    return result


def run_behind(asked: Behind, doing: Callable[[int], Callable[[], None]]) -> tuple[BehindLeader, list[str]]:
    """Run it: the output, and what the FMUs warned of.

    Parameters
    ----------
    asked : what
    doing : is told how many steps there are, and returns what is called after each

    Raises
    ------
    BadInput : where something is wrong, with the sentence of the FMU where it refuses
    """
    from tempfile import TemporaryDirectory

    from psp_model.vehicles.leader import read_profile

    profile = read_profile(asked.leader, asked.values.get("v_max", 35.0))
    T = asked.values.get("T", 0.01)
    if not (isfinite(T) and T > 0):
        raise BadInput(f"T = {T:g} s must be positive: it is the sampling period, give it a time above 0 s")
    steps = ceil((asked.duration or profile.times[-1]) / T - 1e-9)
    with TemporaryDirectory() as folder:
        road = _Road(asked, Path(folder))
        try:
            road.begin(asked, profile.speeds[0], T)
            return road.run(T, steps, ceil(asked.age / T - 1e-9), doing(steps)), road.warnings()
        finally:
            road.close()


def _named(name: str, places: Iterable[int]) -> list[str]:
    return [f"{name}[{i}]" for i in places]


class _Road:
    """Three FMUs, and what is set and read.

    Parameters
    ----------
    asked : what is to be run
    folder : for the FMUs
    """

    def __init__(self, asked: Behind, folder: Path):
        import build_fmu

        def built(component: str, profile: Path | None = None) -> Instance:
            options = build_fmu.Options(asked.vehicles, component, folder, asked.runtime, "host", None, profile)
            return Instance(build_fmu.make(options)[0], folder)

        self.n = asked.vehicles
        self.leader, self.plant, self.controller = built("leader", asked.leader), built("plant"), built("controller")

    def close(self) -> None:
        """Free them all."""
        for instance in (self.leader, self.plant, self.controller):
            instance.close()

    def warnings(self) -> list[str]:
        """What they have warned of."""
        return [one for instance in (self.controller, self.plant, self.leader) for one in instance.warnings]

    def begin(self, asked: Behind, speed: float, T: float) -> None:
        """Pass initialisation at time 0.

        Parameters
        ----------
        asked : what is to be run
        speed : of the leader at time 0 [m/s], which is that of all
        T : sampling period [s]
        """
        values, every = asked.values, range(1, self.n + 1)
        true = {"actuation_delay": asked.delay} | dict.fromkeys(_named("actuator_lag", every), asked.lag)
        apart = CLEARANCE + values.get("time_gap", 0.0) * speed
        start = {f"s_start[{i}]": (values.get(f"length[{i - 1}]") or 5.0) + apart for i in every[1:]}
        start |= dict.fromkeys(_named("v_start", every), speed)
        start |= {"max_age": asked.age + 2 * T, "automated[1]": 0.0, "n_active": float(self.n)}
        told = true | start | dict(values)
        measured = {name.replace("_start", ""): value for name, value in told.items() if "_start[" in name}
        self.leader.begin({"T": T})
        self.plant.begin(told | true)
        self.controller.begin(told | measured)

    def run(self, T: float, steps: int, late: int, done: Callable[[], None]) -> BehindLeader:
        """Step them; at each instant the controller is told first, and the plant gets its commands.

        Parameters
        ----------
        T : sampling period and communication step [s]
        steps : how many
        late : how many periods old what is measured is
        done : called after each
        """
        from psp_model.analysis.behind import BehindLeader

        every, behind = range(1, self.n + 1), range(2, self.n + 1)
        motion = [*_named("s", behind), *_named("v", every)]
        shown = [*_named("x", every), *_named("clearance", behind), *_named("acceleration", every)]
        reports = ["T_max", "T_exact", "brake_margin", "certified", "input_ok"]
        of_leader, of_plant = self.leader.references(["a"]), self.plant.references([*motion, *shown])
        to_plant, to_controller = self.plant.references(_named("a", every)), [*motion, "a_measured[1]", "t_measured"]
        inputs, outputs = (
            self.controller.references(to_controller),
            self.controller.references([*_named("a", every), *reports]),
        )
        rows: list[list[float]] = []
        past: deque[list[float]] = deque(maxlen=late + 1)
        for k in range(steps + 1):
            time = k * T
            (own,), seen = self.leader.get(of_leader), self.plant.get(of_plant)
            past.append([*seen[: len(motion)], own, time])
            self.controller.set(inputs, past[0])
            self.controller.step(time, T)
            given = self.controller.get(outputs)
            command = [own, *given[1 : self.n]]
            rows.append([time, *seen, *command, *given[self.n :]])
            done()
            if min(seen[len(motion) + self.n : len(motion) + 2 * self.n - 1]) <= 0.0:
                break  # they touch, and what comes then is none of the model's
            self.plant.set(to_plant, command)
            self.plant.step(time, T)
            self.leader.step(time, T)
        return BehindLeader(**_columns(np.array(rows), self.n))


def _columns(rows: Any, n: int) -> dict[str, Any]:
    """The columns of a run by what they are."""
    widths = {"time": 1, "s": n - 1, "v": n, "x": n, "clearance": n - 1, "a": n, "command": n}
    widths |= dict.fromkeys(_REPORTS, 1)
    ends = np.cumsum(list(widths.values()))
    parts = dict(zip(widths, np.split(rows, ends[:-1], axis=1), strict=True))
    return {name: part[:, 0] if name in ("time", *_REPORTS) else part for name, part in parts.items()}
