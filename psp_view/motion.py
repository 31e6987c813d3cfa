"""Space-time diagram and phase plots of runs (not in the paper)."""

from __future__ import annotations

from collections.abc import Mapping

import matplotlib
from matplotlib.figure import Figure

from psp_model.analysis.motion import closing_speeds, moving_frame
from psp_model.parameters import PlatoonParameters
from psp_model.run import Run

from .palette import colours
from .style import RC, caption, new_figure


def draw_space_time(runs: Mapping[str, Run], command: str, constants: PlatoonParameters | None = None) -> Figure:
    """Every vehicle's path through space and time, in a frame that drives at v*.

    Parameters
    ----------
    runs : runs by name
    command : the command that makes this very picture, for the caption
    constants : v_star; the paper's by default

    Returns
    -------
    the figure
    """
    constants = constants or PlatoonParameters()
    with matplotlib.rc_context(RC):
        figure = new_figure(3.0 + 3.6 * len(runs), 4.4)
        row = figure.subplots(1, len(runs), sharey=True, squeeze=False)[0]
        for axes, (name, run) in zip(row, runs.items(), strict=True):
            for path, colour in zip(moving_frame(run, constants.v_star).T, colours(run.x.shape[1]), strict=True):
                axes.plot(run.time, path, color=colour)
            axes.set(title=name, xlabel="time [s]")
            axes.margins(x=0.0)
        row[0].set_ylabel("x − x₁(0) − v* t [m]")
        text = f"Paths of the vehicles, leader on top, seen from a frame that drives at v* = {constants.v_star:g} m/s."
        caption(figure, text, command)
    return figure


def draw_phase(runs: Mapping[str, Run], command: str) -> Figure:
    """Spacing against its rate of change, one line per follower, from the start (dot) to the end (square).

    Parameters
    ----------
    runs : runs by name
    command : the command that makes this very picture, for the caption

    Returns
    -------
    the figure
    """
    with matplotlib.rc_context(RC):
        figure = new_figure(3.0 + 3.6 * len(runs), 4.4)
        row = figure.subplots(1, len(runs), squeeze=False)[0]
        for axes, (name, run) in zip(row, runs.items(), strict=True):
            rates, palette = closing_speeds(run), colours(run.v.shape[1])
            for i, colour in enumerate(palette[1:]):
                axes.plot(run.s[:, i], rates[:, i], color=colour, linewidth=1.0, label=f"vehicle {i + 2}")
                axes.plot(run.s[0, i], rates[0, i], "o", color=colour, markersize=4)
                axes.plot(run.s[-1, i], rates[-1, i], "s", color=colour, markersize=4)
            axes.set(title=name, xlabel="spacing s [m]")
        row[0].set_ylabel("ds/dt [m/s]")
        if len(palette) <= 12:
            row[-1].legend()
        caption(figure, "Phase plot of every spacing, from the start (dot) to the end (square).", command)
    return figure
