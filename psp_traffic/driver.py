"""Who drives: one of SUMO's car-following models, or the controller FMU."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True)
class Driver:
    """A way to drive all vehicles.

    Attributes
    ----------
    name : for tables
    vehicle_type : attributes of SUMO's vType
    fmu : the controller FMU, None if SUMO drives
    parameters : start values of the FMU
    follows : the leader's speed is passed to the controller as the desired one
    """

    name: str
    vehicle_type: Mapping[str, str | float] = field(default_factory=dict)
    fmu: Path | None = None
    parameters: Mapping[str, float] = field(default_factory=dict)
    follows: bool = False


A_MIN, A_MAX = -8.0, 4.0  # [m/s2] roughly the limits of a car on a dry road (ours)


def sumo_drivers() -> list[Driver]:
    """SUMO's IDM, ACC and CACC, with SUMO's defaults."""
    return [Driver(model, {"carFollowModel": model}) for model in ("IDM", "ACC", "CACC")]


def controllers(fmu: Path, bounds: tuple[float, float] = (A_MIN, A_MAX), led: bool = False) -> list[Driver]:
    """The controller with V_new and with V_old; behind a leader also with the leader's speed as the desired one.

    Parameters
    ----------
    fmu : PspController
    bounds : a_min, a_max [m/s2]
    led : whether the leader drives a speed of its own
    """
    common = {"a_min": bounds[0], "a_max": bounds[1], "bad_input": 2, "a_safe": -4.0, "lemma1_policy": 2}
    free: dict[str, str | float] = {"carFollowModel": "IDM", "accel": 100.0, "decel": 100.0, "emergencyDecel": 100.0}
    new, old = common | {"potential": 2}, common | {"potential": 1}
    found = [Driver("V_new", free, fmu, new), Driver("V_old", free, fmu, old)]
    if led:
        found += [Driver("V_new, v_leader", free, fmu, new, True), Driver("V_old, v_leader", free, fmu, old, True)]
    return found
