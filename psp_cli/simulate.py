"""`psp simulate`: run an FMU."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .bad_input import BadInput
from .options import Duration, ScenarioFile, Seed, Set, command_line, gather

if TYPE_CHECKING:
    from psp_model import Run

    from .scenario import Scenario

DEFAULT_FMU = Path("dist/PspPlatoon.fmu")


def simulate(
    fmu: Annotated[Path | None, typer.Argument(help=f"An FMU that `psp build` made. [default: {DEFAULT_FMU}]")] = None,
    assignments: Set = None,
    scenario: ScenarioFile = None,
    seed: Seed = None,
    duration: Duration = None,
    step: Annotated[str | None, typer.Option(help="Communication step. [default: the sampling period]")] = None,
    csv: Annotated[Path | None, typer.Option(metavar="FILE.csv", help="Write all outputs.")] = None,
    plot: Annotated[Path | None, typer.Option(metavar="FILE.png", help="Draw gaps, accelerations and speeds.")] = None,
    names: Annotated[bool, typer.Option("--list", help="List the parameters and stop.")] = False,
) -> None:
    """Run an FMU; print, write or draw what comes out."""
    from psp_view.results import run_from_result, write_csv

    from . import fmu_runs

    if scenario and fmu is None:
        from .scenario import read_scenario

        fmu = read_scenario(scenario).fmu
    fmu = fmu or DEFAULT_FMU
    description = fmu_runs.inspect(fmu)
    if names:
        typer.echo(fmu_runs.listing(description))
        return
    wanted = gather(fmu_runs.vehicles_of(description), scenario, assignments, seed, duration)
    if step is not None:
        wanted = _with_step(wanted, step)
    runs: dict[str, Run] = {}
    for name, extra in (wanted.runs or {fmu.stem: {}}).items():
        out = fmu_runs.run_fmu(fmu, description, wanted, wanted.values | extra)
        for sentence in out.warnings:
            typer.echo(f"psp: warning: {sentence}", err=True)
        try:
            runs[name] = run_from_result(out.result)
        except KeyError as error:
            raise BadInput(f"{fmu} does not put out {error.args[0]}: build the FMU anew") from None
        if csv is not None:
            file = csv if len(wanted.runs) < 2 else csv.with_name(f"{csv.stem}-{len(runs)}{csv.suffix}")
            write_csv(file, out.result)
            typer.echo(f"{file}: {name}")
    _show(runs, plot)


def _with_step(scenario: Scenario, step: str) -> Scenario:
    from .quantities import quantity

    length = quantity(step, "s", "step")
    if not 0 < length < float("inf"):
        raise BadInput(f"step = {length:g} s must be positive: give it a time above 0 s")
    return replace(scenario, step=length)


def _show(runs: dict[str, Run], plot: Path | None) -> None:
    """Print the figures of the runs, and draw them where asked."""

    from .tables import figures_table

    typer.echo(figures_table({name: run.figures() for name, run in runs.items()}))
    if plot is not None:
        from psp_view.runs import save_runs

        for file in save_runs(runs, plot, command_line()):
            typer.echo(file)
