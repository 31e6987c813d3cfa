"""The networks in an FMU's resources, and what they were trained on, known before one is opened."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from psp_model.parameters import PlatoonParameters
from psp_model.selection.network import ParameterNetwork, read_networks
from psp_model.state import StartDomain


@dataclass(frozen=True)
class Training:
    """What a network was trained on.

    Attributes
    ----------
    domain : the starts
    constants : of the model
    """

    domain: StartDomain
    constants: PlatoonParameters


def networks_of(
    resources: Path, noted: Mapping[str, Mapping[str, Any]]
) -> tuple[dict[int, ParameterNetwork], dict[int, Training]]:
    """The networks, none of them opened, which takes time and onnxruntime, and what they were trained on.

    Parameters
    ----------
    resources : folder of the files
    noted : from JSON, what `fmu_src.networks.noted_of` wrote

    Returns
    -------
    both by number of vehicles
    """
    entries = {int(n): entry for n, entry in noted.items()}
    trained = {
        n: Training(StartDomain(**entry["domain"]), PlatoonParameters(**entry["constants"]))
        for n, entry in entries.items()
    }
    return read_networks(resources, {n: entry["file"] for n, entry in entries.items()}), trained
