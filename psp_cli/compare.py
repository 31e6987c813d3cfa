"""`psp compare`: four ways to choose a potential, from the same start."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .options import (
    FIXED_INSTEAD,
    Duration,
    Network,
    ScenarioFile,
    Seed,
    Set,
    Vehicles,
    command_line,
    gather,
    network_file,
    say_no_network,
)

if TYPE_CHECKING:
    from psp_view.cases import Case

    from .scenario import Scenario


def compare(
    vehicles: Vehicles = None,
    assignments: Set = None,
    scenario: ScenarioFile = None,
    seed: Seed = None,
    duration: Duration = None,
    network: Network = None,
    plot: Annotated[Path | None, typer.Option(metavar="FILE.png", help="Draw gaps, accelerations and speeds.")] = None,
) -> None:
    """Compare four ways to choose a potential, from one start.

    V_old, V_new fixed, V_new from the network, and from the network with rollouts; a scenario file that names runs has
    those compared instead.
    """
    from psp_view.cases import figures

    from .tables import figures_table

    cases = cases_of(gather(vehicles, scenario, assignments, seed, duration), network)
    typer.echo(figures_table({case.name: figures(case) for case in cases}))
    if plot is not None:
        from psp_view.runs import save_runs

        for file in save_runs({case.name: case.run for case in cases}, plot, command_line()):
            typer.echo(file)


def cases_of(scenario: Scenario, network_path: Path | None) -> list[Case]:
    """The runs that a scenario names, or the four of a comparison; what is missing or warned of goes to stderr.

    Parameters
    ----------
    scenario : what to run
    network_path : a network of the user's own
    """
    from psp_view.cases import comparison, run_case

    from .settings import setup

    n = scenario.vehicles
    network = network_file(n, network_path)
    if network is None:
        say_no_network(n, FIXED_INSTEAD if scenario.runs else "the runs that need one are left out")
    if scenario.runs:
        setups = {name: setup(scenario.values | extra, n, network is not None) for name, extra in scenario.runs.items()}
    else:
        setups = comparison(setup(scenario.values, n, network is not None), network)
    cases = []
    for name, one in setups.items():
        case = run_case(name, one, network, scenario.duration)
        for sentence in case.warnings:
            typer.echo(f"psp: warning: {name}: {sentence}", err=True)
        cases.append(case)
    return cases
