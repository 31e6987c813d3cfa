"""`psp dataset`: starts with their global optima, in one Parquet file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .bad_input import BadInput
from .interrupt import can_go_on
from .options import command_line
from .output import say

if TYPE_CHECKING:
    from psp_model.offline.parquet import Dataset


def dataset(
    starts: Annotated[int, typer.Option(help="Number of starts.", min=1)] = 6000,
    seed: Annotated[int, typer.Option(help="Seed of the starts.", min=0)] = 1,
    vehicles: Annotated[int, typer.Option("--vehicles", "-n", help="Number of vehicles.", min=2)] = 7,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Parquet file.", show_default=False)] = None,
    effort: Annotated[
        str, typer.Option(help="full, quick, or grid: the best of a grid, for many starts to train on.")
    ] = "full",
    tables: Annotated[bool, typer.Option(help="Keep J on the main grid, which recipe cost trains on.")] = True,
    chunk: Annotated[int, typer.Option(help="Starts that are solved together.", min=1)] = 100,
    resume: Annotated[bool, typer.Option("--resume", help="Go on where an interrupted run stopped.")] = False,
    scheduler: Annotated[str | None, typer.Option(help="Address of a Dask scheduler to solve the chunks.")] = None,
) -> None:
    """Draw starts from the training domain and solve them."""
    from psp_model.offline.dataset import make_dataset, parts_of
    from psp_model.offline.plan import Plan
    from psp_model.selection.search.engine import Problem
    from psp_model.selection.search.search import EFFORTS

    from .progress import chunks_done

    if effort not in EFFORTS:
        raise BadInput(f"effort {effort!r} is not one of {', '.join(EFFORTS)}: choose one of these")
    path = output or Path(f"out/data/platoon_{vehicles}_{starts}_{seed}.parquet")
    plan = Plan(starts, seed, Problem(vehicles), effort=effort, tables=tables, chunk=chunk)
    again = command_line("--resume")
    can_go_on(lambda: again if parts_of(path).exists() else None)
    with chunks_done(f"{starts} starts of {vehicles} vehicles", plan.chunk) as watch:
        make_dataset(plan, path, resume=resume, scheduler=scheduler, watch=watch)
    say(path)


def made_by(data: Dataset) -> str:
    """The command that makes a data set.

    Parameters
    ----------
    data : the data set
    """
    drawn = f"--starts {data.drawn} --seed {data.seed} --effort {data.effort}"
    return f"psp dataset --vehicles {data.problem.vehicles} {drawn}"
