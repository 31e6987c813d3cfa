"""The repulsive potential between two vehicles, and its slope."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, Protocol, TypeVar, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ..namespaces import Array, array_namespace
from ..parameters import HILL_WIDTH, PlatoonParameters


@runtime_checkable
class Potential(Protocol):
    """What the law needs of a potential; `PotentialParameters` is the paper's family (ours).

    A dataclass or named tuple whose fields are its parameters does: the fields may be numbers, arrays or symbols that
    broadcast with the spacings, so that one object stands for a whole batch of potentials in rollouts.
    """

    def value(self, s: Array, constants: PlatoonParameters) -> Array:
        """V(s).

        Parameters
        ----------
        s : (n-1, ...) array, spacings [m], all above L
        constants : of the model

        Returns
        -------
        (n-1, ...) array [m2/s2]
        """

    def slope(self, s: Array, constants: PlatoonParameters) -> Array:
        """V'(s); below 0 it pushes the two vehicles apart.

        Parameters
        ----------
        s : (n-1, ...) array, spacings [m], all above L
        constants : of the model

        Returns
        -------
        (n-1, ...) array [m/s2]
        """


@dataclass(frozen=True)
class PotentialParameters:
    """One potential out of the family V_new (paper, eq. of V_new); V_old is the member without a hill.

    Each field is a number, or an array or symbol that broadcasts with the spacings.  Whether a triple lies in the
    feasible set depends on the constants and is the business of `selection.feasible.require_feasible`.

    Attributes
    ----------
    alpha : scale of the repulsion [1]
    r : where the hill begins; it ends at r + 3 m [m]
    p : exponent of the hill [1]
    hill : 1 with the hill (V_new), 0 without (V_old) [1]
    """

    alpha: float
    r: float
    p: float
    hill: float = 1.0

    def __str__(self) -> str:
        numbers = self.alpha, self.r, self.p, self.hill
        if not all(isinstance(one, int | float) for one in numbers):
            return repr(self)
        if self.hill == 0.0:
            return "V_old" if self == V_OLD else f"alpha = {self.alpha:.4g}, no hill"
        return f"V_new, alpha = {self.alpha:.4g}, r = {self.r:.4g} m, p = {self.p:.4g}"

    def value(self, s: Array, constants: PlatoonParameters) -> Array:
        """V(s), see `potential`."""
        return potential(s, self, constants)

    def slope(self, s: Array, constants: PlatoonParameters) -> Array:
        """V'(s), see `potential_slope`."""
        return potential_slope(s, self, constants)


V_OLD = PotentialParameters(alpha=1.0, r=0.0, p=0.0, hill=0.0)
"""The paper's V_old: alpha = 1 and no hill, so r and p mean nothing and are 0."""

BEST_FIXED = PotentialParameters(alpha=1e-3, r=11.0, p=5.5)
"""The fixed triple that serves 7 vehicles best on average (ours, measured); the fallback of the network."""

Shape = TypeVar("Shape", bound=Potential)


def stacked(potentials: Sequence[Shape]) -> Shape:
    """K potentials of one family as one whose parameters are (K,) arrays, for batches along the last axis (ours).

    Parameters
    ----------
    potentials : all of one class, a dataclass or named tuple of numbers

    Returns
    -------
    an object of that class
    """
    family: Any = type(potentials[0])
    names = family._fields if hasattr(family, "_fields") else [field.name for field in fields(family)]
    found: Shape = family(**{name: np.array([getattr(one, name) for one in potentials]) for name in names})
    return found


def _hill_parts(s: Array, shape: PotentialParameters) -> tuple[Array, Array, Array, NDArray[np.bool_]]:
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


def on_hill(s: Array, shape: PotentialParameters) -> NDArray[np.bool_]:
    """Whether s lies on the hill, r < s < r + 3 m; off the hill the potential needs no power (ours).

    Parameters
    ----------
    s : (n-1, ...) array, spacings [m]

    Returns
    -------
    (n-1, ...) array of booleans
    """
    return _hill_parts(s, shape)[3]


def potential(s: Array, shape: PotentialParameters, constants: PlatoonParameters) -> Array:
    """V(s) = alpha (lambda - s)^3 / (s - L) + ((r + 3 - s)(s - r))^p / (s - L)^2.

    The first term holds for s < lambda, the second on the hill, r <= s < r + 3 (paper, eq. of V_new; erratum: its last
    case should read s >= lambda).

    Parameters
    ----------
    s : (n-1, ...) array, spacings [m], all above L
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


def potential_slope(s: Array, shape: PotentialParameters, constants: PlatoonParameters) -> Array:
    """V'(s) (paper, used in eq. 2; written out in the theory page).

    base' = -alpha [3 (lambda - s)^2 / (s - L) + (lambda - s)^3 / (s - L)^2]
    hill' = q^(p-1) [p (2r + 3 - 2s) - 2 q / (s - L)] / (s - L)^2,  q = (r + 3 - s)(s - r)

    Parameters
    ----------
    s : (n-1, ...) array, spacings [m], all above L
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
