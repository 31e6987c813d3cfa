"""Options that several commands share, and what they add up to."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .bad_input import BadInput

if TYPE_CHECKING:
    from psp_model.selection.network import ParameterNetwork

    from .scenario import Scenario

MOST_INSTANTS = 10_000_000  # of a run: 28 hours at T = 0.01 s

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

Plot = Annotated[
    Path | None,
    typer.Option(metavar="FILE.png|svg|pdf", help="Draw spacings, accelerations and speeds, as what the ending says."),
]
Json = Annotated[
    str | None,
    typer.Option("--json", metavar="[FILE.json|-]", help="Write the table as JSON, by default to standard output."),
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
        require_vehicles(vehicles)
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
    require_countable(found)
    return found


def require_vehicles(vehicles: int) -> None:
    """Refuse a number of vehicles that makes no platoon.

    Parameters
    ----------
    vehicles : n

    Raises
    ------
    BadInput : where there are too few or too many
    """
    from .quantities import MOST_VEHICLES

    if not 2 <= vehicles <= MOST_VEHICLES:
        few, remedy = (
            ("few", "a platoon has at least 2") if vehicles < 2 else ("many", f"choose at most {MOST_VEHICLES}")
        )
        raise BadInput(f"{vehicles} vehicles are too {few}", remedy)


def require_countable(scenario: Scenario) -> None:
    """Refuse runs that would not end, or whose outputs no memory would hold.

    Parameters
    ----------
    scenario : what to run

    Raises
    ------
    BadInput : where it has more than MOST_INSTANTS sampling instants or communication points
    """
    for values in [scenario.values | extra for extra in (scenario.runs or {"": {}}).values()]:
        shortest = min(step for step in (scenario.step, values.get("T"), 0.01) if step is not None)
        longest = max(scenario.duration, values.get("rollout_horizon", 0.0))
        if 0 < shortest * MOST_INSTANTS < longest < float("inf"):
            raise BadInput(
                f"{longest:g} s are more than {MOST_INSTANTS:,} instants {shortest:g} s apart: choose a shorter "
                "duration or rollout_horizon, or a longer T and step"
            )


def network_file(vehicles: int, path: Path | None) -> ParameterNetwork | None:
    """The network for n vehicles: the given file, else this project's for n or for any number, else None.

    Parameters
    ----------
    vehicles : n
    path : a network of the user's own
    """
    from psp_model.installed.files import networks_folder
    from psp_model.selection.network import network_path, open_network

    path = path or network_path(vehicles, networks_folder())
    if path is None:
        return None
    network = open_network(path)
    network.require_vehicles(vehicles)
    return network


def say_no_network(vehicles: int, consequence: str) -> None:
    """Say on stderr that there is no network, so that nobody takes what runs instead for the network's choice.

    Parameters
    ----------
    vehicles : n
    consequence : what happens instead
    """
    from .output import say_on_stderr

    say_on_stderr(f"psp: there is no network for {vehicles} vehicles: {consequence}")


FIXED_INSTEAD = "parameter_source starts at 2, a fixed alpha, r, p"


def command_line(*more: str) -> str:
    """The command that was typed, for captions and reports.

    Parameters
    ----------
    more : options to add where they were not given
    """
    import shlex
    import sys

    return shlex.join(["psp", *sys.argv[1:], *(option for option in more if option not in sys.argv)])
