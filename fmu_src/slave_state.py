"""The whole state of a slave, in memory and as bytes."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from psp_model.clock import Clock
from psp_model.parameters import ObjectiveWeights, PlatoonParameters, PotentialParameters
from psp_model.platoon import Instant, Lemma1Policy, SampledPlatoon, Sampling
from psp_model.state import PlatoonState


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


def to_bytes(state: SlaveState) -> bytes:
    """The state as JSON, in which every number reads back exactly; the launcher adds a checksum and the FMU's identity.

    Parameters
    ----------
    state : the state
    """
    fields = {name: getattr(state, name) for name in ("values", "clock", "in_domain", "initialising")}
    parts = {"members": asdict(state.members), "platoon": state.platoon and _pack(state.platoon)}
    return json.dumps(fields | parts).encode()


def from_bytes(data: bytes) -> SlaveState:
    """The state that `to_bytes` wrote; the launcher has checked that these are its bytes.

    Parameters
    ----------
    data : as written
    """
    fields = json.loads(data)
    members, platoon, values = fields.pop("members"), fields.pop("platoon"), tuple(fields.pop("values"))
    clock = Clock(*fields.pop("clock"))
    members["vehicles"] = tuple(members["vehicles"])
    return SlaveState(
        **fields, values=values, clock=clock, members=Members(**members), platoon=platoon and _unpack(platoon)
    )


def _pack(platoon: SampledPlatoon) -> dict[str, Any]:
    start, now = platoon.start, platoon.now
    return {
        "constants": asdict(start.constants),
        "start": {"s": start.s.tolist(), "v": start.v.tolist(), "x_leader": start.x_leader},
        "shape": asdict(platoon.shape),
        "weights": asdict(platoon.weights),
        "sampling": asdict(platoon.sampling),
        "now": {
            name: value.tolist() if isinstance(value := getattr(now, name), np.ndarray) else value
            for name in Instant.__dataclass_fields__
        },
    }


def _unpack(packed: dict[str, Any]) -> SampledPlatoon:
    sampling = packed["sampling"] | {"policy": Lemma1Policy(packed["sampling"]["policy"])}
    now: dict[str, Any] = {
        name: np.array(value) if isinstance(value, list) else value for name, value in packed["now"].items()
    }
    return SampledPlatoon.resume(
        PlatoonState(constants=PlatoonParameters(**packed["constants"]), **packed["start"]),
        PotentialParameters(**packed["shape"]),
        ObjectiveWeights(**packed["weights"]),
        Sampling(**sampling),
        Instant(**now),
    )
