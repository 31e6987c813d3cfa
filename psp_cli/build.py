"""`psp build`: what `python build_fmu.py` does."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def build(
    vehicles: Annotated[int, typer.Option("--vehicles", "-n", help="Number of vehicles, at least 2.")] = 7,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Folder to write to.")] = Path("dist"),
    network: Annotated[
        Path | None, typer.Option(metavar="FILE.onnx", help="Network instead of onnx/platoon_N.onnx.")
    ] = None,
) -> None:
    """Build the FMU of a platoon."""
    import build_fmu

    arguments = ["--vehicles", str(vehicles), "--output", str(output)]
    arguments += ["--network", str(network)] if network else []
    raise typer.Exit(build_fmu.main(arguments))
