"""How do I drive the platoon with a potential of my own?"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from psp_model import BEST_FIXED, PlatoonParameters, PlatoonState, Run, rollout_costs, simulate


class Quadratic(NamedTuple):
    """V(s) = k (d - s)^2 / (s - L) below the spacing d, else 0; see `psp_model.Potential`.

    k : strength [m/s2]; d : reach [m].  Numbers, or arrays with one entry for each platoon of a batch.
    """

    k: Any
    d: Any

    def value(self, s: Any, constants: PlatoonParameters) -> Any:
        """V(s) [m2/s2]."""
        e = np.maximum(self.d - s, 0.0)
        return self.k * e * e / (s - constants.L)

    def slope(self, s: Any, constants: PlatoonParameters) -> Any:
        """V'(s) [m/s2]."""
        near = np.maximum(self.d - s, 0.0) / (s - constants.L)
        return -self.k * near * (2.0 + near)


def main() -> dict[str, Run]:
    """Roll out nine reaches, run the best, and compare it with the paper's potential."""
    start = PlatoonState([9.0, 10.5, 11.0], [30.0, 31.0, 29.0, 30.5])
    candidates = [Quadratic(0.05, d) for d in np.linspace(8.0, 16.0, 9).tolist()]
    J, certified = rollout_costs(start, candidates)
    best = candidates[int(np.argmin(np.where(certified, J, np.inf)))]
    runs = {f"quadratic, d = {best.d:g} m": simulate(start, best), "V_new": simulate(start, BEST_FIXED)}
    for name, run in runs.items():
        print(f"{name}: smallest spacing {run.s.min():.2f} m, J = {run.J:.2f}")
    return runs


if __name__ == "__main__":
    main()
