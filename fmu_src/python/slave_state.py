"""The whole state of a platoon's slave, in memory and as bytes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from psp_model.law.potential import PotentialParameters
from psp_model.parameters import ObjectiveWeights
from psp_model.platoon import SampledPlatoon, loop_of
from psp_model.sampling.clock import TIME_TOLERANCE, Clock
from psp_model.sampling.hold import Motion
from psp_model.sampling.loop import Instant
from psp_model.sampling.policy import Sampling
from psp_model.state import PlatoonState

from .state_check import bound, clock, count, flag, fresh, number, potential, record, require, variables, vector


@dataclass(frozen=True)
class Members:
    """Which vehicles there are, and what became of the changes asked for.

    Attributes
    ----------
    vehicles : number of each vehicle, leader first
    joined : vehicles there have been so far
    change_ok : 1.0 if the last change asked for was made, or none was
    gap_offered : at which the vehicle refused last could have joined, 0 if there was none [m]
    changes, refusals : made and refused so far
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
class SlaveState:
    """Everything that a slave's future depends on.

    Attributes
    ----------
    values : the parameters and inputs, in the order of the table
    clock : where the last communication point is
    in_domain : 1.0 if the vehicles were in the network's domain when the potential was chosen
    initialising : whether in initialisation mode
    members : which vehicles there are
    platoon : the platoon, None before there is one
    """

    values: tuple[float, ...]
    clock: Clock
    in_domain: float
    initialising: bool
    members: Members
    platoon: SampledPlatoon | None


_INSTANT = ("period", "fraction", "x", "s", "v", "a", "T_max", "span", "violations", "cost")
_PLAIN = ("values", "clock", "in_domain", "initialising")


def to_json(state: SlaveState) -> dict[str, Any]:
    """The state as JSON, in which every number reads back exactly; the launcher adds a checksum and the FMU's identity.

    What the parameters say of the platoon is left out: they are fixed, and say it again.

    Parameters
    ----------
    state : the state
    """
    fields = {name: getattr(state, name) for name in _PLAIN}
    parts = {"members": asdict(state.members), "platoon": state.platoon and _pack(state.platoon)}
    return fields | parts


@dataclass(frozen=True)
class Description:
    """What the parameters say of a platoon.

    Attributes
    ----------
    start, weights, sampling : as `SampledPlatoon` has them
    old : whether its potential is V_old
    """

    start: PlatoonState
    weights: ObjectiveWeights
    sampling: Sampling
    old: bool


def from_json(
    data: Any, integers: Sequence[bool], capacity: int, describe: Callable[[tuple[float, ...]], Description]
) -> SlaveState:
    """The state that `to_json` wrote, every field of it checked.

    Parameters
    ----------
    data : read from JSON
    integers : for each parameter and input, whether it is an Integer
    capacity : most vehicles N
    describe : what values of parameters and inputs say

    Raises
    ------
    ValueError : where no run can come to such a state
    """
    fields = record(data, (*_PLAIN, "members", "platoon"))
    values, here = variables(fields["values"], integers), clock(fields["clock"])
    in_domain, packed = number(fields["in_domain"]), fields["platoon"]
    require(in_domain in (0.0, 1.0))
    platoon, vehicles = None, 0
    if packed is None:
        fresh(here)
    else:
        platoon = _unpack(packed, capacity, describe(values))
        vehicles = platoon.now.v.size
        _require_here(platoon, here)
    members = _members(fields["members"], vehicles)
    return SlaveState(values, here, in_domain, flag(fields["initialising"]), members, platoon)


def _members(data: Any, vehicles: int) -> Members:
    fields = record(data, Members.__dataclass_fields__)
    numbers, joined = fields["vehicles"], count(fields["joined"], vehicles)
    require(isinstance(numbers, list) and (vehicles == 0 or len(numbers) == vehicles))
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


def _pack(platoon: SampledPlatoon) -> dict[str, Any]:
    now, shape = platoon.now, platoon.shape
    assert isinstance(shape, PotentialParameters)
    instant = {
        name: value.tolist() if isinstance(value := getattr(now, name), np.ndarray) else value for name in _INSTANT
    }
    return {"shape": asdict(shape), "now": instant}


def _unpack(data: Any, capacity: int, described: Description) -> SampledPlatoon:
    packed = record(data, ("shape", "now"))
    now = record(packed["now"], _INSTANT)
    require(isinstance(now["v"], list) and 1 <= len(now["v"]) <= capacity)
    n, cost = len(now["v"]), now["cost"]
    require(isinstance(cost, list) and len(cost) == 2 and bound(cost[0]) >= 0.0 and not np.isnan(bound(cost[1])))
    fraction, span = number(now["fraction"], 0.0), number(now["span"])
    require(fraction < 1.0 and 0.0 < span <= 1.0)
    instant = Instant(
        period=count(now["period"]),
        fraction=fraction,
        vehicles=Motion(number(now["x"]), vector(now["s"], n - 1), vector(now["v"], n)),
        a=vector(now["a"], n),
        T_max=bound(now["T_max"]),
        span=span,
        violations=count(now["violations"]),
        cost=(float(cost[0]), float(cost[1])),
    )
    shape = potential(packed["shape"], described.start.constants, described.old)
    loop = loop_of(shape, described.start.constants, described.weights, described.sampling)
    return SampledPlatoon(loop, described.sampling, instant)


def _require_here(platoon: SampledPlatoon, here: Clock) -> None:
    """A time between the last instant and the next, to a period: others would pass without end."""
    period, fraction = here.at()
    since = period - platoon.now.period + fraction - platoon.now.fraction
    require(-1.0 <= since <= 1.0 + TIME_TOLERANCE)
