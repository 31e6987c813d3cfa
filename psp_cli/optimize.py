"""`psp optimize`: the global optimum of given starts."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .bad_input import BadInput
from .output import say


def optimize(
    starts: Annotated[
        Path, typer.Option(help="CSV with columns s_2..s_n, v_1..v_n, or NPZ with s0 [B, n-1], v0 [B, n].")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="CSV or NPZ with alpha, r, p, J.")],
    effort: Annotated[str, typer.Option(help="full, or less exact quick or grid.")] = "full",
) -> None:
    """Find alpha, r, p with the least J for each start, over the whole feasible set."""
    import numpy as np

    from psp_model.offline.plan import solve_or_record
    from psp_model.offline.start_files import read_starts, write_optima
    from psp_model.selection.search.engine import Problem
    from psp_model.selection.search.search import EFFORTS, Search

    from .progress import chunks_done

    if effort not in EFFORTS:
        raise BadInput(f"effort {effort!r} is not one of {', '.join(EFFORTS)}: choose one of these")
    if output.suffix.lower() not in (".csv", ".npz"):
        raise BadInput(f"{output} is neither CSV nor NPZ: give --output a name that ends in .csv or .npz")
    found = read_starts(starts)
    search, size = Search(Problem((found.shape[1] + 1) // 2), EFFORTS[effort]), 100
    chunks = [found[first : first + size] for first in range(0, len(found), size)]
    solved = []
    with chunks_done(f"{len(found)} starts", size) as watch:
        for done, chunk in enumerate(chunks, start=1):
            solved.append(solve_or_record(search, chunk, tables=False))
            watch(done, len(chunks))
    columns = {name: np.concatenate([part[name] for part in solved]) for name in solved[0]}
    write_optima(output, columns)
    failed = int((columns["error"] != "").sum())
    say(f"{output}" + (f" ({failed} starts could not be solved: their J is NaN)" if failed else ""))
