"""What each native FMU is made from, by component; `PspPlant` and `PspLeader`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from psp_model.vehicles.leader import read_profile

from ..interface import leader, plant
from ..networks import NetworkFile
from .build import ALONE, NEEDS, NativeFmu, native_controller, native_platoon
from .tables import profile_header

NATIVE = ("platoon", "controller", "plant", "leader")


def native_fmu(
    component: str, vehicles: int, networks: Mapping[int, NetworkFile], profile: Path | None = None
) -> NativeFmu:
    """A component.

    Parameters
    ----------
    component : of NATIVE
    vehicles : most vehicles, at least 2
    networks : from `networks_up_to`; plant and leader have none
    profile : what a leader drives instead of the wave

    Raises
    ------
    ModelError : if the profile is invalid
    """
    if component == "plant":
        return native_plant(vehicles)
    if component == "leader":
        return native_leader(vehicles, profile)
    return {"platoon": native_platoon, "controller": native_controller}[component](vehicles, networks)


def native_plant(vehicles: int) -> NativeFmu:
    """The vehicles.

    Parameters
    ----------
    vehicles : n, at least 2
    """
    return NativeFmu(
        name="PspPlantNative",
        description=f"{plant.DESCRIPTION}; {ALONE}",
        header="plant_model.h",
        vehicles=vehicles,
        table=plant.plant_table(vehicles),
        networks={},
        notes=(NEEDS,),
    )


def native_leader(vehicles: int, profile: Path | None = None) -> NativeFmu:
    """The leader; a profile is compiled in, and lies in resources/ to be looked at.

    Parameters
    ----------
    vehicles : of the platoon that follows; not used here
    profile : CSV file of a speed profile to drive instead of the wave

    Raises
    ------
    ModelError : if the profile is invalid
    """
    rows = None if profile is None else read_profile(profile)
    return NativeFmu(
        name="PspLeaderNative",
        description=f"{leader.description(profile.name if profile else None)}; {ALONE}",
        header="leader_model.h",
        vehicles=vehicles,
        table=leader.leader_table(profile is not None),
        networks={},
        notes=(NEEDS,),
        more={} if profile is None else {"resources/profile.csv": profile.read_bytes()},
        headers={"psp_profile.h": profile_header(rows)},
    )
