"""`PspController.fmu`, `PspPlant.fmu` and `PspLeader.fmu`: FMUs for vehicles simulated elsewhere."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from psp_model.vehicles.leader import read_profile

from ..interface import controller, leader, plant
from ..networks import NetworkFile, noted_of, notes_on_networks
from .build import NEEDS, pack_slave


def build_controller_fmu(capacity: int, output: Path, networks: Mapping[int, NetworkFile]) -> Path:
    """Write PspController.fmu.

    Parameters
    ----------
    capacity : largest number of vehicles N, at least 2
    output : folder
    networks : from `networks_up_to`; without any parameter_source defaults to 2

    Returns
    -------
    path of the FMU
    """
    source = 1 if networks else 2
    config: dict[str, Any] = {"vehicles": capacity, "default_source": source, "networks": noted_of(networks)}
    table, notes = controller.controller_table(capacity, source), [*notes_on_networks(networks), NEEDS]
    return pack_slave("PspController", controller.DESCRIPTION, table, config, list(networks.values()), notes, output)


def build_plant_fmu(vehicles: int, output: Path) -> Path:
    """Write PspPlant.fmu.

    Parameters
    ----------
    vehicles : n, at least 2
    output : folder

    Returns
    -------
    path of the FMU
    """
    table, config = plant.plant_table(vehicles), {"vehicles": vehicles}
    return pack_slave("PspPlant", plant.DESCRIPTION, table, config, [], [NEEDS], output)


def build_leader_fmu(vehicles: int, output: Path, profile: Path | None = None) -> Path:
    """Write PspLeader.fmu.

    Parameters
    ----------
    vehicles : of the platoon that follows; not used here
    output : folder
    profile : CSV file of a speed profile to drive instead of the wave

    Returns
    -------
    path of the FMU

    Raises
    ------
    ModelError : if the profile is invalid
    """
    config: dict[str, Any] = {"vehicles": vehicles}
    more = {}
    if profile is not None:
        read_profile(profile)
        config["profile"] = "profile.csv"
        more = {"resources/profile.csv": profile.read_bytes()}
    table, description = leader.leader_table(profile is not None), leader.description(profile.name if profile else None)
    return pack_slave("PspLeader", description, table, config, [], [NEEDS], output, more)
