"""The numbers that a run is judged by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from psp_model.simulate import Run


@dataclass(frozen=True)
class Figure:
    """One number a run is judged by.

    Attributes
    ----------
    label : what it is
    unit : its unit, "1" for none
    value : the number, SI
    """

    label: str
    unit: str
    value: float


def figures_of_run(run: Run) -> list[Figure]:
    """The numbers that runs are compared by.

    Parameters
    ----------
    run : the run
    """
    return [
        Figure("smallest final gap", "m", float(run.s[-1].min())),
        Figure("largest final gap", "m", float(run.s[-1].max())),
        Figure("smallest gap", "m", float(run.s.min())),
        Figure("peak |acceleration|", "m/s²", float(np.abs(run.a).max())),
        Figure("largest speed", "m/s", float(run.v.max())),
        Figure("J", "1", run.J),
        Figure("J, acceleration term", "1", float(run.cost[-1, 0])),
        Figure("J, gap term", "1", float(run.cost[-1, 1])),
        Figure("smallest T_max", "s", float(run.T_max.min())),
        Figure("instants not certified", "1", float(run.violations)),
    ]
