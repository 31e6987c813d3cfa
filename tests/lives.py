"""Lives of an FMU at random: parameters, inputs and steps drawn, states kept and gone back to, resets after errors."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from ctypes import c_double, c_uint
from typing import NamedTuple

import numpy as np

from harness import ERROR, OK, WARNING, Instance, Unpacked

Draw = Callable[[np.random.Generator], Mapping[str, float]]


class Life(NamedTuple):
    """What became of an instance.

    Attributes
    ----------
    statuses : of all calls
    rows : all outputs, each time that they were read
    messages : status and text
    """

    statuses: list[int]
    rows: np.ndarray
    messages: list[tuple[int, str]]


def read(instance: Instance) -> tuple[int, list[float]]:
    """Status and values of all outputs."""
    names = [v.name for v in instance.fmu.description.modelVariables if v.causality == "output"]
    references = (c_uint * len(names))(*(instance.fmu.reference[name] for name in names))
    values = (c_double * len(names))()
    return instance.call("fmi2GetReal", references, len(names), values), list(values)


def life(fmu: Unpacked, seed: int, settings: Draw, inputs: Draw, start_time: float = 0.0, T: float = 0.01) -> Life:
    """Two instances that take turns: the state goes from one to the other through bytes.

    Parameters
    ----------
    fmu, seed : whose life, and which
    settings, inputs : draw parameters, and inputs, by name
    start_time : as a host has it [s]
    T : a step is about so long [s]
    """
    rng, instances = np.random.default_rng(seed), [Instance(fmu, "one"), Instance(fmu, "other")]
    statuses, rows, time, kept = [], [], None, None
    for _ in range(80):
        here = instances[0]
        if time is None:
            time, kept = start_time, None
            statuses.append(here.initialise({**settings(rng), **inputs(rng)}, start_time))
        if rng.random() < 0.6 and statuses[-1] <= WARNING:
            statuses.append(here.set(inputs(rng)))
        if rng.random() < 0.7 and statuses[-1] <= WARNING:
            status, values = read(here)
            statuses.append(status)
            rows.append(values)
        size = T * float(rng.choice([1.0, 1.0, 1.0, 0.25, 0.4, 2.5, 7.0, 0.0]))
        statuses.append(here.step(time, size) if statuses[-1] <= WARNING else ERROR)
        time += size
        chance = rng.random()
        if statuses[-1] > WARNING:
            assert here.call("fmi2Reset") == OK
            time = None
        elif chance < 0.1:
            kept = time, here.slave.getFMUstate()
        elif chance < 0.2 and kept:
            time = kept[0]
            here.slave.setFMUstate(kept[1])
        elif chance < 0.3:
            data = here.slave.serializeFMUstate(here.slave.getFMUstate())
            instances.reverse()
            instances[0].slave.setFMUstate(instances[0].slave.deSerializeFMUstate(data))
            kept = None
    messages = [said for instance in sorted(instances, key=id) for said in instance.messages]
    for instance in instances:
        instance.close()
    return Life(statuses, np.array(rows), messages)
