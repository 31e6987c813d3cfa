"""The feasible set of (alpha, r, p), and the way into it."""

from __future__ import annotations

from dataclasses import replace
from math import inf, nextafter

import numpy as np

from ..errors import ModelError
from ..law.potential import PotentialParameters, potential_slope
from ..namespaces import Array, array_namespace
from ..parameters import ALPHA_MAX, ALPHA_MIN, HILL_WIDTH, P_MAX, P_MIN, PlatoonParameters

SLOPE_ERROR = 1e-9  # [m/s2] `max_slope` is this close to the true maximum, or closer
_FIRST_CELLS = 64  # cells that the hill is first cut into
_CHILDREN = 8  # cells that each undecided cell is cut into
_MOST_CELLS = 1 << 16  # undecided cells at a time: more only where the bound overflows
_P_ERROR = 2.0**-40  # [1] how close the projection comes to the slope limit, in p; in r [m] likewise
_ALPHA_ERROR = 1e-9  # [1] how close the flattest hill is found, in alpha
_PROBES = 33  # starting points of the projection's search in r


def cell_bound(a: Array, b: Array, shape: PotentialParameters, constants: PlatoonParameters) -> tuple[Array, Array]:
    """Lower and upper bound of max |V'| over the cell [a, b] of the hill (ours).

    The lower bound is |V'| at the better end.  Between its ends a function leaves the chord by at most
    (b - a)^2/8 times its largest second derivative, so the upper bound adds that with a bound on |V'''| from the
    largest values that each factor takes on the cell.

    Parameters
    ----------
    a, b : arrays of the same shape, ends of the cells [m], r <= a < b <= r + 3
    shape : with p >= 3

    Returns
    -------
    lower, upper : arrays like a [m/s2]
    """
    xp = array_namespace(a)
    p, mid = shape.p, shape.r + 0.5 * HILL_WIDTH
    d, e = a - constants.L, constants.lam - a
    # |V'''| of the base: V = alpha e^3 / d, with every term of its third derivative positive
    base = shape.alpha * (6.0 / d + 18.0 * e / d**2 + 18.0 * e * e / d**3 + 6.0 * e**3 / d**4)
    # The hill is q^p / d^2; V''' d^2 = h3 - 6 h2/d + 18 h1/d^2 - 24 q^p/d^3, with h1..h3 the derivatives of q^p.  The
    # bounds below give q the sign opposite to its own in h2 and h3.  What that adds is more than the last two terms
    # can, as p >= 3 and q <= d^2 + max(q', 0) d, so that these need no bounds of their own (proof: docs/theory.md).
    # q is largest, and |q'| smallest, where the cell is closest to the middle.
    inner = xp.maximum(xp.maximum(a - mid, mid - b), 0.0)
    outer = xp.maximum(xp.abs(a - mid), xp.abs(b - mid))
    q, q1 = 0.25 * HILL_WIDTH**2 - inner * inner, 2.0 * outer
    q_p3 = q ** (p - 3.0)
    h2 = p * q_p3 * q * ((p - 1.0) * q1 * q1 + 2.0 * q)
    h3 = p * (p - 1.0) * q_p3 * q1 * ((p - 2.0) * q1 * q1 + 6.0 * q)
    hill = (h3 + 6.0 * h2 / d) / d**2
    lower = xp.maximum(xp.abs(potential_slope(a, shape, constants)), xp.abs(potential_slope(b, shape, constants)))
    return lower, lower + (b - a) ** 2 / 8.0 * (base + shape.hill * hill)


def max_slope(shape: PotentialParameters, constants: PlatoonParameters, enough: float = np.inf) -> float:
    """max |V_new'| on [r, r + 3] (paper, feasible set), never above the true maximum and at most SLOPE_ERROR below it.

    Branch and bound on `cell_bound`: cells that may still hide a larger value are cut until none may (ours).  Slopes
    above 1000 m/s2 are exact to 1e-12 of their size only.  Where the bound overflows, as for lambda = 1e110 m, no cell
    is ever decided, and the slope counts as infinite.

    Parameters
    ----------
    shape : one triple, r above L
    enough : stop at the first slope found above this [m/s2], when only a comparison is wanted

    Returns
    -------
    the maximum, or some slope above `enough` [m/s2]
    """
    ends = shape.r + np.linspace(0.0, HILL_WIDTH, _FIRST_CELLS + 1)
    a, b = ends[:-1], ends[1:]
    best = 0.0
    while True:
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):  # r at L: the slope is infinite
            lower, upper = cell_bound(a, b, shape, constants)
        best = max(best, float(lower.max()))
        undecided = (upper > best + max(SLOPE_ERROR, 1e-12 * best)) & (b > np.nextafter(a, np.inf))
        if best > enough or not undecided.any():
            return best
        if undecided.sum() > _MOST_CELLS:
            return inf
        cuts = np.linspace(a[undecided], b[undecided], _CHILDREN + 1)
        a, b = cuts[:-1].ravel(), cuts[1:].ravel()


