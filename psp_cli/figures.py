"""`psp figures`: the paper's figures, and some that it lacks."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def figures(
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for the pictures.")] = Path("out/figures"),
) -> None:
    """Draw the paper's figures and some that it lacks."""
    import numpy as np

    from psp_model import BEST_FIXED, V_OLD, PlatoonState, StartDomain, simulate
    from psp_view.runs import save_runs

    s, v = StartDomain().draw(np.random.default_rng(1), 7, 1)
    start = PlatoonState(s[:, 0], v[:, 0])
    runs = {"scenario 1: V_old": simulate(start, V_OLD), "scenario 2: V_new": simulate(start, BEST_FIXED)}
    for file in save_runs(runs, output / "runs.png", f"psp figures -o {output}"):
        typer.echo(file)
