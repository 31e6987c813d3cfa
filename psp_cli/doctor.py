"""`psp doctor`: what on this machine would keep an FMU of ours from loading."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def doctor(fmu: Annotated[Path, typer.Argument(help="The FMU to look at.")]) -> None:
    """Say what here would keep an FMU from loading, and how to mend it.

    The exit code is 0 where nothing needs mending and 1 where something does.
    """
    from fmu_src.doctor import examine

    good = True
    for finding in examine(fmu):
        good = good and finding.good
        remedy = f": {finding.remedy}" if finding.remedy else ""
        text = " ".join(f"{finding.text}{remedy}".split())  # an archive may have put line breaks into it
        typer.echo(f"{'ok  ' if finding.good else 'MEND'}  {text[:2000]}")
    raise typer.Exit(0 if good else 1)
