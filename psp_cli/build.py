"""`psp build`: what `python build_fmu.py` does."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from .options import Network
from .output import say


def build(
    vehicles: Annotated[int, typer.Option("--vehicles", "-n", help="Number of vehicles, at least 2.")] = 7,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Folder to write to.")] = Path("dist"),
    runtime: Annotated[Literal["python", "native"], typer.Option(help="What the FMU runs on.")] = "python",
    platforms: Annotated[
        Literal["host", "all"], typer.Option(help="Native: libraries for this machine, or for all platforms.")
    ] = "host",
    component: Annotated[
        Literal["platoon", "controller", "plant", "leader"],
        typer.Option(help="The closed loop; for traffic: the controller, vehicles, a leader's speed."),
    ] = "platoon",
    network: Network = None,
    profile: Annotated[
        Path | None, typer.Option(metavar="FILE.csv", help="Leader: speed profile to drive instead of a wave.")
    ] = None,
) -> None:
    """Build an FMU: a platoon, or a part of one for traffic."""
    import build_fmu

    options = build_fmu.Options(vehicles, component, output, runtime, platforms, network, profile)
    path, lack = build_fmu.make(options)
    say(build_fmu.said_of(path, options))
    if lack:
        say(lack)
