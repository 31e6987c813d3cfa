"""`PspController.fmu`, `PspPlant.fmu` and `PspLeader.fmu`: other people's vehicles."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from psp_model.leader import read_profile

from .controller_variables import controller_table, leader_table, plant_table
from .python_runtime import NEEDS, NetworkFile, networks_up_to, pack_slave

CONTROLLER = "Commands accelerations to a platoon of vehicles from their measured gaps and speeds"


def note_on_networks(capacity: int, networks: Mapping[int, NetworkFile]) -> str:
    """What the page of a component says of its networks.

    Parameters
    ----------
    capacity : N
    networks : by number of vehicles
    """
    known = ", ".join(map(str, networks)) or "no number of"
    return (
        f"For 1 to {capacity} vehicles. It has networks for {known} vehicles; for other numbers, and outside their "
        "training domain, alpha_fixed, r_fixed and p_fixed are used, with a warning."
    )


def _of_networks(capacity: int) -> tuple[dict[str, Any], list[NetworkFile], list[str]]:
    """Configuration, networks and notes of a component for 1 to N vehicles."""
    networks = networks_up_to(capacity)
    config = {
        "vehicles": capacity,
        "default_source": 1 if networks else 2,
        "networks": {n: network.name for n, network in networks.items()},
    }
    return config, list(networks.values()), [note_on_networks(capacity, networks), NEEDS]


def build_controller_fmu(capacity: int, output: Path) -> Path:
    """Write PspController.fmu.

    Parameters
    ----------
    capacity : most vehicles N, at least 2
    output : folder

    Returns
    -------
    path of the FMU
    """
    config, networks, notes = _of_networks(capacity)
    table = controller_table(capacity, config["default_source"])
    return pack_slave("PspController", CONTROLLER, table, config, networks, notes, output)


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
    description = "Ideal vehicles on one lane, double integrators, to try a controller on"
    return pack_slave("PspPlant", description, plant_table(vehicles), {"vehicles": vehicles}, [], [NEEDS], output)


def build_leader_fmu(vehicles: int, output: Path, profile: Path | None = None) -> Path:
    """Write PspLeader.fmu.

    Parameters
    ----------
    vehicles : of the platoon that follows; says nothing here
    output : folder
    profile : CSV file of a speed profile to drive instead of the wave

    Returns
    -------
    path of the FMU

    Raises
    ------
    ModelError : where the profile is none
    """
    description = "The speed of a leader, steady or on a stop-and-go wave"
    config: dict[str, Any] = {"vehicles": vehicles}
    more = {}
    if profile is not None:
        read_profile(profile)
        description = f"The speed of a leader who follows {profile.name}"
        config["profile"] = "profile.csv"
        more = {"resources/profile.csv": profile.read_bytes()}
    return pack_slave("PspLeader", description, leader_table(profile is not None), config, [], [NEEDS], output, more)
