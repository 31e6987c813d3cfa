"""Spacings, accelerations and speeds of several runs side by side (the paper's figures of scenarios 1 and 2)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from psp_model.run import Run

from .palette import colours
from .style import RC, caption, new_figure, save

_MOST_NAMED = 12  # more vehicles than this get a legend of the first and the last only
_WIDE = 10.0  # accelerations that differ by more than this factor between runs share a symmetric logarithmic axis


@dataclass(frozen=True)
class Quantity:
    """One column of the picture.

    Attributes
    ----------
    field : of Run
    label : what it is, with its unit
    first_vehicle : number of the first vehicle that has it
    """

    field: str
    label: str
    first_vehicle: int


QUANTITIES = (
    Quantity("s", "spacing [m]", 2),
    Quantity("a", "acceleration [m/s²]", 1),
    Quantity("v", "speed [m/s]", 1),
)


def peaks(runs: Mapping[str, Run]) -> dict[str, float]:
    """The largest |acceleration| of any vehicle in each run [m/s2].

    Parameters
    ----------
    runs : runs by name
    """
    return {name: float(np.abs(run.a).max()) for name, run in runs.items()}


def draw_runs(runs: Mapping[str, Run], command: str, title: str = "") -> Figure:
    """A row per run; spacings, accelerations and speeds against time side by side, on axes that the runs share.

    Accelerations that differ by more than a factor of ten between runs are drawn on a symmetric logarithmic axis,
    linear within 1 m/s2, because on a plain one the gentler run would be a flat line.

    Parameters
    ----------
    runs : runs by name, drawn in this order
    command : the command that makes this very picture, for the caption
    title : heading

    Returns
    -------
    the figure
    """
    size = peaks(runs)
    symlog = max(size.values()) > _WIDE * max(min(size.values()), 1e-9)
    vehicles = max(run.v.shape[1] for run in runs.values())
    with matplotlib.rc_context(RC):
        figure = new_figure(11.0, 1.0 + 2.3 * len(runs))
        grid = figure.subplots(len(runs), len(QUANTITIES), sharex=True, sharey="col", squeeze=False)
        for axes_row, (name, run) in zip(grid, runs.items(), strict=True):
            for axes, quantity in zip(axes_row, QUANTITIES, strict=True):
                _lines(axes, run.time, getattr(run, quantity.field), quantity, vehicles)
                if quantity.field == "a" and symlog:
                    axes.set_yscale("symlog", linthresh=1.0)
            axes_row[1].set_title(name, fontweight="bold")
        for axes in grid[-1]:
            axes.set_xlabel("time [s]")
        handles, labels = grid[0][1].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), fontsize=8, title=title or None)
        text = "Spacings, accelerations and speeds; peak |acceleration|: "
        text += ", ".join(f"{name} {value:.4g} m/s²" for name, value in size.items()) + "."
        text += " The acceleration axis is logarithmic beyond ±1 m/s²." if symlog else ""
        caption(figure, text, command)
    return figure


def _lines(axes: Axes, time: NDArray[np.float64], table: NDArray[np.float64], quantity: Quantity, n: int) -> None:
    """One line per vehicle; a vehicle has the same colour in every picture of the platoon."""
    palette = colours(n)
    for column in range(table.shape[1]):
        vehicle = quantity.first_vehicle + column
        named = n <= _MOST_NAMED or vehicle in (1, n)
        label = f"vehicle {vehicle}" + (" (leads)" if vehicle == 1 else "")
        axes.plot(time, table[:, column], color=palette[vehicle - 1], label=label if named else None)
    axes.set_ylabel(quantity.label)
    axes.margins(x=0.0)


def save_runs(runs: Mapping[str, Run], path: str | Path, command: str, title: str = "") -> Path:
    """Draw `draw_runs` and write it in the format given by the suffix of `path`.

    Parameters
    ----------
    runs, command, title : as for `draw_runs`
    path : where to; see `style.save`

    Returns
    -------
    the file written
    """
    return save(draw_runs(runs, command, title), path, command)
