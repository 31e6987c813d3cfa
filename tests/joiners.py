"""Vehicles that want to join or leave at random, often at the limits, and the road as they see it."""

from __future__ import annotations

from ctypes import c_double, c_uint
from dataclasses import dataclass

import numpy as np

from harness import Instance

L, V_MAX, T = 5.0, 35.0, 0.01
INPUTS = ("insert", "insert_behind", "insert_gap", "insert_speed", "remove", "remove_place")
INSTANT = 1e-7  # [s] a step in which hardly anything moves


@dataclass(frozen=True, eq=False)
class Seen:
    """All outputs of a platoon at a communication point; the arrays hold the vehicles there are."""

    x: np.ndarray
    v: np.ndarray
    a: np.ndarray
    s: np.ndarray
    vehicles: tuple[int, ...]
    behind: np.ndarray
    report: dict[str, float]

    @property
    def n(self) -> int:
        return len(self.vehicles)


def look(road: Instance) -> Seen:
    """Read everything in one call."""
    capacity = road.fmu.vehicles
    names = [v.name for v in road.fmu.description.modelVariables if v.causality == "output"]
    values = np.array(road.outputs())
    n = int(values[names.index("n_active")])
    parts, behind, first = [], [], 0
    for size, known in ((capacity, n), (capacity, n), (capacity, n), (capacity - 1, n - 1)):
        parts.append(values[first : first + known])
        behind.append(values[first + known : first + size])
        first += size
    place = names.index("vehicle[1]")
    behind.append(values[place + n : place + capacity])
    vehicles = tuple(values[place : place + n].astype(int).tolist())
    report = {name: values[k] for k, name in enumerate(names) if k >= first and "[" not in name}
    return Seen(*parts, vehicles, np.concatenate(behind), report)


def ask(road: Instance, request: dict[str, float]) -> None:
    """Set the inputs, those that are not named to 0."""
    references = [road.fmu.reference[name] for name in INPUTS]
    values = [float(request.get(name, 0.0)) for name in INPUTS]
    count = len(INPUTS)
    assert road.call("fmi2SetReal", (c_uint * count)(*references), count, (c_double * count)(*values)) == 0


def random_join(rng: np.random.Generator, seen: Seen) -> dict[str, float]:
    """A vehicle that wants in, perhaps where there is no room, or as fast as may be."""
    place = int(rng.integers(0, seen.n + 1))
    room = float(seen.s[place - 1]) if 0 < place < seen.n else 40.0
    near = L + T * V_MAX
    spacing = rng.choice([rng.uniform(L, max(room - L, L + 0.1)), L, near * 0.999, near * 1.01, 0.5 * room, 30.0])
    speed = rng.choice([0.0, V_MAX, 30.0, rng.uniform(0, V_MAX), seen.v[min(place, seen.n - 1)]])
    return {"insert": 1.0, "insert_behind": place, "insert_gap": float(spacing), "insert_speed": float(speed)}


def random_leave(rng: np.random.Generator, seen: Seen) -> dict[str, float]:
    """Any of the vehicles wants out."""
    return {"remove": 1.0, "remove_place": int(rng.integers(1, seen.n + 1))}


def random_nonsense(rng: np.random.Generator) -> dict[str, float]:
    """A request that no platoon can grant."""
    join = {"insert": 1.0, "insert_behind": 1.0, "insert_gap": 15.0, "insert_speed": 30.0}
    wrong = [
        join | {"insert_behind": rng.choice([-1.0, 0.5, 99.0, np.nan, np.inf])},
        join | {"insert_gap": rng.choice([np.nan, np.inf, -np.inf, -3.0, 0.0, 4.9])},
        join | {"insert_speed": rng.choice([np.nan, -1e-9, np.nextafter(V_MAX, 99.0), -np.inf])},
        {"remove": 1.0, "remove_place": rng.choice([0.0, 1.5, 99.0, np.nan, -np.inf])},
    ]
    return wrong[int(rng.integers(len(wrong)))]


def random_request(rng: np.random.Generator, seen: Seen, capacity: int) -> dict[str, float]:
    """Mostly joins while there are few vehicles, mostly leaves when there are many; now and then nonsense."""
    if rng.random() < 0.05:
        return random_nonsense(rng)
    if rng.random() < (0.7 if seen.n < 0.75 * capacity else 0.45):
        return random_join(rng, seen)
    return random_leave(rng, seen)
