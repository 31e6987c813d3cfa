"""The state of the slave `PspController` as bytes, every field checked."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from psp_model.controller import Basis, Command, ControllerSettings, SampledController
from psp_model.controller.settings import MOST_COMMANDS
from psp_model.law.watching import Watched
from psp_model.sampling.clock import Clock
from psp_model.vehicles.actuation import Actuators
from psp_model.vehicles.prediction import Issued
from psp_model.vehicles.road_law import Remembered

from .slave_state import IN_MEMORY
from .state_check import Vector, bound, count, flag, number, potential, record, require, vector


@dataclass(frozen=True, eq=False)
class Kept:
    """What a state keeps of a controller.

    Attributes
    ----------
    sampled, set_at, fresh, ahead : as the slave has them
    now : the last decision
    controller : with what the parameters say
    """

    sampled: int
    set_at: float
    fresh: bool
    now: Command
    ahead: Command | None
    controller: SampledController = field(metadata=IN_MEMORY)


def restored(data: Any, here: Clock, controller: SampledController) -> Kept:
    """The state in JSON; ValueError where no run can reach it.

    Parameters
    ----------
    data : from JSON
    here : where the last communication point is
    controller : with what the parameters say
    """
    kept = record(data, ("sampled", "set_at", "fresh", "now", "ahead"))
    set_at, sampled, settings = number(kept["set_at"]), count(kept["sampled"]), controller.settings
    require(set_at <= here.period + here.offset + 1.0)
    require(abs(sampled - here.period) <= 2)  # or a step would pass others without end
    now = _command(kept["now"], settings)
    ahead = None if kept["ahead"] is None else _command(kept["ahead"], settings)
    return Kept(sampled, set_at, flag(kept["fresh"]), now, ahead, controller)


def _command(data: Any, settings: ControllerSettings) -> Command:
    packed, N = record(data, Command.__dataclass_fields__), settings.capacity
    saturated, n_active = packed["saturated"], count(packed["n_active"])
    require(n_active <= N and isinstance(saturated, list) and len(saturated) == N)
    return Command(
        a=vector(packed["a"], N),
        saturated=np.array([flag(one) for one in saturated], dtype=bool),
        in_order=flag(packed["in_order"]),
        T_max=bound(packed["T_max"]),
        T_exact=bound(packed["T_exact"]),
        violations=count(packed["violations"]),
        faults=count(packed["faults"]),
        choices=count(packed["choices"]),
        n_active=n_active,
        in_domain=flag(packed["in_domain"]),
        resolve=number(packed["resolve"]),
        shape=potential(packed["shape"], settings.constants, settings.request.old),
        basis=None if packed["basis"] is None else _basis(packed["basis"], n_active, settings),
        memory=None if packed["memory"] is None else _memory(packed["memory"], settings),
    )


def _not_below(value: Any, size: int, least: float) -> Vector:
    """Finite numbers, (size,), none below `least`."""
    found = vector(value, size)
    require(bool((found >= least).all()))
    return found


def _basis(data: Any, n: int, settings: ControllerSettings) -> Basis:
    packed = record(data, Basis._fields)
    require(n >= 1)
    basis = Basis(
        s=_not_below(packed["s"], n - 1, 0.0),
        v=_not_below(packed["v"], n, 0.0),
        age=number(packed["age"], 0.0),
        automated=vector(packed["automated"], n),
        s_predicted=vector(packed["s_predicted"], n - 1),
        v_predicted=_not_below(packed["v_predicted"], n, 0.0),
        a_predicted=vector(packed["a_predicted"], n),
    )
    require(basis.age <= settings.oldest and set(basis.automated.tolist()) <= {0.0, 1.0})
    return basis


def _memory(data: Any, settings: ControllerSettings) -> Remembered:
    packed = record(data, Remembered._fields)
    issued = record(packed["issued"], Issued._fields)
    actuators = record(issued["actuators"], Actuators._fields)
    require(isinstance(actuators["a"], list) and 1 <= len(actuators["a"]) <= settings.capacity)
    require(issued["span"] == settings.oldest and packed["predicted"] is None)
    rows = len(actuators["a"])
    a, command = vector(actuators["a"], rows), vector(actuators["command"], rows)
    queue = _queue(actuators["queue"], rows, settings)
    remembered = Remembered(Issued(Actuators(a, command, queue), settings.oldest))
    if packed["watched"] is None:
        return remembered
    watched = record(packed["watched"], Watched._fields)
    return remembered._replace(watched=Watched(*(vector(watched[name], rows) for name in Watched._fields)))


def _queue(data: Any, rows: int, settings: ControllerSettings) -> tuple[tuple[float, Vector], ...]:
    """Commands on their way, the first to take effect first."""
    require(isinstance(data, list) and len(data) <= MOST_COMMANDS)
    require(all(isinstance(one, list) and len(one) == 2 for one in data))
    queue = tuple((number(due, 0.0), vector(command, rows)) for due, command in data)
    longest = settings.oldest + settings.actuation.actuation_delay
    require(all(before[0] < after[0] for before, after in pairwise(queue)))
    require(not queue or queue[-1][0] <= longest)
    return queue
