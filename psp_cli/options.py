"""Options that several commands share, and what they add up to."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .bad_input import BadInput

if TYPE_CHECKING:
    from psp_model.network import ParameterNetwork

    from .scenario import Scenario

Vehicles = Annotated[
    int | None, typer.Option("--vehicles", "-n", help="Number of vehicles. [default: 7]", show_default=False)
]
Set = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="NAME=VALUE", help="A parameter of the FMU, in SI units or with its unit: T='10 ms'."
    ),
]
ScenarioFile = Annotated[Path | None, typer.Option("--scenario", metavar="FILE.toml", help="Scenario file.")]
Seed = Annotated[int | None, typer.Option(help="Draw the start from the networks' training domain.", min=0)]
Duration = Annotated[
    str | None, typer.Option(help="Length of the run, s or with its unit. [default: 20 s]", show_default=False)
]
Network = Annotated[
    Path | None, typer.Option(metavar="FILE.onnx", help="Network instead of onnx/platoon_N.onnx.", show_default=False)
]


def gather(
    vehicles: int | None, scenario: Path | None, assignments: list[str] | None, seed: int | None, duration: str | None
) -> Scenario:
    """One scenario from a file and the options, which have the last word.

    Parameters
    ----------
    vehicles, scenario, assignments, seed, duration : as the options give them, None where not given

    Raises
    ------
    BadInput : where something is wrong
    """
    from .quantities import quantity
    from .scenario import Scenario, drawn, read_scenario
    from .settings import checked, split

    found = read_scenario(scenario) if scenario else Scenario()
    if vehicles is not None:
        if vehicles < 2:
            raise BadInput(f"{vehicles} vehicles are too few: a platoon has at least 2")
        if scenario and vehicles != found.vehicles:
            raise BadInput(
                f"--vehicles {vehicles} contradicts {scenario}, which has {found.vehicles}: change one of them"
            )
        found = replace(found, vehicles=vehicles)
    values = found.values | (drawn(seed, found.vehicles) if seed is not None else {})
    values |= checked(split(assignments or []), found.vehicles)
    found = replace(found, values=values)
    if duration is not None:
        time = quantity(duration, "s", "duration")
        if not 0 < time < float("inf"):
            raise BadInput(f"duration = {time:g} s must be positive: give it a time above 0 s")
        found = replace(found, duration=time)
    return found


def network_file(vehicles: int, path: Path | None) -> ParameterNetwork | None:
    """The network for n vehicles: the given file, else this project's for n or for any number, else None.

    Parameters
    ----------
    vehicles : n
    path : a network of the user's own
    """
    from psp_model.network import ParameterNetwork, network_path

    path = path or network_path(vehicles, Path(__file__).parents[1] / "onnx")
    if path is None:
        return None
    network = ParameterNetwork(path)
    network.require_vehicles(vehicles)
    return network


def command_line() -> str:
    """The command that was typed, for captions and reports."""
    import shlex
    import sys

    return shlex.join(["psp", *sys.argv[1:]])
