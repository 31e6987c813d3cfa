"""Regret by number of vehicles: one evaluation for each, in one table and one picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np

from .evaluate import Evaluation, as_dict
from .whole_file import whole_file


def ways(evaluations: Sequence[Evaluation]) -> list[str]:
    """The names of all ways to choose, in the order in which they first appear."""
    return list(dict.fromkeys(answers.name for each in evaluations for answers in each.answers))


def regret_markdown(evaluations: Sequence[Evaluation]) -> str:
    """Mean regret, and in brackets its 95 % quantile, of each way for each number of vehicles."""
    names = ways(evaluations)
    lines = ["| vehicles | starts | " + " | ".join(names) + " |", "|" + "---|" * (len(names) + 2)]
    for each in evaluations:
        found = {score.name: f"{100 * score.mean:.2f} % ({100 * score.p95:.2f} %)" for score in each.scores}
        cells = [str(each.data.problem.vehicles), str(len(each.data.J)), *(found.get(name, "") for name in names)]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def by_number_dict(evaluations: Sequence[Evaluation]) -> dict[str, Any]:
    """The tables as data, for JSON: by number of vehicles."""
    return {"vehicles": {str(each.data.problem.vehicles): as_dict(each) for each in evaluations}}


def regret_picture(evaluations: Sequence[Evaluation], path: Path, command: str) -> None:
    """Mean regret over the number of vehicles, a line for each way.

    Parameters
    ----------
    evaluations : one for each number
    path : PNG file
    command : that made it, for the caption
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 4.2), layout="constrained")
    axes = figure.subplots()
    for name in ways(evaluations):
        found = [
            (each.data.problem.vehicles, 100 * float(np.mean(each.regret(answers))))
            for each in evaluations
            for answers in each.answers
            if answers.name == name
        ]
        numbers, means = zip(*sorted(found), strict=True)
        axes.semilogy(numbers, means, "o-" if len(numbers) == len(evaluations) else "s", label=name)
    axes.set(xlabel="vehicles", ylabel="mean regret J/J* - 1 [%]")
    axes.set_title("Starts that no network was trained on")
    axes.legend(fontsize="small")
    axes.grid(alpha=0.3, which="both")
    figure.supxlabel(fill(command, 130), fontsize=6)
    with whole_file(path) as partial:
        figure.savefig(partial, dpi=110)
