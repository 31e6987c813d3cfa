"""The table of FMI variables of `PspPlant`, vehicles to try the controller on."""

from __future__ import annotations

from dataclasses import replace

from .platoon import platoon_table
from .variables import Variable

DESCRIPTION = "Ideal vehicles on one lane, double integrators, to try a controller on"


def plant_table(vehicles: int) -> tuple[Variable, ...]:
    """The variables of `PspPlant`: ideal vehicles on one lane.

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
    text = "Acceleration of vehicle {}: the last one that is set within a period counts for all of it"
    accelerations = [
        Variable(f"a[{i}]", text.format(i), "m/s2", 0.0, nominal=1, input=True) for i in range(1, vehicles + 1)
    ]
    known = {row.name for row in parameters}
    motion = []
    for name, row in rows.items():
        if name[:2] in ("x[", "v[", "s["):
            text = f"{row.description}, at the beginning of the current period"
            starts = tuple(start for start in row.initial_dependencies or () if start in known)
            motion.append(replace(row, description=text, continuous=False, initial_dependencies=starts))
    return (*parameters, *accelerations, *motion)
