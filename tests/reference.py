"""The platoon once more, in plain scalar Python straight from the paper's equations: the oracle of the tests.

Nothing here comes from `psp_model`, and the forms differ on purpose: f, g and k_i as the paper prints them, one vehicle
at a time, positions integrated and spacings taken from positions.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import Any, NamedTuple, cast


class Constants(NamedTuple):
    """The paper's constants (section V), and the scales and weights of the objective."""

    L: float = 5.0
    lam: float = 20.0
    v_star: float = 30.0
    v_max: float = 35.0
    epsilon: float = 0.2
    mu: float = 0.5
    w1: float = 0.5
    w2: float = 0.5
    a_ref: float = 4.0
    s_ref: float = 20.0


class ReferenceRun(NamedTuple):
    """One list item per sampling instant k = 0..K; x, v, a hold n numbers each, s holds n - 1."""

    time: list[float]
    x: list[list[float]]
    s: list[list[float]]
    v: list[list[float]]
    a: list[list[float]]
    T_max: list[float]
    J_acceleration: list[float]
    J_gap: list[float]

    @property
    def J(self) -> float:
        """The objective over the whole run."""
        return self.J_acceleration[-1] + self.J_gap[-1]


def V(s: float, alpha: float, r: float, p: float, hill: bool, c: Constants) -> float:
    """V_new(s), or V_old(s) where hill is False and alpha is 1 (design, section 1)."""
    value = alpha * (c.lam - s) ** 3 / (s - c.L) if s < c.lam else 0.0
    if hill and r <= s < r + 3:
        value += (r + 3 - s) ** p * (s - r) ** p / (c.L - s) ** 2
    return value


def V_slope(s: float, alpha: float, r: float, p: float, hill: bool, c: Constants) -> float:
    """V'(s), with the hill's slope as hill(s) times its logarithmic derivative (design, section 1)."""
    slope = 0.0
    if s < c.lam:
        slope -= alpha * (3 * (c.lam - s) ** 2 / (s - c.L) + (c.lam - s) ** 3 / (s - c.L) ** 2)
    if hill and r < s < r + 3:
        q = (r + 3 - s) * (s - r)
        slope += q**p / (s - c.L) ** 2 * (p * (2 * r + 3 - 2 * s) / q - 2 / (s - c.L))
    return slope


def f(x: float, c: Constants) -> float:
    """The smoothed positive part, the paper's three cases."""
    if x <= -c.epsilon:
        return 0.0
    if x < 0:
        return (x + c.epsilon) ** 2 / (2 * c.epsilon)
    return (c.epsilon**2 + 2 * c.epsilon * x) / (2 * c.epsilon)


def g(x: float, c: Constants) -> float:
    """The paper's eq. of g."""
    return c.v_max * f(x, c) / (c.v_star * (c.v_max - c.v_star)) - x / c.v_star


def forces(slopes: Sequence[float]) -> list[float]:
    """What the potential adds to each vehicle's acceleration: the V' terms of the paper's eq. 2, leader first."""
    middle = [slopes[i - 1] - slopes[i] for i in range(1, len(slopes))]
    return [-slopes[0], *middle, slopes[-1]]


def accelerations(
    s: Sequence[float], v: Sequence[float], alpha: float, r: float, p: float, hill: bool, c: Constants
) -> list[float]:
    """F_i = -k_i (v_i - v*) + u_i with k_i = mu + g(u_i) (paper, eqs. 2 and 3)."""
    u = forces([V_slope(spacing, alpha, r, p, hill, c) for spacing in s])
    return [-(c.mu + g(u_i, c)) * (v_i - c.v_star) + u_i for u_i, v_i in zip(u, v, strict=True)]


def largest_period(s: Sequence[float], v: Sequence[float], a: Sequence[float], c: Constants) -> float:
    """Lemma 1's T_max over all vehicles (design, section 1)."""
    bounds = [(spacing - c.L) / c.v_max for spacing in s]
    for v_i, a_i in zip(v, a, strict=True):
        bounds.append((c.v_max - v_i) / a_i if a_i > 0 else v_i / -a_i if a_i < 0 else inf)
    return min(bounds)


def reference_run(
    s0: Sequence[float],
    v0: Sequence[float],
    x0: float = 0.0,
    *,
    alpha: float,
    r: float,
    p: float,
    hill: bool = True,
    T: float = 0.01,
    duration: float = 20.0,
    constants: Constants | None = None,
) -> ReferenceRun:
    """Run the platoon with the feedback computed and held every T, whether Lemma 1 certifies T or not.

    Parameters
    ----------
    s0, v0, x0 : initial spacings s_2..s_n [m], speeds v_1..v_n [m/s] and position of vehicle 1 [m]
    alpha, r, p : of the potential; V_old is alpha = 1 with hill False
    T, duration : sampling period and length of the run [s]
    """
    c = constants or Constants()
    v = [float(v_i) for v_i in v0]
    x = [float(x0)]
    for spacing in s0:
        x.append(x[-1] - float(spacing))
    n, run = len(v), ReferenceRun([], [], [], [], [], [], [], [])
    columns = cast("tuple[list[Any], ...]", run)
    J_acceleration = J_gap = 0.0
    steps = round(duration / T)
    for k in range(steps + 1):
        s = [x[i - 1] - x[i] for i in range(1, n)]
        a = accelerations(s, v, alpha, r, p, hill, c)
        T_max = largest_period(s, v, a, c)
        row = (k * T, x, s, v, a, T_max, J_acceleration, J_gap)
        for column, value in zip(columns, row, strict=True):
            column.append(value)
        for i in range(n):
            J_acceleration += c.w1 * T * (a[i] / c.a_ref) ** 2
            if i > 0:
                area = T * s[i - 1] + T**2 / 2 * (v[i - 1] - v[i]) + T**3 / 6 * (a[i - 1] - a[i])
                J_gap += c.w2 * area / c.s_ref
        x = [x[i] + T * v[i] + T**2 / 2 * a[i] for i in range(n)]
        v = [v[i] + T * a[i] for i in range(n)]
    return run
