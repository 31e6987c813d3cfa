"""`psp doctor`: what on this machine would keep an FMU of ours from loading."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .options import Json
from .output import is_quiet, json_place, keep_stdout, say, write_json


def doctor(fmu: Annotated[Path, typer.Argument(help="The FMU to look at.")], json: Json = None) -> None:
    """Report what here would keep an FMU from loading, and how to fix it.

    The exit code is 0 where nothing needs mending and 1 where something does.
    """
    from fmu_src.doctor import examine

    keep_stdout(place := json_place(json))
    findings = []
    for finding in examine(fmu):
        remedy = f": {finding.remedy}" if finding.remedy else ""
        text = " ".join(f"{finding.text}{remedy}".split())  # an archive may have put line breaks into it
        findings.append({"good": finding.good, "text": finding.text, "remedy": finding.remedy})
        if is_quiet() and not finding.good:
            typer.echo(f"psp: {text[:2000]}", err=True)
        say(f"{'ok  ' if finding.good else 'MEND'}  {text[:2000]}")
    good = all(finding["good"] for finding in findings)
    if place is not None:
        write_json(place, {"fmu": fmu, "good": good, "findings": findings})
    raise typer.Exit(0 if good else 1)
