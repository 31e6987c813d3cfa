"""The output of a run, and how it is displayed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .figures import Figure, figures_table, largest, smallest, warned
from .law.potential import Potential
from .show import figure, picture
from .state import shortened


@dataclass(frozen=True, eq=False, repr=False)
class Run:
    """The output of a run, K times along the first axis; `simulate` gives read-only arrays.

    Attributes
    ----------
    time : (K,) [s]
    x, v, a : (K, n) positions [m], speeds [m/s], accelerations [m/s2]
    s : (K, n-1) spacings [m]
    T_max : (K,) Lemma 1's bound at the last sampling instant [s]
    cost : (K, 2) running terms of J, of acceleration and of spacings
    violations : sampling instants at which T was not certified
    potential : in use, None where the run does not say
    warnings : sentences, in the order in which they came: why another potential is in use than asked for, and where
        policy 2 went on without a certificate
    """

    time: NDArray[np.float64]
    x: NDArray[np.float64]
    s: NDArray[np.float64]
    v: NDArray[np.float64]
    a: NDArray[np.float64]
    T_max: NDArray[np.float64]
    cost: NDArray[np.float64]
    violations: int
    potential: Potential | None = None
    warnings: tuple[str, ...] = ()

    @property
    def J(self) -> float:
        """The objective at the end of the run."""
        return float(self.cost[-1].sum())

    def figures(self) -> list[Figure]:
        """The numbers that runs are compared by."""
        return [
            Figure("smallest final spacing", "m", smallest(self.s[-1])),
            Figure("largest final spacing", "m", largest(self.s[-1])),
            Figure("smallest spacing", "m", smallest(self.s)),
            Figure("peak |acceleration|", "m/s²", float(np.abs(self.a).max())),
            Figure("largest speed", "m/s", float(self.v.max())),
            Figure("J", "1", self.J),
            Figure("J, acceleration term", "1", float(self.cost[-1, 0])),
            Figure("J, spacing term", "1", float(self.cost[-1, 1])),
            Figure("smallest T_max", "s", float(self.T_max.min())),
            Figure("instants not certified", "1", float(self.violations)),
        ]

    def __repr__(self) -> str:
        """A short table."""
        return "\n".join([figures_table(self._title(), self.figures()), *warned(self.warnings)])

    def _title(self) -> str:
        with_it = "" if self.potential is None else f", {shortened(str(self.potential))}"
        n = self.v.shape[1]
        return f"Run of {n} vehicle{'s' * (n > 1)} over {self.time[-1]:g} s{with_it}"

    def _repr_html_(self) -> str:
        """The picture that notebooks show: spacings, accelerations and speeds over time."""
        panels = {"spacing [m]": self.s, "acceleration [m/s²]": self.a, "speed [m/s]": self.v}
        return figure(picture(self.time, panels), [self._title(), *warned(self.warnings)])
