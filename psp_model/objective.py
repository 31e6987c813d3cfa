"""The objective J that the parameters of the potential are chosen for."""

from __future__ import annotations

from .namespaces import Array, Number, total
from .parameters import ObjectiveWeights

HORIZON = 20.0  # [s] t_f - t_0 (ours: the paper gives none)


def running_cost(s: Array, v: Array, a: Array, tau: Number, weights: ObjectiveWeights) -> tuple[Array, Array]:
    """What a time tau after a sampling instant adds to the two terms of J, exactly (paper, eq. of the objective).

    w1 tau sum a^2 / a_ref^2 and w2 sum (tau s + tau^2/2 Dv + tau^3/6 Da) / s_ref: the accelerations are held and the
    spacings are parabolas, so both integrals are closed forms; sum Dv = v_1 - v_n and sum Da = a_1 - a_n.

    Parameters
    ----------
    s : (n-1, ...) array, spacings at the sampling instant [m]
    v : (n, ...) array, speeds at the sampling instant [m/s]
    a : (n, ...) array, accelerations held since [m/s2]
    tau : time since the sampling instant [s]

    Returns
    -------
    of_acceleration, of_spacings : (...) arrays [s], weights included
    """
    ends = v[0] - v[-1], a[0] - a[-1]
    return acceleration_cost(total(a * a), tau, weights), spacing_cost(total(s), *ends, tau, weights)


def acceleration_cost(squares: Array, tau: Number, weights: ObjectiveWeights) -> Array:
    """w1 tau sum a^2 / a_ref^2 (paper, first term of the objective).

    Parameters
    ----------
    squares : (...) array, sum over the vehicles of the squared accelerations held [m2/s4]
    tau : how long they are held [s]
    weights : w1 and a_ref, numbers or symbols

    Returns
    -------
    (...) array [s]
    """
    return weights.w1 * tau * squares / weights.a_ref / weights.a_ref  # a_ref^2 might overflow or vanish


def spacing_cost(spacings: Array, dv: Array, da: Array, tau: Number, weights: ObjectiveWeights) -> Array:
    """w2 (tau sum s + tau^2/2 dv + tau^3/6 da) / s_ref (paper, second term of the objective).

    Parameters
    ----------
    spacings : (...) array, sum of the spacings at the sampling instant [m]
    dv, da : (...) arrays, v_1 - v_n [m/s] and a_1 - a_n [m/s2] at the sampling instant
    tau : time since the sampling instant [s]
    weights : w2 and s_ref, numbers or symbols

    Returns
    -------
    (...) array [s]
    """
    return weights.w2 / weights.s_ref * (tau * (spacings + tau * (0.5 * dv + tau / 6.0 * da)))
