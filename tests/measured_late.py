"""Vehicles with dead time, as they are measured some time ago; for tests of prediction."""

from __future__ import annotations

from typing import Any

import numpy as np

from psp_model.vehicles.delayed import Delayed, DelayedVehicles
from psp_model.vehicles.membership import of_members, taken

T = 0.01  # [s] sampling period


def measured_before(plant: DelayedVehicles, past: list[tuple[Delayed, Any]], age: float) -> Delayed:
    """The plant `age` before the last of its sampling instants; before the first it has coasted."""
    back = int(np.ceil(age / T - 1e-9))
    rest = back * T - age
    if back >= len(past):
        vehicles, missing = past[0][0], age - (len(past) - 1) * T
        _, s, v, actuators = vehicles
        return Delayed(vehicles.x, s - missing * (v[:-1] - v[1:]), v, actuators)
    vehicles, a = past[-1 - back]
    return plant.advance(vehicles, a, rest)[0] if rest > 0 else vehicles


def positions(vehicles: Delayed) -> Any:
    return np.subtract.accumulate(np.concatenate([[vehicles.x], vehicles.s]))


def changed(past: list[tuple[Delayed, Any]], members: list[int | None], spacing: float, speed: float) -> list[Any]:
    """The past of another platoon: one that joins, `spacing` behind the vehicle ahead of it, has coasted so far."""
    here, after = positions(past[-1][0]), []
    for back, (vehicles, a) in enumerate(reversed(past)):
        x = positions(vehicles)
        new = 0.0 if None not in members else here[members[members.index(None) - 1]] - spacing - back * T * speed
        x = np.array([new if one is None else x[one] for one in members])
        v = np.array([speed if one is None else vehicles.v[one] for one in members])
        actuators = of_members(vehicles.actuators, members)
        command = None if a is None else taken(a, members)
        after.append((Delayed(x[0], x[:-1] - x[1:], v, actuators), command))
    return after[::-1]
