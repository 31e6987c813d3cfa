"""The whole state of a slave, in memory and as bytes."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from psp_model.parameters import ObjectiveWeights, PlatoonParameters, PotentialParameters
from psp_model.platoon import Instant, Lemma1Policy, SampledPlatoon, Sampling
from psp_model.state import PlatoonState


@dataclass(frozen=True, eq=False)
class SlaveState:
    """Everything that a slave's future depends on.

    Attributes
    ----------
    values : the parameters, in the order of the table
    start_time, time : start and last communication point [s]
    in_domain : 1.0 if the start lies in the network's domain
    initialising : whether in initialisation mode
    platoon : the platoon, None before there is one
    """

    values: tuple[float, ...]
    start_time: float
    time: float
    in_domain: float
    initialising: bool
    platoon: SampledPlatoon | None


def to_bytes(state: SlaveState) -> bytes:
    """The state as JSON, in which every number reads back exactly; the launcher adds a checksum and the FMU's identity.

    Parameters
    ----------
    state : the state
    """
    fields = {name: getattr(state, name) for name in SlaveState.__dataclass_fields__ if name != "platoon"}
    return json.dumps(fields | {"platoon": state.platoon and _pack(state.platoon)}).encode()


def from_bytes(data: bytes) -> SlaveState:
    """The state that `to_bytes` wrote; the launcher has checked that these are its bytes.

    Parameters
    ----------
    data : as written
    """
    fields = json.loads(data)
    platoon = fields.pop("platoon")
    values = tuple(fields.pop("values"))
    return SlaveState(**fields, values=values, platoon=platoon and _unpack(platoon))


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
