"""Draws the landscape of J over r and p from one start, with the choices of the selectors (not in the paper)."""

from __future__ import annotations

from collections.abc import Mapping

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from psp_model.analysis.landscape import Landscape
from psp_model.law.potential import PotentialParameters

from .palette import colours
from .style import RC, caption, new_figure

_WORST = 30.0  # [%] the colours end here
MARKERS = ("*", "o", "s", "D", "^", "v", "P")


def draw_landscape(scene: Landscape, choices: Mapping[str, tuple[PotentialParameters, float]], command: str) -> Figure:
    """The landscape as excess over its minimum, with choices on it.

    Parameters
    ----------
    scene : the landscape
    choices : triples and their J by name, the first marked by a star
    command : the command that makes this very picture, for the caption

    Returns
    -------
    the figure
    """
    lowest = float(np.nanmin(scene.J))
    excess = 100.0 * (scene.J / lowest - 1.0)
    beyond = "max" if np.nanmax(excess) > _WORST else "neither"
    marks = choices
    with matplotlib.rc_context(RC | {"axes.grid": False}):
        figure = new_figure(8.0, 5.2)
        axes = figure.subplots()
        mesh = axes.pcolormesh(scene.r, scene.p, excess, cmap="cividis_r", shading="nearest", rasterized=True)
        mesh.set_clim(0.0, min(float(np.nanmax(excess)), _WORST))
        figure.colorbar(mesh, ax=axes, label="J above the best of the grid [%]", extend=beyond)
        for marker, colour, (name, (shape, J)) in zip(MARKERS, colours(len(marks)), marks.items(), strict=False):
            label = f"{name}: J = {J:.4g}"
            axes.plot(
                shape.r,
                shape.p,
                marker,
                color=colour,
                markersize=11 if marker == "*" else 9,
                markeredgecolor="white",
                label=label,
                linestyle="",
                clip_on=False,
                zorder=6 if marker == "*" else 5,  # the star stays in sight where marks coincide
            )
        axes.set(xlabel="r [m]", ylabel="p [1]", xlim=(scene.r[0], scene.r[-1]), ylim=(scene.p[0], scene.p[-1]))
        figure.legend(loc="outside upper center", ncols=2)
        text = f"J over r and p at α = {scene.alpha:g}; white: infeasible or not certified. Marks may have another α: "
        text += ", ".join(f"{name} α = {shape.alpha:.3g}" for name, (shape, _) in marks.items()) + "."
        caption(figure, text, command)
    return figure
