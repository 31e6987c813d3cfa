"""`PspController.fmu` and `PspPlant.fmu`: the controller for other people's vehicles, and vehicles to try it on."""

from __future__ import annotations

from pathlib import Path

from .controller_variables import controller_table, plant_table
from .python_runtime import NEEDS, NetworkFile, network_for, pack_slave


def networks_up_to(capacity: int) -> dict[int, NetworkFile]:
    """This project's networks for 2 to N vehicles, by number of vehicles.

    Parameters
    ----------
    capacity : N
    """
    found = {n: network_for(n) for n in range(2, capacity + 1)}
    return {n: network for n, network in found.items() if network is not None}


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
    networks = networks_up_to(capacity)
    source = 1 if networks else 2
    config = {
        "vehicles": capacity,
        "default_source": source,
        "networks": {n: network.name for n, network in networks.items()},
    }
    known = ", ".join(map(str, networks)) or "no number of"
    notes = [
        f"Controls 1 to {capacity} vehicles. There are networks for {known} vehicles in resources/; for other numbers, "
        "and outside their training domain, alpha_fixed, r_fixed and p_fixed are used, with a warning.",
        NEEDS,
    ]
    description = "Commands accelerations to a platoon of vehicles from their measured gaps and speeds"
    table = controller_table(capacity, source)
    return pack_slave("PspController", description, table, config, list(networks.values()), notes, output)


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
