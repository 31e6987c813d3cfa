"""`psp simulate`: run an FMU."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from .bad_input import BadInput
from .options import Duration, Json, Plot, ScenarioFile, Seed, Set, command_line, gather
from .output import STDOUT, json_place, keep_stdout, kept_stdout, say, say_on_stderr, write_json
from .pictures import PICTURES, require_ending

if TYPE_CHECKING:
    from psp_model import Run

    from .behind import Behind
    from .scenario import Scenario

DEFAULT_FMU = Path("dist/PspPlatoon.fmu")


def simulate(
    fmu: Annotated[Path | None, typer.Argument(help=f"An FMU that `psp build` made. [default: {DEFAULT_FMU}]")] = None,
    assignments: Set = None,
    scenario: ScenarioFile = None,
    seed: Seed = None,
    duration: Duration = None,
    step: Annotated[str | None, typer.Option(help="Communication step. [default: the sampling period]")] = None,
    csv: Annotated[
        Path | None, typer.Option(metavar="FILE.csv|-", help="Write all outputs; - is standard output.")
    ] = None,
    plot: Plot = None,
    json: Json = None,
    leader: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.csv",
            help="Real vehicles behind a leader who drives this profile, time [s] and speed [m/s]: controller, plant "
            "and leader FMUs together.",
        ),
    ] = None,
    vehicles: Annotated[
        int | None, typer.Option("--vehicles", "-n", help="With --leader: vehicles, his included. [default: 7]")
    ] = None,
    delay: Annotated[str | None, typer.Option(help="With --leader: dead time of the vehicles. [default: 0 s]")] = None,
    lag: Annotated[
        str | None, typer.Option(help="With --leader: time constant of their actuators. [default: 0 s]")
    ] = None,
    age: Annotated[str | None, typer.Option(help="With --leader: age of what is measured. [default: 0 s]")] = None,
    runtime: Annotated[
        Literal["python", "native"] | None, typer.Option(help="With --leader: of the FMUs. [default: python]")
    ] = None,
    names: Annotated[bool, typer.Option("--list", help="List the parameters and stop.")] = False,
) -> None:
    """Run an FMU; print, write or draw what comes out."""
    require_ending(plot, PICTURES, "--plot")
    place = json_place(json)
    keep_stdout(csv, place)
    of_leader = {"--vehicles": vehicles, "--delay": delay, "--lag": lag, "--age": age, "--runtime": runtime}
    if leader is not None:
        others = {"an FMU": fmu, "--scenario": scenario, "--seed": seed, "--step": step, "--list": names or None}
        _require_none(others, "does not go with --leader", "leave it out")
        _show_behind(_behind(leader, of_leader, duration, assignments), csv, plot, place)
        return
    _require_none(of_leader, "goes with --leader only", "give a leader's profile, or leave it out")
    from . import fmu_runs

    if scenario and fmu is None:
        from .scenario import read_scenario

        fmu = read_scenario(scenario).fmu
    fmu = fmu or DEFAULT_FMU
    description = fmu_runs.inspect(fmu)
    if names:
        say(fmu_runs.listing(description))
        if place is not None:
            write_json(place, {"parameters": fmu_runs.as_dict(description)})
        return
    wanted = gather(fmu_runs.vehicles_of(description), scenario, assignments, seed, duration)
    if step is not None:
        wanted = _with_step(wanted, step)
    if str(csv) == STDOUT and len(wanted.runs) > 1:
        raise BadInput(f"--csv - takes one run, not the {len(wanted.runs)} of {scenario}: give it the name of a file")
    runs = _runs(fmu, description, wanted, csv)
    _show(runs, plot, place)


def _require_none(options: Mapping[str, object], why: str, remedy: str) -> None:
    """Refuse options that are given where they make no sense."""
    for name, value in options.items():
        if value is not None:
            raise BadInput(f"{name} {why}", remedy)


def _behind(leader: Path, options: Mapping[str, Any], duration: str | None, assignments: list[str] | None) -> Behind:
    """What is to be run behind a leader."""
    from .behind import Behind, parameters
    from .options import require_vehicles
    from .quantities import quantity
    from .settings import split

    def time(name: str, given: str | None) -> float:
        found = quantity(given or "0", "s", name)
        if not 0 <= found < float("inf"):
            raise BadInput(f"{name} = {found:g} s must be finite and not negative: give it 0 s or more")
        return found

    n = 7 if options["--vehicles"] is None else options["--vehicles"]
    require_vehicles(n)
    delay, lag, age = (time(name, options[f"--{name}"]) for name in ("delay", "lag", "age"))
    length = None if duration is None else time("duration", duration)
    given = parameters(split(assignments or []), n)
    return Behind(leader, n, delay, lag, age, options["--runtime"] or "python", given, length)


def _show_behind(wanted: Behind, csv: Path | None, plot: Path | None, place: str | None) -> None:
    """Run it; print its figures, draw it and write it where asked."""
    from psp_view.results import write_csv, write_rows

    from .behind import columns_of, run_behind
    from .progress import steps_done
    from .tables import as_dict, figures_table

    with ExitStack() as bar:
        run, warnings = run_behind(wanted, lambda steps: bar.enter_context(steps_done("sampling instants", steps + 1)))
    for sentence in dict.fromkeys(warnings):
        say_on_stderr(f"psp: warning: {sentence}")
    if run.contact is not None:
        time, vehicle = run.contact
        say_on_stderr(
            f"psp: warning: vehicle {vehicle} touches vehicle {vehicle - 1} at {time:.4g} s, where the run ends"
        )
    name = f"behind {wanted.leader.name}"
    say(figures_table({name: run.figures()}))
    if str(csv) == STDOUT:
        write_rows(kept_stdout(), columns_of(run))
    elif csv is not None:
        write_csv(csv, columns_of(run))
        say(f"{csv}: {name}")
    if plot is not None:
        from psp_view.behind import save_behind

        say(save_behind(run, plot, command_line()))
    if place is not None:
        write_json(place, {"runs": {name: as_dict(run.figures())}})


def _runs(fmu: Path, description: Any, wanted: Scenario, csv: Path | None) -> dict[str, Run]:
    """Run what is wanted, and write each run's outputs as CSV where asked."""
    from psp_view.results import run_from_result, write_csv, write_rows

    from . import fmu_runs

    runs: dict[str, Run] = {}
    for name, extra in (wanted.runs or {fmu.stem: {}}).items():
        out = fmu_runs.run_fmu(fmu, description, wanted, wanted.values | extra)
        for sentence in out.warnings:
            say_on_stderr(f"psp: warning: {name}: {sentence}" if wanted.runs else f"psp: warning: {sentence}")
        try:
            runs[name] = run_from_result(out.result)
        except KeyError as error:
            raise BadInput(f"{fmu} does not put out {error.args[0]}: build the FMU anew") from None
        if csv is not None:
            file = csv if len(wanted.runs) < 2 else csv.with_name(f"{csv.stem}-{len(runs)}{csv.suffix}")
            if str(csv) == STDOUT:
                write_rows(kept_stdout(), out.result)
            else:
                write_csv(file, out.result)
                say(f"{file}: {name}")
    return runs


def _with_step(scenario: Scenario, step: str) -> Scenario:
    from .quantities import quantity

    length = quantity(step, "s", "step")
    if not 0 < length < float("inf"):
        raise BadInput(f"step = {length:g} s must be positive: give it a time above 0 s")
    return replace(scenario, step=length)


def _show(runs: dict[str, Run], plot: Path | None, place: str | None) -> None:
    """Print the figures of the runs, draw them and write them where asked."""

    from .tables import as_dict, figures_table

    columns = {name: run.figures() for name, run in runs.items()}
    say(figures_table(columns))
    if plot is not None:
        from psp_view.runs import save_runs

        say(save_runs(runs, plot, command_line()))
    if place is not None:
        write_json(place, {"runs": {name: as_dict(figures) for name, figures in columns.items()}})
