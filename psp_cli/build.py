"""`psp build`: what `python build_fmu.py` does."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from .options import Network


def build(
    vehicles: Annotated[int, typer.Option("--vehicles", "-n", help="Number of vehicles, at least 2.")] = 7,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Folder to write to.")] = Path("dist"),
    runtime: Annotated[Literal["python", "native"], typer.Option(help="What the FMU runs on.")] = "python",
    platforms: Annotated[
        Literal["host", "all"], typer.Option(help="Native: libraries for this machine, or for all platforms.")
    ] = "host",
    network: Network = None,
) -> None:
    """Build the FMU of a platoon."""
    import build_fmu

    arguments = ["--vehicles", str(vehicles), "--output", str(output), "--runtime", runtime, "--platforms", platforms]
    arguments += ["--network", str(network)] if network else []
    raise typer.Exit(build_fmu.main(arguments))
