"""Regret by number of vehicles: one evaluation for each, in one table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

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
    names = ways_to_choose(found)
    lines = ["| vehicles | starts | " + " | ".join(names) + " |", "|" + "---|" * (len(names) + 2)]
    for n, scores in sorted(found.items()):
        cells = [_cell(scores[name]) if name in scores else "" for name in names]
        lines.append("| " + " | ".join([str(n), str(scores[names[0]]["starts"]), *cells]) + " |")
    return "\n".join(lines)


def ways_to_choose(scores: Scores) -> list[str]:
    """All ways to choose, in the order in which they first appear.

    Parameters
    ----------
    scores : from `scores_by_number`
    """
    return list(dict.fromkeys(name for table in scores.values() for name in table))


def _cell(score: Mapping[str, Any]) -> str:
    return f"{100 * score['mean']:.2f} % ({100 * score['p95']:.2f} %)"
