"""The explorer's plots, as Plotly descriptions."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from psp_model.analysis.response import Choice, Response
from psp_model.parameters import HILL_WIDTH, P_MAX, P_MIN, PlatoonParameters

from ..palette import colours
from ..runs import QUANTITIES

_CEILING = 8.0  # V and V' are drawn up to this
_EVERY = 4  # sampling instants per point drawn
_GREY = "#8b949e"  # instead of black: visible on light and on dark backgrounds


def _layout(x: str, y: str, **more: Any) -> dict[str, Any]:
    axis = {"gridcolor": "rgba(128,128,128,0.3)", "zerolinecolor": "rgba(128,128,128,0.5)", "automargin": True}
    return {
        "margin": {"l": 50, "r": 10, "t": 10, "b": 40},
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)",
        "showlegend": False,
        "xaxis": {**axis, "title": {"text": x}},
        "yaxis": {**axis, "title": {"text": y}},
        **more,
    }


def _palette(count: int) -> list[str]:
    return [_GREY if colour == "#000000" else colour for colour in colours(count)]


def run_plots(found: Response) -> list[dict[str, Any]]:
    """Spacings, accelerations and speeds over time.

    Parameters
    ----------
    found : the model's response
    """
    plots = []
    for quantity in QUANTITIES:
        data = []
        if found.run is not None:
            palette, time = _palette(found.run.v.shape[1]), found.run.time[::_EVERY].tolist()
            for i, values in enumerate(getattr(found.run, quantity.field).T):
                number = quantity.first_vehicle + i
                line = {"color": palette[number - 1], "width": 1.6}
                data.append({"x": time, "y": values[::_EVERY].tolist(), "name": f"vehicle {number}", "line": line})
        plots.append({"data": data, "layout": _layout("time [s]", quantity.label)})
    return plots


def potential_plots(found: Response) -> list[dict[str, Any]]:
    """V and V' over the spacing, with the spacings at the end of the run on V.

    Parameters
    ----------
    found : the model's response
    """
    s = found.curve.s
    blue = {"color": colours(1)[0], "width": 2}
    potential = [{"x": s.tolist(), "y": _cut(found.curve.V), "name": "V", "line": blue}]
    if found.run is not None:
        ends = found.run.s[-1]
        marker = {"color": colours(2)[1], "size": 8}
        heights = np.interp(ends, s, found.curve.V).tolist()
        name = "spacings at the end"
        potential.append({"x": ends.tolist(), "y": heights, "mode": "markers", "marker": marker, "name": name})
    slope = [{"x": s.tolist(), "y": _cut(found.curve.slope), "name": "V'", "line": blue}]
    return [
        {"data": potential, "layout": _layout("spacing s [m]", "V [m²/s²]")},
        {"data": slope, "layout": _layout("spacing s [m]", "V' [m/s²]")},
    ]


def _cut(values: NDArray[np.float64]) -> list[float | None]:
    return [value if abs(value) <= _CEILING else None for value in values.tolist()]


def feasible_plot(
    choice: Choice,
    edge: tuple[NDArray[np.float64], NDArray[np.float64]],
    found: Response,
    constants: PlatoonParameters,
) -> dict[str, Any]:
    """The feasible set of r and p at the chosen alpha, with the choice on it.

    Parameters
    ----------
    choice : the sliders
    edge : from `feasible_edge`
    found : the model's response
    constants : of the model
    """
    r, p = (table[~np.isnan(edge[1])].tolist() for table in edge)
    outline: dict[str, Any] = {
        "x": [*r, *r[::-1]],
        "y": [*p, *[P_MIN] * len(r)],
        "fill": "toself",
        "mode": "lines",
        "name": "feasible",
    }
    outline |= {"line": {"color": colours(3)[2], "width": 1}, "fillcolor": "rgba(0,158,115,0.25)", "hoverinfo": "skip"}
    name = f"max |V'| = {found.slope:.3g} m/s²"
    here: dict[str, Any] = {"x": [choice.r], "y": [choice.p], "mode": "markers", "name": name}
    here["marker"] = {"color": colours(2)[1], "size": 12, "symbol": "x" if found.problem else "circle"}
    data = [outline] if choice.old else [outline, here]
    layout = _layout(f"r [m], feasible set at α = {choice.alpha:.3g}", "p [1]")
    layout["xaxis"]["range"] = [constants.L, constants.lam - HILL_WIDTH + 0.2]
    layout["yaxis"]["range"] = [P_MIN - 0.2, P_MAX + 0.2]
    return {"data": data, "layout": layout}
