"""`psp report`: runs in one HTML file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .compare import cases_of
from .options import Duration, Network, ScenarioFile, Seed, Set, Vehicles, command_line, gather, network_file
from .output import say
from .pictures import FILMS, PAGES, require_ending

if TYPE_CHECKING:
    from psp_model.analysis.cases import Case


def report(
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE.html")] = Path("out/report.html"),
    vehicles: Vehicles = None,
    assignments: Set = None,
    scenario: ScenarioFile = None,
    seed: Seed = None,
    duration: Duration = None,
    network: Network = None,
    title: Annotated[str, typer.Option(help="Heading.")] = "Platoon report",
    animate: Annotated[
        Path | None, typer.Option(metavar="FILE.mp4|gif", help="Also draw the platoon on the road as a film.")
    ] = None,
) -> None:
    """Write runs into one HTML file that needs no network.

    The runs are those of `psp compare`, or those that a scenario file names.
    """
    require_ending(output, PAGES, "--output")
    require_ending(animate, FILMS, "--animate")
    wanted = gather(vehicles, scenario, assignments, seed, duration)
    from psp_view.report import write_report

    cases = cases_of(wanted, network)
    write_report(cases, output, command_line(), network_file(wanted.vehicles, network), title)
    say(f"{output}: {output.stat().st_size / 1e6:.1f} MB")
    if animate is not None:
        _film(cases, animate)
        say(animate)


def _film(cases: list[Case], path: Path) -> None:
    from psp_view.film import write_film

    write_film(cases, path)
