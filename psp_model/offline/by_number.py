"""Regret by number of vehicles: one evaluation for each, in one table and one picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import fill
from typing import Any

from ..whole_file import whole_file
from .evaluate import Evaluation, as_dict

Scores = Mapping[int, Mapping[str, Mapping[str, Any]]]


def by_number_dict(evaluations: Sequence[Evaluation]) -> dict[str, Any]:
    """The tables as data, for JSON: by number of vehicles.

    Parameters
    ----------
    evaluations : one for each number
    """
    return {"vehicles": {str(each.data.problem.vehicles): as_dict(each) for each in evaluations}}


def scores_by_number(content: Mapping[str, Any]) -> Scores:
    """The scores by number of vehicles and name of the way to choose.

    Parameters
    ----------
    content : from `by_number_dict`, perhaps by way of JSON
    """
    return {
        int(n): {score["name"]: score for score in table["scores"]} for n, table in sorted(content["vehicles"].items())
    }


def regret_markdown(content: Mapping[str, Any]) -> str:
    """Mean regret, and in brackets its 95 % quantile, of each way for each number of vehicles.

    Parameters
    ----------
    content : from `by_number_dict`
    """
    found = scores_by_number(content)
    names = _names(found)
    lines = ["| vehicles | starts | " + " | ".join(names) + " |", "|" + "---|" * (len(names) + 2)]
    for n, scores in sorted(found.items()):
        cells = [_cell(scores[name]) if name in scores else "" for name in names]
        lines.append("| " + " | ".join([str(n), str(scores[names[0]]["starts"]), *cells]) + " |")
    return "\n".join(lines)


def _names(scores: Scores) -> list[str]:
    """All ways to choose, in the order in which they first appear."""
    return list(dict.fromkeys(name for table in scores.values() for name in table))


def _cell(score: Mapping[str, Any]) -> str:
    return f"{100 * score['mean']:.2f} % ({100 * score['p95']:.2f} %)"


def regret_picture(content: Mapping[str, Any], path: Path, command: str) -> None:
    """Mean regret over the number of vehicles, a line for each way, squares for those that serve a few numbers only.

    Parameters
    ----------
    content : from `by_number_dict`
    path : PNG file
    command : that made it, for the caption
    """
    from matplotlib.figure import Figure

    found = scores_by_number(content)
    figure = Figure(figsize=(9, 4.2), layout="constrained")
    axes = figure.subplots()
    for name in _names(found):
        points = [(n, 100 * scores[name]["mean"]) for n, scores in sorted(found.items()) if name in scores]
        axes.semilogy(*zip(*points, strict=True), "o-" if len(points) == len(found) else "s", label=name)
    axes.set(xlabel="vehicles", ylabel="mean regret J/J* - 1 [%]")
    axes.set_title("Starts that no network was trained on")
    axes.legend(fontsize="small", bbox_to_anchor=(1.01, 1.0), loc="upper left")
    axes.grid(alpha=0.3, which="both")
    figure.supxlabel(fill(command, 160), fontsize=6)
    with whole_file(path) as partial:
        figure.savefig(partial, dpi=110)
