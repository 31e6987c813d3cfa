"""The numbers that the page draws, as plain lists."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from psp_model.analysis.cases import Case
from psp_model.analysis.curves import curve
from psp_model.analysis.motion import moving_frame
from psp_model.run import Run

from ..palette import OKABE_ITO, cividis, colours
from .thin import kept, rounded

_CURVE_CEILING = 8.0  # [m2/s2] and [m/s2] potentials and slopes are drawn up to this; they are infinite at L


def payload(cases: Sequence[Case]) -> dict[str, Any]:
    """Everything that the page's scripts draw.

    Parameters
    ----------
    cases : the runs, all with the same constants

    Returns
    -------
    dictionary that JSON can hold
    """
    constants = cases[0].setup.start.constants
    n = cases[0].run.v.shape[1]
    return {
        "vehicles": n,
        "duration": max(float(case.run.time[-1]) for case in cases),
        "v_star": constants.v_star,
        "L": constants.L,
        "palette": palettes(n),
        "runPalette": {"light": colours(len(cases)), "dark": _bright(colours(len(cases)))},
        "runs": [_run(case) for case in cases],
        "curves": [_curve(case) for case in cases],
    }


def palettes(vehicles: int) -> dict[str, list[str]]:
    """Colours of the vehicles on light and on dark ground.

    Parameters
    ----------
    vehicles : n
    """
    if vehicles < len(OKABE_ITO):
        return {"light": colours(vehicles), "dark": _bright(colours(vehicles))}
    places = np.linspace(0.0, 1.0, vehicles)
    return {
        "light": [cividis(0.85 * place) for place in places],
        "dark": [cividis(0.35 + 0.65 * place) for place in places],
    }


def _bright(palette: list[str]) -> list[str]:
    """The same colours on dark ground: black becomes white."""
    return ["#ffffff" if colour == "#000000" else colour for colour in palette]


def _table(time: NDArray[np.float64], lines: NDArray[np.float64]) -> dict[str, Any]:
    """Thinned times and one list per line."""
    keep = kept(time, lines)
    return {"t": np.round(time[keep], 6).tolist(), "y": rounded(lines[keep]).T.tolist()}


def _run(case: Case) -> dict[str, Any]:
    run = case.run
    return {
        "name": case.name,
        "T": case.setup.sampling.T,
        "spacing": _table(run.time, run.s),
        "acceleration": _table(run.time, run.a),
        "speed": _table(run.time, run.v),
        "place": _table(run.time, moving_frame(run, case.setup.start.constants.v_star)),
        "T_max": _bounds(run),
        "J": _table(run.time, run.cost.sum(axis=1)[:, None]),
    }


def _bounds(run: Run) -> dict[str, Any]:
    """T_max, thinned by its logarithm because it is drawn on a logarithmic axis."""
    keep = kept(run.time, np.log10(run.T_max)[:, None])
    bounds = [float(f"{value:.6g}") for value in run.T_max[keep]]
    return {"t": np.round(run.time[keep], 6).tolist(), "y": [bounds]}


def _curve(case: Case) -> dict[str, Any]:
    line = curve(case.shape, case.setup.start.constants, case.name, points=601)
    return {
        "name": case.name,
        "s": np.round(line.s, 4).tolist(),
        "V": _cut(line.V),
        "slope": _cut(line.slope),
    }


def _cut(values: NDArray[np.float64]) -> list[float | None]:
    """The values, with nothing where they are too large to draw."""
    return [round(value, 4) if abs(value) <= _CURVE_CEILING else None for value in values.tolist()]
