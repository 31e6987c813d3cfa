"""`psp figures`: the paper's figures, and some that it lacks."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .bad_input import BadInput
from .compare import cases_of
from .options import Duration, Network, ScenarioFile, Seed, Set, Vehicles, command_line, gather
from .output import say

if TYPE_CHECKING:
    from psp_model.analysis.cases import Case

NAMES = ("potentials", "runs", "periods", "landscape", "space-time", "phase")


def figures(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the pictures.")] = Path("out/figures"),
    only: Annotated[list[str] | None, typer.Option(help=f"One of {', '.join(NAMES)}; all by default.")] = None,
    pdf: Annotated[bool, typer.Option("--pdf", help="PDF instead of SVG besides PNG.")] = False,
    vehicles: Vehicles = None,
    assignments: Set = None,
    scenario: ScenarioFile = None,
    seed: Seed = None,
    duration: Duration = None,
    network: Network = None,
) -> None:
    """Draw the paper's figures and some that it lacks."""
    wanted = gather(vehicles, scenario, assignments, seed, duration)
    for name in only or ():
        if name not in NAMES:
            raise BadInput(f"--only {name} is not a figure: use one of {', '.join(NAMES)}")
    from psp_view.style import save

    chosen = only or list(NAMES)
    cases = cases_of(wanted, network) if set(chosen) - {"potentials"} else []
    makers = _makers(cases)
    for name in chosen:
        drawn = makers[name](command_line())
        for ending in ("png", "pdf" if pdf else "svg"):
            say(save(drawn, output / f"{name}.{ending}", command_line()))


def _makers(cases: list[Case]) -> dict[str, Callable[[str], Any]]:
    """What draws each figure, given the command for its caption."""
    from psp_view import motion, period, potentials, runs

    named = {case.name: case.run for case in cases}
    return {
        "potentials": potentials.draw_potentials,
        "runs": lambda command: runs.draw_runs(named, command),
        "periods": lambda command: period.draw_periods({case.name: case.certificate for case in cases}, command),
        "landscape": lambda command: _landscape(cases, command),
        "space-time": lambda command: motion.draw_space_time(named, command, cases[0].setup.start.constants),
        "phase": lambda command: motion.draw_phase(named, command),
    }


def _landscape(cases: list[Case], command: str) -> Any:
    """The landscape from the first case's start, with what the cases chose on it."""
    from psp_model.analysis.landscape import landscape, optimum
    from psp_view.landscape import draw_landscape

    setup = cases[0].setup
    scene = landscape(setup.start, weights=setup.weights, T=setup.sampling.T)
    best = optimum(setup.start, scene, setup.weights, setup.sampling.T)
    choices = {"best found": best} | {
        case.name: (case.shape, case.run.J) for case in cases if not case.setup.request.old
    }
    return draw_landscape(scene, choices, command)
