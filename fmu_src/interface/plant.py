"""The table of FMI variables of `PspPlant`, vehicles to try the controller on."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from psp_model.parameters import NO_LIMIT, PlatoonParameters

from .platoon import platoon_table
from .variables import Variable

DESCRIPTION = "Vehicles on one lane, ideal or with dead time, lag and limits, to try a controller on"


def _vehicles(n: int) -> Iterator[Variable]:
    """What the vehicles are: with the start values double integrators."""
    text = "Time from the beginning of the period whose command it is to its first effect, the same for all vehicles"
    yield Variable("actuation_delay", text, "s", 0.0, 0, nominal=0.2)
    for i in range(1, n + 1):
        text = f"Time constant of the actuator of vehicle {i}, 0 for none"
        yield Variable(f"actuator_lag[{i}]", text, "s", 0.0, 0, nominal=0.2)
    for i in range(1, n + 1):
        yield Variable(f"length[{i}]", f"Length of vehicle {i}, above 0", "m", PlatoonParameters.L, 0, nominal=5)
    for i in range(1, n + 1):
        text = f"Least acceleration that vehicle {i} can be commanded, below 0; {-NO_LIMIT:g} stands for none"
        yield Variable(f"a_min[{i}]", text, "m/s2", -NO_LIMIT, maximum=0, nominal=5)
    for i in range(1, n + 1):
        text = f"Greatest acceleration that vehicle {i} can be commanded, above 0; {NO_LIMIT:g} stands for none"
        yield Variable(f"a_max[{i}]", text, "m/s2", NO_LIMIT, 0, nominal=5)


def _inputs(n: int) -> Iterator[Variable]:
    for i in range(1, n + 1):
        text = f"Acceleration of vehicle {i}: the last one that is set within a period counts for all of it"
        yield Variable(f"a[{i}]", text, "m/s2", 0.0, nominal=1, input=True)
    for i in range(1, n + 1):
        text = f"1 if vehicle {i} is commanded its acceleration, 0 if it drives itself and has it at once"
        yield Variable(f"automated[{i}]", text, "1", 1.0, 0, 1, input=True)


def _seen(n: int) -> Iterator[Variable]:
    nothing: tuple[str, ...] = ()
    when = "at the beginning of the current period"
    for i in range(2, n + 1):
        known = (f"s_start[{i}]", f"length[{i - 1}]")
        text = f"Clearance between vehicle {i - 1} and vehicle {i}, bumper to bumper, {when}; 0 or below: they touch"
        yield Variable(f"clearance[{i}]", text, "m", nominal=10, initial_dependencies=known)
    for i in range(1, n + 1):
        text = f"Acceleration of vehicle {i}, {when}, just before its command; 0 where it stands and brakes"
        yield Variable(f"acceleration[{i}]", text, "m/s2", nominal=1, initial_dependencies=nothing)


def plant_table(vehicles: int) -> tuple[Variable, ...]:
    """The variables of `PspPlant`: vehicles on one lane, ideal ones with the start values.

    Parameters
    ----------
    vehicles : n, at least 2

    Returns
    -------
    tuple of Variable (ours)
    """
    rows = {row.name: row for row in platoon_table(vehicles)}
    text = "Length of the periods over which an acceleration counts, above 0: the controller's sampling period"
    parameters = [replace(rows["T"], description=text)]
    parameters += [row for name, row in rows.items() if name == "x_start" or "_start[" in name]
    known = {row.name for row in parameters}
    motion = []
    for name, row in rows.items():
        if name[:2] in ("x[", "v[", "s["):
            text = f"{row.description}, at the beginning of the current period"
            starts = tuple(start for start in row.initial_dependencies or () if start in known)
            motion.append(replace(row, description=text, continuous=False, initial_dependencies=starts))
    return (*parameters, *_vehicles(vehicles), *_inputs(vehicles), *motion, *_seen(vehicles))
