"""`psp sumo`: the controller FMU in SUMO's traffic, beside SUMO's own drivers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from .bad_input import BadInput
from .interrupt import can_go_on
from .options import Json, command_line
from .output import json_place, keep_stdout, say_on_stderr, write_json
from .pictures import PICTURES, require_ending

if TYPE_CHECKING:
    from psp_model.vehicles.leader import Profile
    from psp_traffic.results import Results

_STARTS, _SWEEP_STARTS = 5, 20


class Situation(StrEnum):
    """Which traffic situation."""

    ALL = "all"
    HIGHWAY = "highway"
    APART = "highway-apart"
    RAMP = "ramp"
    WAVE = "stop-and-go"
    PROFILE = "profile"


def sumo(
    situation: Annotated[Situation, typer.Argument(help="What happens on the road.")] = Situation.ALL,
    fmu: Annotated[Path | None, typer.Option(metavar="FILE.fmu", help="A controller FMU; built if not given.")] = None,
    runtime: Annotated[
        Literal["python", "native"], typer.Option(help="Of the controller that is built; native is faster.")
    ] = "python",
    seed: Annotated[int, typer.Option(help="Of the first start; the others count on from it.", min=0)] = 1,
    starts: Annotated[
        int | None, typer.Option(help="How many. [default: 5, of a sweep 20]", min=1, show_default=False)
    ] = None,
    duration: Annotated[float | None, typer.Option(help="Of every run [s].", min=15.0, max=3600.0)] = None,
    profile: Annotated[
        Path | None,
        typer.Option(metavar="FILE.csv", help="Time [s] and speed [m/s] of the leader. [default: WLTC, phase High]"),
    ] = None,
    sweep: Annotated[
        bool, typer.Option("--sweep", help="Sweep delay and lag instead, on the highway and on the stop-and-go wave.")
    ] = False,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FILE.json", help="Keep every run there, and go on from what is there."),
    ] = None,
    plot: Annotated[
        Path | None,
        typer.Option(metavar="FILE.png|svg|pdf", help="Draw the spacings of the first start, or what the sweep gave."),
    ] = None,
    json: Json = None,
) -> None:
    """Compare V_new and V_old with SUMO's IDM, ACC and CACC: collisions, comfort, capacity, emissions."""
    from tempfile import TemporaryDirectory

    from .fmu_runs import description_of

    require_ending(plot, PICTURES, "--plot")
    keep_stdout(place := json_place(json))
    if fmu is not None and not fmu.exists():
        raise BadInput(f"{fmu} does not exist: build it with build_fmu.py --component controller, or leave --fmu out")
    if fmu is not None and not any(variable.name == "n_active" for variable in description_of(fmu).modelVariables):
        raise BadInput(f"{fmu} is not a controller: build one with build_fmu.py --component controller")
    names = _situations(situation, sweep)
    if plot is not None and len(names) > 1:
        raise BadInput("--plot draws one situation: name one of " + ", ".join(names))
    seeds = range(seed, seed + (starts or (_SWEEP_STARTS if sweep else _STARTS)))
    leader = _leader(profile, names)
    again = command_line()
    can_go_on(lambda: again if output is not None and output.exists() else None)
    with TemporaryDirectory() as folder, _warnings_said():
        used = fmu or _built(Path(folder), runtime)
        results = _results(output, used, profile, duration, sweep)
        if sweep:
            found = _sweep(names, used, seeds, duration, results, plot)
        else:
            found = _compare(names, used, seeds, duration, leader, results)
            if plot is not None:
                _draw_spacings(names[0], used, seed, duration, leader, plot)
    if place is not None:
        write_json(place, found)


