"""The part of a state that holds the closed loop, in memory and as bytes."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from psp_model.law.controller import MakeController
from psp_model.law.cooperation import Cooperation
from psp_model.law.extended import DrivenLeader, Engaged, ExtendedLaw
from psp_model.law.potential import PotentialParameters
from psp_model.membership import JoinMargin
from psp_model.parameters import ObjectiveWeights
from psp_model.platoon import SampledPlatoon, loop_of
from psp_model.sampling.clock import TIME_TOLERANCE, Clock
from psp_model.sampling.hold import Motion
from psp_model.sampling.loop import Instant, Loop
from psp_model.sampling.policy import Certificate, Sampling
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
    lengths : (n,) of the vehicles, None for L [m]
    leader : the first vehicle where it drives itself, as it was told for the last sampling instant
    now : that instant
    loop, sampling : as `SampledPlatoon` has them
    """

    in_domain: float
    members: Members
    shape: PotentialParameters
    lengths: NDArray[np.float64] | None
    leader: DrivenLeader | None
    now: Instant
    loop: Loop = field(metadata=IN_MEMORY)
    sampling: Sampling = field(metadata=IN_MEMORY)


_KEPT = ("in_domain", "members", "shape", "lengths", "leader", "now")


def kept_of(platoon: SampledPlatoon, members: Members, in_domain: float) -> Kept:
    """What a state keeps of a platoon.

    Parameters
    ----------
    platoon, members, in_domain : the platoon, and the other fields of `Kept`
    """
    law = platoon.loop.controller
    assert isinstance(law, ExtendedLaw) and isinstance(law.potential, PotentialParameters)
    lengths: Any = law.cooperation.length
    parts = in_domain, members, law.potential, lengths, law.leader
    return Kept(*parts, platoon.now, platoon.loop, platoon.sampling)


@dataclass(frozen=True)
class Description:
    """The platoon described by the parameters.

    Attributes
    ----------
    start, weights, sampling : as `SampledPlatoon` has them
    old : whether its potential is V_old
    cooperation : parameters of the extended law
    asked : what joining asks for beside the certificate
    """

    start: PlatoonState
    weights: ObjectiveWeights
    sampling: Sampling
    old: bool
    cooperation: Cooperation
    asked: JoinMargin

    def law(self, leader: DrivenLeader | None) -> MakeController[Engaged | None]:
        """Makes the controller from potential and constants.

        Parameters
        ----------
        leader : the first vehicle where it drives itself
        """
        T, cooperation = self.sampling.T, self.cooperation
        return lambda potential, constants: ExtendedLaw(potential, constants, cooperation, leader, T)


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
    shape, now = potential(kept["shape"], constants, described.old), _instant(kept["now"], capacity, described)
    _require_here(now, here)
    members = _members(kept["members"], now.v.size)
    lengths, leader = _lengths(kept["lengths"], now.v.size), _leader(kept["leader"], constants.v_max)
    described = replace(described, cooperation=replace(described.cooperation, length=lengths))
    loop = loop_of(shape, constants, described.weights, described.sampling, described.law(leader))
    return Kept(in_domain, members, shape, lengths, leader, now, loop, described.sampling)


def _lengths(data: Any, vehicles: int) -> NDArray[np.float64] | None:
    if data is None:
        return None
    lengths = vector(data, vehicles)
    require(bool((lengths > 0.0).all()))
    return lengths


def _leader(data: Any, v_max: float) -> DrivenLeader | None:
    if data is None:
        return None
    fields = record(data, DrivenLeader._fields)
    leader = DrivenLeader(number(fields["speed"], 0.0), number(fields["acceleration"]))
    require(bool(leader.speed <= v_max))
    return leader


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


def _memory(data: Any, vehicles: int, closes: bool) -> Engaged | None:
    if data is None:
        require(not closes)
        return None
    fields = record(data, Engaged._fields)
    require((fields["closing"] is not None) == closes)
    closing = vector(fields["closing"], vehicles) if closes else None
    return Engaged(closing, None if fields["leader"] is None else number(fields["leader"]))


def _instant(data: Any, capacity: int, described: Description) -> Instant:
    now = record(data, Instant._fields)
    moving, cost = record(now["vehicles"], Motion._fields), now["cost"]
    require(isinstance(moving["v"], list) and 1 <= len(moving["v"]) <= capacity)
    require(isinstance(cost, list) and len(cost) == 2 and bound(cost[0]) >= 0.0 and not np.isnan(bound(cost[1])))
    n, fraction, span = len(moving["v"]), number(now["fraction"], 0.0), number(now["span"])
    require(fraction < 1.0 and 0.0 < span <= 1.0)
    exact = described.sampling.certificate == Certificate.EXACT
    require((now["T_exact"] is not None) == exact)
    return Instant(
        period=count(now["period"]),
        fraction=fraction,
        vehicles=Motion(number(moving["x"]), vector(moving["s"], n - 1), vector(moving["v"], n)),
        a=vector(now["a"], n),
        T_max=bound(now["T_max"]),
        span=span,
        violations=count(now["violations"]),
        cost=(float(cost[0]), float(cost[1])),
        memory=_memory(now["memory"], n, described.cooperation.closing_speed != 0.0),
        T_exact=bound(now["T_exact"]) if exact else None,
    )


def _require_here(now: Instant, here: Clock) -> None:
    """A time between the last instant and the next, to within a period: otherwise instants would pass without end."""
    period, fraction = here.at()
    require(-1.0 <= period - now.period + fraction - now.fraction <= 1.0 + TIME_TOLERANCE)