def slope_within_limit(shape: PotentialParameters, constants: PlatoonParameters) -> bool:
    """Whether max |V_new'| <= z on the hill, to within SLOPE_ERROR (paper, feasible set).

    Parameters
    ----------
    shape : one triple

    Returns
    -------
    True or False
    """
    return max_slope(shape, constants, enough=constants.z) <= constants.z


def require_feasible(shape: PotentialParameters, constants: PlatoonParameters) -> None:
    """Check a triple against the feasible set (paper, constraints of the objective).

    Parameters
    ----------
    shape : one triple

    Raises
    ------
    ModelError : naming the violated bound
    """
    if not ALPHA_MIN <= shape.alpha <= ALPHA_MAX:
        raise ModelError("alpha", shape.alpha, ALPHA_MIN, ALPHA_MAX)
    if not constants.L < shape.r <= constants.lam - HILL_WIDTH:
        raise ModelError("r", shape.r, constants.L, constants.lam - HILL_WIDTH)
    if not P_MIN <= shape.p <= P_MAX:
        raise ModelError("p", shape.p, P_MIN, P_MAX)
    slope = max_slope(shape, constants)
    if not slope <= constants.z:
        raise ModelError("slope", slope, shape.alpha, shape.r, shape.p, constants.z)


def project(shape: PotentialParameters, constants: PlatoonParameters) -> PotentialParameters:
    """The feasible triple that a triple stands for: into the bounds first, then under the slope limit (ours).

    A feasible triple is returned unchanged.  Otherwise p is lowered as far as needed; where even p = 3 is too steep,
    r is raised as far as needed at p = 3; where even that fails, alpha falls to its lower bound and r is raised again.
    What is left then is the flattest hill of all: p = 3, r at its upper bound, and the alpha that balances the hill's
    two sides there.

    Parameters
    ----------
    shape : one finite triple

    Returns
    -------
    a triple that `require_feasible` accepts

    Raises
    ------
    ModelError : where no triple is feasible for these constants
    """
    r_min, r_max = nextafter(constants.L, inf), constants.lam - HILL_WIDTH
    shape = PotentialParameters(
        min(max(shape.alpha, ALPHA_MIN), ALPHA_MAX), min(max(shape.r, r_min), r_max), min(max(shape.p, P_MIN), P_MAX)
    )
    if slope_within_limit(shape, constants):
        return shape
    lowest = replace(shape, p=P_MIN)
    if slope_within_limit(lowest, constants):
        return replace(shape, p=_last_feasible(shape, "p", P_MIN, shape.p, constants))
    for alpha in (shape.alpha, ALPHA_MIN):
        flat = replace(lowest, alpha=alpha)
        for r in np.linspace(shape.r, r_max, _PROBES)[1:].tolist():
            if slope_within_limit(replace(flat, r=r), constants):
                return replace(flat, r=_last_feasible(flat, "r", r, shape.r, constants))
    flattest = _flattest(replace(lowest, r=r_max), constants)
    if slope_within_limit(flattest, constants):
        return flattest
    raise ModelError("empty", constants.z)


def _flattest(shape: PotentialParameters, constants: PlatoonParameters) -> PotentialParameters:
    """`shape` with the alpha of least max |V'|, which is convex in alpha as V' is linear in it: thirds are cut off."""
    low, high = ALPHA_MIN, ALPHA_MAX
    while high - low > _ALPHA_ERROR:
        third = (high - low) / 3.0
        one, other = replace(shape, alpha=low + third), replace(shape, alpha=high - third)
        if max_slope(one, constants) < max_slope(other, constants):
            high = other.alpha
        else:
            low = one.alpha
    return replace(shape, alpha=0.5 * (low + high))


def _last_feasible(
    shape: PotentialParameters, name: str, inside: float, outside: float, constants: PlatoonParameters
) -> float:
    """Bisect the field `name` of `shape` from a feasible towards an infeasible value; the feasible end is returned."""
    while abs(outside - inside) > _P_ERROR:
        middle = 0.5 * (inside + outside)
        if slope_within_limit(replace(shape, **{name: middle}), constants):
            inside = middle
        else:
            outside = middle
    return inside
