"""`psp evaluate`: what networks cost on the road, on starts that they were not trained on."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .bad_input import BadInput

if TYPE_CHECKING:
    from psp_model.offline.evaluate import Judge
    from psp_model.offline.parquet import Dataset


def evaluate(
    data: Annotated[Path, typer.Option(help="Data set from psp dataset, of other starts than trained on.")],
    network: Annotated[list[Path], typer.Option(help="ONNX file; repeat for several.")],
    rollouts: Annotated[str, typer.Option(help="Numbers of rollouts to judge ranking networks with.")] = "8,16,32",
    starts: Annotated[int | None, typer.Option(help="Use the first so many starts only.", min=1)] = None,
    ipopt: Annotated[int, typer.Option(help="Judge IPOPT from three guesses on so many starts (slow).", min=0)] = 0,
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for table and picture.")] = Path(
        "out/evaluation"
    ),
    card: Annotated[bool, typer.Option("--card", help="Write the first network's model card beside it.")] = False,
) -> None:
    """Judge networks by closed-loop regret: table, picture, and a model card where asked for."""
    import json

    from rich.console import Console
    from rich.markdown import Markdown

    from psp_model.offline.evaluate import Judge, as_dict, as_markdown, picture
    from psp_model.offline.model_card import write_card
    from psp_model.offline.parquet import read_dataset
    from psp_model.offline.whole_file import write_whole

    from .train import widths

    found = read_dataset(data).first(starts)
    judge = Judge(found)
    for path in network:
        _judge_network(judge, path, found, widths(rollouts))
    if ipopt:
        _judge_ipopt(judge, found, ipopt)
    command = "psp " + " ".join(sys.argv[1:])
    stem = network[0].stem
    found_out = json.dumps(as_dict(judge.evaluation) | {"command": command}, indent=1)
    write_whole(output / f"{stem}.json", found_out + "\n")
    picture(judge.evaluation, output / f"{stem}.png", command)
    Console(width=160).print(Markdown(as_markdown(judge.evaluation.scores)))
    typer.echo(output / f"{stem}.png")
    if card:
        typer.echo(write_card(network[0], judge.evaluation, command))


def _judge_network(judge: Judge, path: Path, data: Dataset, rollouts: tuple[int, ...]) -> None:
    """Judge a network alone, and with rollouts where it ranks candidates."""
    from psp_model.network import ParameterNetwork

    found = ParameterNetwork(path)
    if found.trained_on == data.sha256:
        raise BadInput(f"{path} was trained on this very data set: evaluate it on one with another seed")
    judge.network(path.stem, found)
    if found.ranks:
        for count in rollouts:
            judge.rollout(f"{path.stem}, best of {count} by rollout", found, count)


def _judge_ipopt(judge: Judge, data: Dataset, count: int) -> None:
    """Judge IPOPT on the first starts."""
    import numpy as np

    from psp_model.offline.ipopt import LocalSolver

    solver = LocalSolver(data.problem)
    count = min(count, len(data.J))
    judge.add(
        "IPOPT from three guesses",
        np.array([solver.solve(start)[0] for start in data.starts[:count]]),
        np.arange(count),
    )
