"""Pictures of traffic: clearances and speeds behind a leader, and which delay and lag are tolerated together."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .palette import colours
from .style import RC, caption, new_figure

if TYPE_CHECKING:
    from psp_traffic.simulation import Record
    from psp_traffic.sweep import Case, Tolerance

_MOST_SHOWN = 60.0  # [m] of clearance; SUMO's drivers may fall back further


def draw_following(records: Mapping[str, Record], duration: float, title: str, command: str) -> Figure:
    """A row per driver: clearances on the through lane, and speeds; a run that ended in a contact ends there.

    Parameters
    ----------
    records : runs by name of the driver
    duration : of a whole run [s]
    title : heading
    command : the command that makes this very picture, for the caption

    Returns
    -------
    the figure
    """
    from psp_traffic.measures import contact, spacings
    from psp_traffic.scenario import LENGTH

    with matplotlib.rc_context(RC):
        figure = new_figure(11.0, 1.3 + 1.35 * len(records))
        grid = figure.subplots(len(records), 2, sharex=True, sharey="col", squeeze=False)
        for (left, right), (name, record) in zip(grid, records.items(), strict=True):
            palette, free = colours(record.v.shape[1]), spacings(record)[0] - LENGTH
            for i in range(free.shape[1]):
                left.plot(record.time, free[:, i], color=palette[i + 1], linewidth=1.0)
            for i, colour in enumerate(palette):
                label = f"vehicle {i + 1}" + (" (leads)" if i == 0 else "")
                right.plot(record.time, record.v[:, i], color=colour, linewidth=1.0, label=label)
            touched = contact(record)
            if np.isfinite(touched):
                for axes in (left, right):
                    axes.axvline(touched, color="#D55E00", linewidth=0.8)
                left.text(touched + 0.01 * duration, 0.8 * _MOST_SHOWN, f"contact at {touched:.1f} s", fontsize=8)
            left.set(ylabel="clearance [m]", ylim=(0.0, _MOST_SHOWN), xlim=(0.0, duration))
            left.set_title(name, loc="left", fontweight="bold")
            right.set_ylabel("speed [m/s]")
        for axes in grid[-1]:
            axes.set_xlabel("time [s]")
        handles, labels = grid[0][1].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), fontsize=8, title=title)
        text = f"Clearance ahead of each follower and all speeds; clearances above {_MOST_SHOWN:g} m are not shown."
        caption(figure, text, command)
    return figure


def draw_tolerance(found: Mapping[Case, Tolerance], title: str, command: str) -> Figure:
    """Share of the starts that ended in a contact, over delay and lag, a map for each driver.

    Parameters
    ----------
    found : from `psp_traffic.sweep.sweep`
    title : heading
    command : the command that makes this very picture, for the caption

    Returns
    -------
    the figure
    """
    drivers = list(dict.fromkeys(driver for driver, *_ in found))
    with matplotlib.rc_context(RC | {"axes.grid": False}):
        figure = new_figure(1.6 + 4.4 * len(drivers), 4.6)
        row = figure.subplots(1, len(drivers), sharey=True, squeeze=False)[0]
        for axes, driver in zip(row, drivers, strict=True):
            image = _map(axes, found, driver)
            axes.set(title=driver, xlabel="lag of the actuators [s]")
        row[0].set_ylabel("delay of the sensors [s]")
        figure.colorbar(image, ax=list(row), label="share of starts with a contact")
        figure.suptitle(title, fontsize=9)
        text = "In the fields: number of starts that ended in a contact, else the least clearance of all starts."
        caption(figure, text, command)
    return figure


def _map(axes: Axes, found: Mapping[Case, Tolerance], driver: str) -> matplotlib.image.AxesImage:
    """One driver's map; rows and columns are the values that were run, not to scale."""
    delays = sorted({delay for name, delay, _ in found if name == driver})
    lags = sorted({lag for name, _, lag in found if name == driver})
    cells = [[found[driver, delay, lag] for lag in lags] for delay in delays]
    share = np.array([[cell.collided / len(cell.trials) for cell in line] for line in cells])
    image = axes.imshow(share, cmap="cividis", vmin=0.0, vmax=1.0, origin="lower", aspect="auto")
    for j, line in enumerate(cells):
        for i, cell in enumerate(line):
            text = f"{cell.collided} of {len(cell.trials)}" if cell.collided else f"{cell.clearance_min:.2f} m"
            axes.text(
                i, j, text, ha="center", va="center", fontsize=7, color="black" if share[j, i] > 0.55 else "white"
            )
    axes.set_xticks(range(len(lags)), [f"{lag:g}" for lag in lags])
    axes.set_yticks(range(len(delays)), [f"{delay:g}" for delay in delays])
    return image
