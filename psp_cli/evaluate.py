"""`psp evaluate`: what networks cost on the road, on starts that they were not trained on."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .bad_input import BadInput
from .options import Json, command_line
from .output import console, json_place, keep_stdout, say, write_json

if TYPE_CHECKING:
    from psp_model.offline.evaluate import Evaluation, Judge
    from psp_model.offline.parquet import Dataset
    from psp_model.selection.network import ParameterNetwork


def evaluate(
    data: Annotated[
        list[Path],
        typer.Option(
            help="Data set from psp dataset, of other starts than trained on; several, one for each number of "
            "vehicles, give a table by number."
        ),
    ],
    network: Annotated[list[Path], typer.Option(help="ONNX file; repeat for several.")],
    rollouts: Annotated[str, typer.Option(help="Numbers of rollouts to judge ranking networks with.")] = "8,16,32",
    starts: Annotated[int | None, typer.Option(help="Use the first so many starts only.", min=1)] = None,
    ipopt: Annotated[int, typer.Option(help="Judge IPOPT from three guesses on so many starts (slow).", min=0)] = 0,
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for table and picture.")] = Path(
        "out/evaluation"
    ),
    card: Annotated[bool, typer.Option("--card", help="Write the first network's model card beside it.")] = False,
    json: Json = None,
) -> None:
    """Judge networks by closed-loop regret: table, picture, and a model card where asked for."""
    from psp_model.offline.parquet import read_dataset

    from .train import widths

    keep_stdout(place := json_place(json))
    found = [read_dataset(path).first(starts) for path in data]
    judged = [_judge(each, network, widths(rollouts), ipopt, several=len(found) > 1) for each in found]
    _report(judged, network[0], output, card, place)


def _judge(data: Dataset, networks: list[Path], rollouts: tuple[int, ...], ipopt: int, several: bool) -> Evaluation:
    """Judge all networks on one data set; with several data sets, those that are for its number of vehicles."""
    from psp_model.offline.evaluate import Judge
    from psp_model.selection.network import ParameterNetwork

    judge = Judge(data)
    for path in networks:
        found = ParameterNetwork(path)
        if several and data.problem.vehicles not in found.vehicles:
            continue
        name = "network for n alone" if several and len(found.vehicles) == 1 else path.stem
        _judge_network(judge, name, found, data, rollouts)
    if ipopt:
        _judge_ipopt(judge, data, ipopt)
    return judge.evaluation


def _report(judged: list[Evaluation], network: Path, output: Path, card: bool, place: str | None) -> None:
    """Write table, picture and perhaps the card, and show the table."""
    import json

    from rich.markdown import Markdown

    from psp_model.offline.by_number import by_number_dict, regret_markdown
    from psp_model.offline.evaluate import as_dict, as_markdown
    from psp_model.offline.model_card import write_card
    from psp_model.whole_file import write_whole
    from psp_view.training import draw_regret, draw_regret_by_number, save_png

    from .dataset import made_by

    command = command_line()
    image = output / f"{network.stem}.png"
    if len(judged) == 1:
        table, content = as_markdown(judged[0].scores), as_dict(judged[0])
        save_png(draw_regret(judged[0], command), image)
    else:
        content = by_number_dict(judged)
        table = regret_markdown(content)
        save_png(draw_regret_by_number(content, command), image)
    write_whole(output / f"{network.stem}.json", json.dumps(content | {"command": command}, indent=1) + "\n")
    console(width=160).print(Markdown(table))
    say(image)
    if card:
        say(write_card(network, judged, command, [made_by(each.data) for each in judged]))
    if place is not None:
        write_json(place, content)


def _judge_network(
    judge: Judge, name: str, network: ParameterNetwork, data: Dataset, rollouts: tuple[int, ...]
) -> None:
    """Judge a network alone, and with rollouts where it ranks candidates."""
    if data.sha256 in network.trained_on:
        raise BadInput(f"{network.path} was trained on this very data set: evaluate it on one with another seed")
    judge.network(name, network)
    if network.ranks:
        for count in rollouts:
            judge.rollout(f"{name}, best of {count} by rollout", network, count)


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
