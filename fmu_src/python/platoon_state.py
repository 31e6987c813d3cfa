"""The part of a state that holds the closed loop, in memory and as bytes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from psp_model.law.potential import PotentialParameters
from psp_model.parameters import ObjectiveWeights
from psp_model.platoon import SampledPlatoon, loop_of
from psp_model.sampling.clock import TIME_TOLERANCE, Clock
from psp_model.sampling.hold import Motion
from psp_model.sampling.loop import Instant, Loop
from psp_model.sampling.policy import Sampling
from psp_model.state import PlatoonState

from .slave_state import IN_MEMORY
from .state_check import bound, count, number, potential, record, require, variables, vector


@dataclass(frozen=True)
class Members:
    """The vehicles present, and the results of the requested changes.

    Attributes
    ----------
    vehicles : number of each vehicle, leader first
    joined : number of vehicles so far
    change_ok : 1.0 if the last requested change was made, or none was requested
    gap_offered : spacing at which the vehicle rejected last could have joined, 0 if there was none [m]
    changes, refusals : made and rejected so far
    insert, remove : the triggers when the last step began
    """

    vehicles: tuple[int, ...] = ()
    joined: int = 0
    change_ok: float = 1.0
    gap_offered: float = 0.0
    changes: int = 0
    refusals: int = 0
    insert: float = 0.0
    remove: float = 0.0

    def told(self, capacity: int) -> list[float]:
        """The outputs on joining and leaving, in the order of the table.

        Parameters
        ----------
        capacity : most vehicles N
        """
        n = len(self.vehicles)
        numbers = (n, *self.vehicles, *(0,) * (capacity - n))
        return [*map(float, (*numbers, self.change_ok, self.gap_offered, self.changes, self.refusals))]


@dataclass(frozen=True, eq=False)
class Kept:
    """What a state keeps of a platoon.

    Attributes
    ----------
    in_domain : 1.0 if the vehicles were in the network's domain when the potential was selected
    members : the vehicles present
    shape : the potential in use
    now : the last sampling instant
    loop, sampling : as `SampledPlatoon` has them
    """

    in_domain: float
    members: Members
    shape: PotentialParameters
    now: Instant
    loop: Loop = field(metadata=IN_MEMORY)
    sampling: Sampling = field(metadata=IN_MEMORY)


_KEPT = ("in_domain", "members", "shape", "now")


def kept_of(platoon: SampledPlatoon, members: Members, in_domain: float) -> Kept:
    """What a state keeps of a platoon.

    Parameters
    ----------
    platoon, members, in_domain : the platoon, and the other fields of `Kept`
    """
    shape = platoon.shape
    assert isinstance(shape, PotentialParameters)
    return Kept(in_domain, members, shape, platoon.now, platoon.loop, platoon.sampling)


@dataclass(frozen=True)
class Description:
    """The platoon described by the parameters.

    Attributes
    ----------
    start, weights, sampling : as `SampledPlatoon` has them
    old : whether its potential is V_old
    """

    start: PlatoonState
    weights: ObjectiveWeights
    sampling: Sampling
    old: bool


def restored(data: Any, here: Clock, capacity: int, described: Description) -> Kept:
    """What a state keeps of a platoon, from JSON, every field of it checked.

    Parameters
    ----------
    data : read from JSON
    here : where the last communication point is
    capacity : most vehicles N
    described : by the parameters

    Raises
    ------
    ValueError : if no run can reach such a state
    """
    kept = record(data, _KEPT)
    constants, in_domain = described.start.constants, number(kept["in_domain"])
    require(in_domain in (0.0, 1.0))
    shape, now = potential(kept["shape"], constants, described.old), _instant(kept["now"], capacity)
    _require_here(now, here)
    members = _members(kept["members"], now.v.size)
    loop = loop_of(shape, constants, described.weights, described.sampling)
    return Kept(in_domain, members, shape, now, loop, described.sampling)


def _members(data: Any, vehicles: int) -> Members:
    fields = record(data, Members.__dataclass_fields__)
    numbers, joined = fields["vehicles"], count(fields["joined"], vehicles)
    require(isinstance(numbers, list) and (len(numbers) == vehicles))
    require(all(count(one, 1) <= joined for one in numbers) and fields["change_ok"] in (0.0, 1.0))
    insert, remove = variables([fields["insert"], fields["remove"]], (False, False))
    return Members(
        vehicles=tuple(numbers),
        joined=joined,
        change_ok=number(fields["change_ok"]),
        gap_offered=number(fields["gap_offered"]),
        changes=count(fields["changes"]),
        refusals=count(fields["refusals"]),
        insert=insert,
        remove=remove,
    )


def _instant(data: Any, capacity: int) -> Instant:
    now = record(data, Instant._fields)
    moving, cost = record(now["vehicles"], Motion._fields), now["cost"]
    require(isinstance(moving["v"], list) and 1 <= len(moving["v"]) <= capacity and now["memory"] is None)
    require(isinstance(cost, list) and len(cost) == 2 and bound(cost[0]) >= 0.0 and not np.isnan(bound(cost[1])))
    n, fraction, span = len(moving["v"]), number(now["fraction"], 0.0), number(now["span"])
    require(fraction < 1.0 and 0.0 < span <= 1.0)
    return Instant(
        period=count(now["period"]),
        fraction=fraction,
        vehicles=Motion(number(moving["x"]), vector(moving["s"], n - 1), vector(moving["v"], n)),
        a=vector(now["a"], n),
        T_max=bound(now["T_max"]),
        span=span,
        violations=count(now["violations"]),
        cost=(float(cost[0]), float(cost[1])),
    )


def _require_here(now: Instant, here: Clock) -> None:
    """A time between the last instant and the next, to within a period: otherwise instants would pass without end."""
    period, fraction = here.at()
    require(-1.0 <= period - now.period + fraction - now.fraction <= 1.0 + TIME_TOLERANCE)
