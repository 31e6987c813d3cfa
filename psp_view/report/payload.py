"""The numbers that the page draws, as plain lists."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import to_hex
from numpy.typing import NDArray

from ..cases import Case
from ..motion import moving_frame
from ..potentials import curve
from ..style import OKABE_ITO, colours
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
    cividis = colormaps["cividis"]
    places = np.linspace(0.0, 1.0, vehicles)
    return {
        "light": [to_hex(cividis(0.85 * place)) for place in places],
        "dark": [to_hex(cividis(0.35 + 0.65 * place)) for place in places],
    }


def _bright(palette: list[str]) -> list[str]:
    """The same colours where they can be seen on dark ground; black becomes white, the dark blue a lighter one."""
    return [{"#000000": "#ffffff", "#0072B2": "#3fa7e0"}.get(colour, colour) for colour in palette]


def _table(time: NDArray[np.float64], lines: NDArray[np.float64]) -> dict[str, Any]:
    """Thinned times and one list per line."""
    keep = kept(time, lines)
    return {"t": np.round(time[keep], 6).tolist(), "y": rounded(lines[keep]).T.tolist()}


def _run(case: Case) -> dict[str, Any]:
    run = case.run
    return {
        "name": case.name,
        "T": case.setup.sampling.T,
        "gap": _table(run.time, run.s),
        "acceleration": _table(run.time, run.a),
        "speed": _table(run.time, run.v),
        "place": _table(run.time, moving_frame(run, case.setup.start.constants.v_star)),
        "T_max": _table(run.time, run.T_max[:, None]),
        "J": _table(run.time, run.cost.sum(axis=1)[:, None]),
    }


def _curve(case: Case) -> dict[str, Any]:
    line = curve(case.shape, case.setup.start.constants, case.name, points=601)
    return {
        "name": case.name,
        "s": np.round(line.s, 4).tolist(),
        "V": np.round(np.minimum(line.V, _CURVE_CEILING), 4).tolist(),
        "slope": np.round(np.clip(line.slope, -_CURVE_CEILING, _CURVE_CEILING), 4).tolist(),
    }
