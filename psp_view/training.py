"""Pictures of the offline part: losses of a training, regret of its networks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from psp_model.whole_file import whole_file

if TYPE_CHECKING:
    from psp_model.offline.evaluate import Evaluation


def draw_losses(found: Sequence[tuple[float, float]], best: int, title: str, label: str) -> Figure:
    """Losses over the epochs.

    Parameters
    ----------
    found : (training, validation) loss of each epoch
    best : the epoch that was kept
    title, label : of the picture and of the losses' axis

    Returns
    -------
    the figure
    """
    figure = Figure(figsize=(6, 3.5), layout="constrained")
    axes = figure.subplots()
    for name, values in zip(("training", "validation"), zip(*found, strict=True), strict=True):
        axes.semilogy(range(1, len(found) + 1), values, label=name)
    axes.axvline(best + 1, color="grey", linewidth=0.8, label="kept")
    axes.set(xlabel="epoch", ylabel=label, title=title)
    axes.legend()
    return figure


def draw_regret(evaluation: Evaluation, command: str) -> Figure:
    """Regret curves: which share of the starts stays below which regret.

    Parameters
    ----------
    evaluation : the answers
    command : the command that makes this very picture, for the caption

    Returns
    -------
    the figure
    """
    figure = Figure(figsize=(7, 4.2), layout="constrained")
    axes = figure.subplots()
    for answers in evaluation.answers:
        regret = np.sort(evaluation.regret(answers))
        share = (np.arange(regret.size) + 0.5) / regret.size
        axes.plot(100 * np.maximum(regret, 1e-6), 100 * share, label=f"{answers.name} ({100 * regret.mean():.2f} %)")
    axes.set(xscale="log", xlim=(0.005, 20), xlabel="regret J/J* - 1 [%]", ylabel="share of starts below [%]")
    vehicles, starts = evaluation.data.problem.vehicles, len(evaluation.data.J)
    axes.set_title(f"{vehicles} vehicles, {starts} held-out starts (mean regret)")
    axes.legend(fontsize="small")
    axes.grid(alpha=0.3)
    figure.supxlabel(fill(command, 130), fontsize=6)
    return figure


def draw_regret_by_number(content: Mapping[str, Any], command: str) -> Figure:
    """Mean regret over the number of vehicles, a line for each selector, squares if it serves a few numbers only.

    Parameters
    ----------
    content : from `psp_model.offline.by_number.by_number_dict`, perhaps by way of JSON
    command : the command that makes this very picture, for the caption

    Returns
    -------
    the figure
    """
    from psp_model.offline.by_number import scores_by_number, ways_to_choose

    found = scores_by_number(content)
    figure = Figure(figsize=(9, 4.2), layout="constrained")
    axes = figure.subplots()
    for name in ways_to_choose(found):
        points = [(n, 100 * scores[name]["mean"]) for n, scores in sorted(found.items()) if name in scores]
        axes.semilogy(*zip(*points, strict=True), "o-" if len(points) == len(found) else "s", label=name)
    axes.set(xlabel="vehicles", ylabel="mean regret J/J* - 1 [%]")
    axes.set_title("Starts that no network was trained on")
    axes.legend(fontsize="small", bbox_to_anchor=(1.01, 1.0), loc="upper left")
    axes.grid(alpha=0.3, which="both")
    figure.supxlabel(fill(command, 160), fontsize=6)
    return figure


def save_png(figure: Figure, path: Path, dpi: int = 110) -> None:
    """Write a figure as PNG, whole or not at all.

    Parameters
    ----------
    figure : from a function above
    path : where to; missing folders are made
    dpi : pixels per inch
    """
    with whole_file(path) as partial:
        figure.savefig(partial, dpi=dpi)
