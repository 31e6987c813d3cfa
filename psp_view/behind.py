"""A platoon behind a leader who drives himself: clearances, speeds, accelerations, brake margin."""

from __future__ import annotations

from pathlib import Path

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from psp_model.analysis.behind import Batch, BehindLeader

from .palette import colours
from .style import RC, caption, new_figure, save

_MOST_NAMED = 12  # more vehicles than this get a legend of the first and the last only


def draw_behind(run: BehindLeader, command: str, title: str = "") -> Figure:
    """Four quantities against time; a contact is a red line.

    Parameters
    ----------
    run : what became of the platoon
    command : the command that makes this very picture, for the caption
    title : heading

    Returns
    -------
    the figure
    """
    with matplotlib.rc_context(RC):
        figure = new_figure(11.0, 6.4)
        (clearance, speed), (acceleration, margin) = figure.subplots(2, 2, sharex=True)
        _lines(clearance, run.time, run.clearance, 2, "clearance [m]")
        _lines(speed, run.time, run.v, 1, "speed [m/s]")
        _lines(acceleration, run.time[:-1], run.mean_accelerations, 1, "acceleration [m/s²]")
        clearance.set_ylim(bottom=0.0)
        speed.set_ylim(bottom=0.0)
        margin.plot(run.time, run.brake_margin, color="#444444")
        margin.set_ylabel("brake margin [m/s²]")
        margin.set_ylim(0.0, 12.5)
        for axes in (clearance, speed, acceleration, margin):
            axes.margins(x=0.0)
            if run.contact is not None:
                axes.axvline(run.contact[0], color="#cc0000", linewidth=2.5)
        for axes in (acceleration, margin):
            axes.set_xlabel("time [s]")
        handles, labels = speed.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), fontsize=8, title=title or None)
        caption(figure, _text(run), command)
    return figure


def _text(run: BehindLeader) -> str:
    """What the picture shows."""
    gains = f"Root mean square acceleration, last vehicle over leader {run.gain(-1, 0):.2f}, over first follower "
    gains += f"{run.gain(-1, 1):.2f}."
    if run.contact is not None:
        time, vehicle = run.contact
        return f"Vehicle {vehicle} touches vehicle {vehicle - 1} at {time:.4g} s (red). {gains}"
    least = f"Least clearance {run.clearance.min():.2f} m."
    return f"{least} Brake margin: how hard the leader may brake from then on. {gains}"


def _lines(axes: Axes, time: Batch, table: Batch, first: int, label: str) -> None:
    """One line per vehicle, in the colour that it has in every picture of a platoon."""
    n = first - 1 + table.shape[1]
    palette = colours(n)
    for column in range(table.shape[1]):
        vehicle = first + column
        named = n <= _MOST_NAMED or vehicle in (1, n)
        name = f"vehicle {vehicle}" + (" (leads)" if vehicle == 1 else "")
        axes.plot(time, table[:, column], color=palette[vehicle - 1], label=name if named else None)
    axes.set_ylabel(label)


def save_behind(run: BehindLeader, path: str | Path, command: str, title: str = "") -> Path:
    """Draw `draw_behind` and write it in the format given by the suffix of `path`.

    Parameters
    ----------
    run, command, title : as for `draw_behind`
    path : where to; see `style.save`

    Returns
    -------
    the file written
    """
    return save(draw_behind(run, command, title), path, command)
