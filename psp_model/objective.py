"""The objective J that the parameters of the potential are chosen for."""

from __future__ import annotations

from typing import Any

from .namespace import total
from .parameters import ObjectiveWeights

HORIZON = 20.0  # [s] t_f - t_0 (ours: the paper gives none)


def running_cost(s: Any, v: Any, a: Any, tau: Any, weights: ObjectiveWeights) -> tuple[Any, Any]:
    """What a time tau after a sampling instant adds to the two terms of J, exactly (paper, eq. of the objective).

    w1 tau sum a^2 / a_ref^2 and w2 sum (tau s + tau^2/2 Dv + tau^3/6 Da) / s_ref: the accelerations are held and the
    gaps are parabolas, so both integrals are closed forms; sum Dv = v_1 - v_n and sum Da = a_1 - a_n.

    Parameters
    ----------
    s : (n-1, ...) array, gaps at the sampling instant [m]
    v : (n, ...) array, speeds at the sampling instant [m/s]
    a : (n, ...) array, accelerations held since [m/s2]
    tau : time since the sampling instant [s]

    Returns
    -------
    of_acceleration, of_gaps : (...) arrays [s], weights included
    """
    gaps = tau * (total(s) + tau * (0.5 * (v[0] - v[-1]) + tau / 6.0 * (a[0] - a[-1])))
    return weights.w1 / weights.a_ref**2 * tau * total(a * a), weights.w2 / weights.s_ref * gaps
