"""`psp sumo`: the controller FMU in SUMO's traffic, beside SUMO's own drivers."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from .bad_input import BadInput

_STARTS = 5  # of a sweep


class Situation(StrEnum):
    """Which traffic situation."""

    ALL = "all"
    HIGHWAY = "highway"
    RAMP = "ramp"
    WAVE = "stop-and-go"


def sumo(
    situation: Annotated[Situation, typer.Argument(help="What happens on the road.")] = Situation.ALL,
    fmu: Annotated[Path | None, typer.Option(metavar="FILE.fmu", help="PspController.fmu; built if not given.")] = None,
    seed: Annotated[int, typer.Option(help="Of the starts and of SUMO.", min=0)] = 1,
    duration: Annotated[float | None, typer.Option(help="Of every run [s].", min=15.0)] = None,
    sweep: Annotated[
        bool, typer.Option("--sweep", help="Sweep delay and lag on the highway instead, from 5 starts.")
    ] = False,
    output: Annotated[Path | None, typer.Option("--output", "-o", metavar="FILE.md", help="Write the tables.")] = None,
) -> None:
    """Compare V_new and V_old with SUMO's IDM, ACC and CACC: collisions, comfort, capacity, emissions."""
    from importlib.util import find_spec
    from tempfile import TemporaryDirectory

    if find_spec("libsumo") is None or find_spec("sumo") is None:
        raise BadInput("psp sumo needs SUMO: pip install 'psp-platoon[sumo]'")
    if fmu is not None and not fmu.exists():
        raise BadInput(f"{fmu} does not exist: build it with build_fmu.py --component controller, or leave --fmu out")
    with TemporaryDirectory() as folder:
        text = _tables(situation, fmu or _built(Path(folder)), seed, duration, sweep)
    typer.echo(text)
    if output is not None:
        from psp_model.offline.whole_file import write_whole

        from .options import command_line

        write_whole(output, f"`{command_line()}`\n\n{text}\n")


def _built(folder: Path) -> Path:
    from fmu_src.traffic_runtime import build_controller_fmu

    return build_controller_fmu(7, folder)


def _tables(situation: Situation, fmu: Path, seed: int, duration: float | None, sweep: bool) -> str:
    from psp_traffic import compare
    from psp_traffic.measures import table

    found = compare.scenarios(seed, duration)
    if sweep:
        situations = [compare.scenarios(seed + k, duration)[0] for k in range(_STARTS)]
        return compare.tolerance_table([*compare.sweep(fmu, situations, compare.DELAYS, compare.LAGS)])
    wanted = [one for one in found if situation in (Situation.ALL, one.name)]
    parts = []
    for one in wanted:
        rows = compare.compare(one, fmu, seed, lambda line: typer.echo(f"psp: {line}", err=True))
        parts.append(f"**{one.name}**, {one.vehicles} vehicles, {one.duration:g} s\n\n{table(rows)}")
    return "\n\n".join(parts)
