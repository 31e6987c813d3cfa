"""`psp compare`: four ways to choose a potential, from the same start."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from .options import (
    FIXED_INSTEAD,
    Duration,
    Json,
    Network,
    Plot,
    ScenarioFile,
    Seed,
    Set,
    Vehicles,
    command_line,
    gather,
    network_file,
    say_no_network,
)
from .output import json_place, keep_stdout, say, say_on_stderr, write_json
from .pictures import PICTURES, require_ending

if TYPE_CHECKING:
    from psp_model.analysis.cases import Case

    from .scenario import Scenario


def compare(
    vehicles: Vehicles = None,
    assignments: Set = None,
    scenario: ScenarioFile = None,
    seed: Seed = None,
    duration: Duration = None,
    network: Network = None,
    plot: Plot = None,
    json: Json = None,
) -> None:
    """Compare four ways to choose a potential, from one start.

    V_old, V_new fixed, V_new from the network, and from the network with rollouts; a scenario file that names runs has
    those compared instead.
    """
    require_ending(plot, PICTURES, "--plot")
    keep_stdout(place := json_place(json))
    from psp_model.analysis.cases import figures

    from .tables import as_dict, figures_table

    left_out: dict[str, str] = {}
    cases = cases_of(gather(vehicles, scenario, assignments, seed, duration), network, left_out)
    columns = {case.name: figures(case) for case in cases}
    say(figures_table(columns))
    if plot is not None:
        from psp_view.runs import save_runs

        say(save_runs({case.name: case.run for case in cases}, plot, command_line()))
    if place is not None:
        runs = {
            case.name: {"potential": case.origin, "figures": as_dict(columns[case.name]), "warnings": case.warnings}
            for case in cases
        }
        write_json(place, {"runs": runs, "left_out": left_out})


def cases_of(scenario: Scenario, network_path: Path | None, left_out: dict[str, str] | None = None) -> list[Case]:
    """The runs that a scenario names, or the four of a comparison; what is missing or warned of goes to stderr.

    Parameters
    ----------
    scenario : what to run
    network_path : a network of the user's own
    left_out : gets the reason, by name, why a run is missing
    """
    from psp_model.analysis.cases import comparison, run_case, without_repetitions

    from .settings import setup

    left_out = {} if left_out is None else left_out
    n = scenario.vehicles
    network = network_file(n, network_path)
    if network is None:
        say_no_network(n, FIXED_INSTEAD if scenario.runs else "the runs that need one are left out")
    if scenario.runs:
        setups = {name: setup(scenario.values | extra, n, network is not None) for name, extra in scenario.runs.items()}
    else:
        setups = comparison(setup(scenario.values, n, network is not None), network)
        if network is None:
            left_out["runs that need a network"] = f"there is no network for {n} vehicles"
    cases = [run_case(name, one, network, scenario.duration) for name, one in setups.items()]
    shown, repeated = without_repetitions(cases)
    for case in shown:
        for sentence in case.warnings:
            say_on_stderr(f"psp: warning: {case.name}: {sentence}")
    for name, reason in repeated.items():
        say_on_stderr(f"psp: {name} is left out: {reason}")
    left_out |= repeated
    return shown
