"""The repulsive potential between two vehicles, and its slope."""

from __future__ import annotations

from typing import Any

from ..namespaces import array_namespace
from ..parameters import HILL_WIDTH, Constants, PotentialShape


def _hill_parts(s: Any, shape: PotentialShape) -> tuple[Any, Any, Any, Any]:
    """Depth t = s - r into the hill, q = (3 - t) t, q^(p-1), and whether s is on the hill.

    Off the hill the base of the power is replaced by 1, so that no library meets 0^x or a negative base, not even in
    a derivative.
    """
    xp = array_namespace(s)
    t = s - shape.r
    q = (HILL_WIDTH - t) * t  # positive on the hill and nowhere else
    on_hill = q > 0.0
    q = xp.where(on_hill, q, 1.0)
    return t, q, q ** (shape.p - 1.0), on_hill


def on_hill(s: Any, shape: PotentialShape) -> Any:
    """Whether s lies on the hill, r < s < r + 3 m; off the hill the potential needs no power (ours).

    Parameters
    ----------
    s : (n-1, ...) array, gaps [m]

    Returns
    -------
    (n-1, ...) array of booleans
    """
    return _hill_parts(s, shape)[3]


def potential(s: Any, shape: PotentialShape, constants: Constants) -> Any:
    """V(s) = alpha (lambda - s)^3 / (s - L) + ((r + 3 - s)(s - r))^p / (s - L)^2.

    The first term holds for s < lambda, the second on the hill, r <= s < r + 3 (paper, eq. of V_new; its last case is
    a slip and means s >= lambda).

    Parameters
    ----------
    s : (n-1, ...) array, gaps [m], all above L
    shape : alpha, r, p and hill, each a number or an array that broadcasts with s
    constants : L and lam

    Returns
    -------
    (n-1, ...) array, potential [m2/s2]
    """
    xp = array_namespace(s)
    d = s - constants.L
    e = xp.maximum(constants.lam - s, 0.0)
    _, q, power, on_hill = _hill_parts(s, shape)
    return shape.alpha * e * e * e / d + xp.where(on_hill, shape.hill * power * q / (d * d), 0.0)


def potential_slope(s: Any, shape: PotentialShape, constants: Constants) -> Any:
    """V'(s) (paper, used in eq. 2; written out in the theory page).

    base' = -alpha [3 (lambda - s)^2 / (s - L) + (lambda - s)^3 / (s - L)^2]
    hill' = q^(p-1) [p (2r + 3 - 2s) - 2 q / (s - L)] / (s - L)^2,  q = (r + 3 - s)(s - r)

    Parameters
    ----------
    s : (n-1, ...) array, gaps [m], all above L
    shape : alpha, r, p and hill, each a number or an array that broadcasts with s
    constants : L and lam

    Returns
    -------
    (n-1, ...) array, slope of the potential [m/s2]
    """
    xp = array_namespace(s)
    d = s - constants.L
    e = xp.maximum(constants.lam - s, 0.0)
    t, q, power, on_hill = _hill_parts(s, shape)
    near = e / d
    hill = power * (shape.p * (0.5 * HILL_WIDTH - t) - q / d) / (d * d)
    return xp.where(on_hill, 2.0 * shape.hill * hill, 0.0) - shape.alpha * (e * near * (3.0 + near))