@contextmanager
def _warnings_said() -> Iterator[None]:
    """What controllers say goes to stderr as warnings; each begins with situation, driver and start."""
    import logging

    class Said(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            say_on_stderr(f"psp: warning: {' '.join(record.getMessage().split())}")

    log, handler = logging.getLogger("psp_traffic"), Said()
    log.addHandler(handler)
    log.propagate = False
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.propagate = True


def _situations(situation: Situation, sweep: bool) -> list[str]:
    from psp_traffic.compare import SITUATIONS
    from psp_traffic.sweep import DURATIONS

    known = list(DURATIONS if sweep else SITUATIONS)
    if situation is Situation.ALL:
        return known
    if situation not in known:
        raise BadInput(f"{situation} is not swept: choose " + " or ".join(known))
    return [situation.value]


def _built(folder: Path, runtime: str) -> Path:
    import build_fmu

    options = build_fmu.Options(component="controller", runtime=runtime, output=folder)
    return build_fmu.make(options)[0]


def _leader(path: Path | None, names: Sequence[str]) -> Profile | None:
    from psp_model.vehicles.leader import read_profile
    from psp_traffic.scenario import LONGEST

    if path is None:
        return None
    if Situation.PROFILE not in names:
        raise BadInput(f"--profile says nothing to {', '.join(names)}: leave it out, or run the situation profile")
    found = read_profile(path)
    if found.times[-1] > LONGEST:
        raise BadInput(f"{path} lasts {found.times[-1]:g} s, more than {LONGEST:g} s: use a part of it")
    return found


def _results(output: Path | None, fmu: Path, profile: Path | None, duration: float | None, sweep: bool) -> Results:
    """Where the runs are kept, refused where they were made otherwise."""
    from importlib.metadata import version

    from psp_traffic.results import Results, digest
    from psp_traffic.scenario import WLTC_HIGH

    settings = {
        "sweep": sweep,
        "duration": duration,
        "controller": digest(fmu),
        "profile": digest(profile or WLTC_HIGH),
        "sumo": version("libsumo"),
    }
    return Results(output, settings, command_line())


def _compare(
    names: Sequence[str],
    fmu: Path,
    seeds: Sequence[int],
    duration: float | None,
    leader: Profile | None,
    results: Results,
) -> dict[str, Any]:
    """Run the comparison, show its tables, and give it for JSON."""
    from dataclasses import asdict

    from psp_traffic.compare import compare, count, situation, title

    from .progress import steps_done
    from .sumo_tables import show_measures

    rows: dict[str, Any] = {}
    headings = {}
    with steps_done("runs in SUMO", count(names, len(seeds))) as progress:
        for name in names:
            found = {seed: situation(name, seed, duration, leader) for seed in seeds}
            rows[name] = compare(found, fmu, results, progress)
            headings[name] = title(found[seeds[0]], len(seeds))
    for name, of_drivers in rows.items():
        show_measures(headings[name], of_drivers)
    plain = {name: {d: [asdict(one) for one in runs] for d, runs in found.items()} for name, found in rows.items()}
    return {"seeds": list(seeds), "situations": plain}


def _sweep(
    names: Sequence[str], fmu: Path, seeds: Sequence[int], duration: float | None, results: Results, plot: Path | None
) -> dict[str, Any]:
    """Run the sweep, show its tables, and give it for JSON."""
    from dataclasses import asdict

    from psp_traffic.compare import situation
    from psp_traffic.sweep import DELAYS, DURATIONS, LAGS, sweep, title
    from psp_view.traffic import draw_tolerance

    from .progress import steps_done
    from .sumo_tables import show_tolerances

    found = {}
    with steps_done("runs in SUMO", 2 * len(names) * len(seeds) * len(DELAYS) * len(LAGS)) as progress:
        for name in names:
            starts = {seed: situation(name, seed, duration or DURATIONS[name]) for seed in seeds}
            found[name] = sweep(starts, fmu, results, progress=progress)
            if plot is not None:
                _save(draw_tolerance(found[name], title(name, len(seeds)), command_line()), plot)
    plain = {}
    for name, tolerances in found.items():
        show_tolerances(title(name, len(seeds)), tolerances)
        plain[name] = [
            {"driver": driver, "delay": delay, "lag": lag, "trials": [asdict(one) for one in row.trials]}
            for (driver, delay, lag), row in tolerances.items()
        ]
    return {"seeds": list(seeds), "sweeps": plain}


def _draw_spacings(name: str, fmu: Path, seed: int, duration: float | None, leader: Profile | None, plot: Path) -> None:
    """One run of each driver from one start, as a picture."""
    from psp_traffic.compare import drivers, situation
    from psp_traffic.simulation import simulate
    from psp_view.traffic import draw_following

    from .progress import steps_done

    scenario = situation(name, seed, duration, leader)
    wanted = drivers(fmu, scenario.leader is not None)
    records = {}
    with steps_done("runs to draw", len(wanted)) as progress:
        for driver in wanted:
            records[driver.name] = simulate(scenario, driver, seed=seed, to_contact=True)
            progress()
    _save(draw_following(records, scenario.duration, f"{name}, start {seed}", command_line()), plot)


def _save(figure: Any, path: Path) -> None:
    from psp_view.style import save

    say_on_stderr(save(figure, path, command_line()))
