"""The networks that go into an FMU, for both runtimes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from psp_model.installed.files import networks_folder
from psp_model.selection.network import ParameterNetwork, network_path, open_network


@dataclass(frozen=True)
class NetworkFile:
    """The network that goes into an FMU, with what its metadata says.

    Attributes
    ----------
    name : file name inside resources/
    content : the file
    domain, constants : what it was trained for
    reader : runs it
    """

    name: str
    content: bytes
    domain: dict[str, float]
    constants: dict[str, float]
    reader: ParameterNetwork


def network_for(vehicles: int, path: Path | None = None) -> NetworkFile | None:
    """The network for n vehicles: the given file, else this project's for n or for any number, else None.

    Parameters
    ----------
    vehicles : n
    path : a network of the user's own

    Raises
    ------
    ModelError : if a file is unreadable or made for another number of vehicles
    """
    path = path or network_path(vehicles, networks_folder())
    if path is None:
        return None
    network = open_network(path)
    network.require_vehicles(vehicles)
    return NetworkFile(path.name, path.read_bytes(), network.domain.as_dict(), dict(vars(network.constants)), network)


def networks_up_to(capacity: int, path: Path | None = None) -> dict[int, NetworkFile]:
    """This project's networks for 2 to N vehicles, by number of vehicles.

    Parameters
    ----------
    capacity : N
    path : a network of the user's own, for N vehicles and possibly also for fewer

    Raises
    ------
    ModelError : where a file is unreadable or made for other numbers of vehicles
    """
    own = network_for(capacity, path) if path else None
    served = [n for n in range(2, capacity + 1) if own and n in own.reader.vehicles]
    found = {n: network_for(n) for n in range(2, capacity + 1) if n not in served}
    networks = {n: network for n, network in found.items() if network is not None}
    if own is None:
        return networks
    taken = any(network.name == own.name for network in networks.values())
    own = replace(own, name=f"own_{own.name}") if taken else own
    return dict(sorted((networks | dict.fromkeys(served, own)).items()))


def noted_of(networks: Mapping[int, NetworkFile]) -> dict[int, dict[str, Any]]:
    """The description of an FMU's networks for its slave, for JSON.

    Parameters
    ----------
    networks : by number of vehicles
    """
    return {
        n: {"file": network.name, "domain": network.domain, "constants": network.constants}
        for n, network in networks.items()
    }


def notes_on_networks(networks: Mapping[int, NetworkFile]) -> list[str]:
    """The description of an FMU's networks on its page.

    Parameters
    ----------
    networks : by number of vehicles
    """
    notes = []
    for network in {network.name: network for network in networks.values()}.values():
        numbers = ", ".join(str(n) for n, other in networks.items() if other.name == network.name)
        bounds = ", ".join(f"{name} = {value:.10g}" for name, value in network.domain.items())
        notes.append(
            f"The network {network.name}, for {numbers} vehicles, was trained on starts with {bounds} (m, m/s, s)."
        )
    text = "For other numbers of vehicles, and outside that domain, alpha_fixed, r_fixed and p_fixed are used."
    return [*notes, text] if notes else ["There is no network in this FMU, so parameter_source starts at 2."]
