"""The landscape of J over r and p from one start, with the choices that can be made on it (not in the paper)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from psp_model.feasible import slope_within_limit
from psp_model.objective import HORIZON
from psp_model.parameters import ALPHA_MIN, HILL_WIDTH, P_MAX, P_MIN, ObjectiveWeights, PotentialParameters
from psp_model.platoon import Sampling
from psp_model.rollout import rollout_costs
from psp_model.state import PlatoonState

from .style import RC, caption, colours, new_figure

_WORST = 30.0  # [%] the colours end here
MARKERS = ("*", "o", "s", "D", "^", "v", "P")


@dataclass(frozen=True, eq=False)
class Landscape:
    """J over a grid of r and p.

    Attributes
    ----------
    alpha : scale of all potentials [1]
    r : (R,) [m]
    p : (P,) [1]
    J : (P, R) objective at the end of the horizon; NaN where the triple is not feasible or T not certified throughout
    """

    alpha: float
    r: NDArray[np.float64]
    p: NDArray[np.float64]
    J: NDArray[np.float64]

    @property
    def best(self) -> PotentialParameters:
        """The grid point with the smallest J."""
        row, column = np.unravel_index(np.nanargmin(self.J), self.J.shape)
        return PotentialParameters(self.alpha, float(self.r[column]), float(self.p[row]))


def landscape(
    start: PlatoonState,
    alpha: float = ALPHA_MIN,
    points: int = 51,
    weights: ObjectiveWeights | None = None,
    T: float = 0.01,
    horizon: float = HORIZON,
) -> Landscape:
    """J over the feasible part of a grid in r and p at one alpha.

    Parameters
    ----------
    start : initial state
    alpha : scale of the potentials [1]; the bound at which the optimum nearly always lies by default
    points : R and P
    weights : of the objective; the paper's by default
    T : sampling period [s]
    horizon : [s]

    Returns
    -------
    Landscape
    """
    constants = start.constants
    r = np.linspace(constants.L, constants.lam - HILL_WIDTH, points + 1)[1:]
    p = np.linspace(P_MIN, P_MAX, points)
    grid = [PotentialParameters(alpha, float(column), float(row)) for row in p for column in r]
    feasible = np.array([slope_within_limit(shape, constants) for shape in grid])
    candidates = [shape for shape, inside in zip(grid, feasible, strict=True) if inside]
    costs, certified = rollout_costs(start, candidates, weights or ObjectiveWeights(), Sampling(T), horizon)
    J = np.full(len(grid), np.nan)
    J[feasible] = np.where(certified, costs, np.nan)
    return Landscape(alpha, r, p, J.reshape(points, points))


def draw_landscape(scene: Landscape, choices: Mapping[str, tuple[PotentialParameters, float]], command: str) -> Figure:
    """The landscape as excess over its minimum, with the optimum of the grid and other choices on it.

    Parameters
    ----------
    scene : the landscape
    choices : triples and their J by name
    command : the command that makes this very picture, for the caption

    Returns
    -------
    the figure
    """
    lowest = float(np.nanmin(scene.J))
    excess = 100.0 * (scene.J / lowest - 1.0)
    beyond = "max" if np.nanmax(excess) > _WORST else "neither"
    marks = {"best of the grid": (scene.best, lowest), **choices}
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
                markersize=13 if marker == "*" else 8,
                markeredgecolor="white",
                label=label,
                linestyle="",
                clip_on=False,
                zorder=5,
            )
        axes.set(xlabel="r [m]", ylabel="p [1]", xlim=(scene.r[0], scene.r[-1]), ylim=(scene.p[0], scene.p[-1]))
        figure.legend(loc="outside upper center", ncols=2)
        text = f"J over r and p at α = {scene.alpha:g}; white: infeasible or not certified. Marks may have another α: "
        text += ", ".join(f"{name} α = {shape.alpha:.3g}" for name, (shape, _) in marks.items()) + "."
        caption(figure, text, command)
    return figure
