"""V_new and its slope under alpha, r and p (the paper's figures of both)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import matplotlib
from matplotlib.figure import Figure

from psp_model.analysis.curves import Curve, curve
from psp_model.law.potential import PotentialParameters
from psp_model.parameters import PlatoonParameters

from .palette import colours
from .style import LINE_STYLES, RC, caption, new_figure

BASE = PotentialParameters(alpha=1e-3, r=10.0, p=5.0)
"""What the parameters that a panel does not vary are set to (ours: the paper does not give them)."""

VARIED: dict[str, tuple[float, ...]] = {"alpha": (1e-3, 1e-2, 1e-1), "r": (8.0, 12.0), "p": (6.0, 5.0)}
"""What each panel varies: r and p as in the paper, alpha over its feasible range (ours)."""

_UNITS = {"alpha": "", "r": " m", "p": ""}
_LETTERS = {"alpha": "α", "r": "r", "p": "p"}


def family(name: str, values: Sequence[float], constants: PlatoonParameters, base: PotentialParameters) -> list[Curve]:
    """The curves of one panel: `base` with one parameter varied.

    Parameters
    ----------
    name : "alpha", "r" or "p"
    values : what to set it to
    constants : L and lambda
    base : the other two parameters

    Returns
    -------
    one curve per value
    """
    shapes = [replace(base, **{name: value}) for value in values]
    return [
        curve(shape, constants, f"{_LETTERS[name]} = {value:g}{_UNITS[name]}")
        for shape, value in zip(shapes, values, strict=True)
    ]


def draw_potentials(command: str, constants: PlatoonParameters | None = None) -> Figure:
    """V_new (top) and V_new' (bottom) under alpha, r and p.

    Parameters
    ----------
    command : the command that makes this very picture, for the caption
    constants : the paper's by default

    Returns
    -------
    the figure
    """
    constants = constants or PlatoonParameters()
    with matplotlib.rc_context(RC):
        figure = new_figure(11.0, 6.2)
        grid = figure.subplots(2, len(VARIED), sharex=True, sharey="row")
        for column, (name, values) in enumerate(VARIED.items()):
            curves = family(name, values, constants, BASE)
            for line, (colour, style) in zip(
                curves, zip(colours(len(curves)), LINE_STYLES, strict=False), strict=False
            ):
                grid[0][column].plot(line.s, line.V, style, color=colour, label=line.label)
                grid[1][column].plot(line.s, line.slope, style, color=colour)
            grid[0][column].set_title(f"influence of {_LETTERS[name]}")
            grid[0][column].legend()
            grid[1][column].set_xlabel("spacing s [m]")
        grid[0][0].set(ylabel="V_new(s) [m²/s²]", ylim=(0.0, 6.0), xlim=(constants.L, constants.lam + 1.0))
        grid[1][0].set(ylabel="V_new'(s) [m/s²]", ylim=(-6.0, 6.0))
        text = "The potential V_new and its slope; parameters that a panel does not vary are "
        text += f"α = {BASE.alpha:g}, r = {BASE.r:g} m, p = {BASE.p:g}. Both rows are cut off where V rises towards L."
        caption(figure, text, command)
    return figure
