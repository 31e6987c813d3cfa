"""A local solver on the same objective: CasADi and IPOPT by single shooting, to compare with (ours)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..law.controller import PaperLaw
from ..law.potential import PotentialParameters, potential_slope
from ..parameters import ALPHA_MAX, ALPHA_MIN, HILL_WIDTH, P_MAX, P_MIN, generic
from ..sampling.hold import IDEAL
from ..sampling.period import decide, hold
from ..selection.search.engine import Problem

Array = NDArray[Any]

GUESSES = ((1e-3, 9.0, 4.0), (1e-3, 11.0, 5.5), (1e-3, 13.0, 6.0))
_POINTS = 31  # of the hill at which the slope is constrained


class LocalSolver:
    """IPOPT for one problem, with exact first derivatives through the whole run.

    Attributes
    ----------
    problem : what is solved
    """

    def __init__(self, problem: Problem):
        self.problem = problem

    @cached_property
    def _solver(self) -> Any:
        import casadi

        n, T, constants = self.problem.vehicles, self.problem.T, self.problem.constants
        state, triple = casadi.SX.sym("state", 2 * n - 1), casadi.SX.sym("triple", 3)
        shape = generic(PotentialParameters, alpha=triple[0], r=triple[1], p=triple[2])
        begin: tuple[Any, Any, Any] = casadi.SX(0.0), state[: n - 1], state[n - 1 :]
        vehicles = IDEAL.begin(*begin)
        _, a, _ = decide(PaperLaw(shape, constants), None, vehicles)
        after, added = hold(IDEAL, vehicles, a, T, self.problem.weights)
        step = casadi.Function("step", [state, triple], [casadi.vertcat(after.s, after.v), sum(added)])
        x, start = casadi.MX.sym("x", 3), casadi.MX.sym("start", 2 * n - 1)
        periods = round(self.problem.horizon / T)
        _, costs = step.mapaccum("run", periods)(start, casadi.repmat(x, 1, periods))
        places: Any = casadi.SX(triple[1] + np.linspace(0.0, HILL_WIDTH, _POINTS))
        slopes = casadi.Function("slopes", [triple], [potential_slope(places, shape, constants)])
        nlp: dict[str, Any] = {"x": x, "p": start, "f": casadi.sum2(costs), "g": slopes(x)}
        options: dict[str, Any] = {"ipopt.hessian_approximation": "limited-memory", "ipopt.max_iter": 60}
        options["ipopt.print_level"] = 0
        return casadi.nlpsol("solver", "ipopt", nlp, options | {"print_time": False, "ipopt.sb": "yes"})

    def solve(self, start: Array, guesses: Sequence[Sequence[float]] = GUESSES) -> tuple[Array, float]:
        """The best end of IPOPT's runs from some guesses.

        Parameters
        ----------
        start : (2n-1,) spacings [m], then speeds [m/s]
        guesses : triples to begin at

        Returns
        -------
        triple : (3,) alpha, r, p; the slope limit holds at the constrained points
        J : there
        """
        constants = self.problem.constants
        low = [ALPHA_MIN, constants.L + 0.1, P_MIN]
        high = [ALPHA_MAX, constants.lam - HILL_WIDTH, P_MAX]
        best, J = np.array(guesses[0]), np.inf
        for guess in guesses:
            found = self._solver(x0=guess, p=start, lbx=low, ubx=high, lbg=-constants.z, ubg=constants.z)
            violated = max(0.0, float(np.abs(np.array(found["g"])).max()) - constants.z)
            if float(found["f"]) < J and violated < 1e-4:
                best, J = np.array(found["x"]).ravel(), float(found["f"])
        return best, J
