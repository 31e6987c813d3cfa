"""How do I drive vehicles of my own, say with a lag, by the paper's law?"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from psp_model import BEST_FIXED, PlatoonState, PotentialParameters, Run, rollout_costs, simulate


class Lagging(NamedTuple):
    """State of vehicles whose acceleration a follows its command: position of the leader, spacings, speeds, a."""

    x: Any
    s: Any
    v: Any
    a: Any


class FirstOrderLag(NamedTuple):
    """lag a' = u - a, solved exactly for a command u that is held; see `psp_model.Plant`."""

    lag: float  # [s]

    def begin(self, x: Any, s: Any, v: Any) -> Lagging:
        """Vehicles that do not accelerate yet."""
        return Lagging(x, s, v, np.zeros_like(v))

    def advance(self, vehicles: Lagging, a: Any, tau: Any) -> tuple[Lagging, Any]:
        """The state a time tau later, and the mean acceleration until then."""
        x, s, v, a_now = vehicles
        decay = -np.expm1(-tau / self.lag)  # 1 - exp(-tau / lag)
        v_then = v + tau * a + (a_now - a) * self.lag * decay
        moved = tau * v + 0.5 * tau * tau * a + (a_now - a) * self.lag * (tau - self.lag * decay)
        after = Lagging(x + moved[0], s + moved[:-1] - moved[1:], v_then, a_now + (a - a_now) * decay)
        return after, (v_then - v) / tau


def main() -> dict[str, Run]:
    """The same start without a lag and with one; then which of two potentials is better with it."""
    start = PlatoonState([9.0, 10.5, 11.0], [30.0, 31.0, 29.0, 30.5])
    runs = {f"lag {lag} s": simulate(start, BEST_FIXED, plant=FirstOrderLag(lag)) for lag in (0.1, 0.3)}
    runs = {"no lag": simulate(start, BEST_FIXED)} | runs
    for name, run in runs.items():
        print(f"{name}: smallest spacing {run.s.min():.2f} m, J = {run.J:.2f}")
    pair = [BEST_FIXED, PotentialParameters(alpha=1e-3, r=9.0, p=5.0)]
    J, _ = rollout_costs(start, pair, plant=FirstOrderLag(0.3))
    print(f"with a lag of 0.3 s: J = {J[0]:.2f} with r = 11 m, {J[1]:.2f} with r = 9 m")
    return runs


if __name__ == "__main__":
    main()
