"""Zero-order hold, exactly: what a constant acceleration does to spacings and speeds (paper, eq. 10)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol, TypeVar

import numpy as np

from ..namespaces import Array, Number


class Moving(Protocol):
    """The state of vehicles on one lane, as far as the loop looks at it."""

    @property
    def x(self) -> Number:
        """Position of the leader, a number or (...) array [m]."""

    @property
    def s(self) -> Array:
        """Spacings, (n-1, ...) array [m]."""

    @property
    def v(self) -> Array:
        """Speeds, (n, ...) array [m/s]."""


Vehicles = TypeVar("Vehicles", bound=Moving)


class Plant(Protocol[Vehicles]):
    """The controlled vehicles: they take commanded accelerations; the state is a struct of the plant's own.

    Both functions are pure, and generic over the array namespace, so that the same plant serves a run, a batch of
    rollouts and CasADi (ours).
    """

    def begin(self, x: Number, s: Array, v: Array) -> Vehicles:
        """The state in which the vehicles stand at these spacings and speeds, as if uncontrolled so far.

        Parameters
        ----------
        x : position of the leader [m]
        s, v : (n-1, ...) spacings [m] and (n, ...) speeds [m/s]
        """

    def advance(self, vehicles: Vehicles, a: Array, tau: float) -> tuple[Vehicles, Array]:
        """The state a time tau later.

        Parameters
        ----------
        vehicles : state now
        a : (n, ...) array, accelerations commanded and held from now on [m/s2]
        tau : time [s]

        Returns
        -------
        the state, and the (n, ...) mean accelerations of the vehicles over that time [m/s2], which J counts
        """


class Motion(NamedTuple):
    """Where vehicles without any inner state are.

    States are named tuples rather than frozen dataclasses: made in a third of the time, and JAX takes them as they are.

    Attributes
    ----------
    x : position of the leader [m]
    s, v : (n-1, ...) spacings [m] and (n, ...) speeds [m/s]
    """

    x: Number
    s: Array
    v: Array

    def positions(self) -> Array:
        """Positions of all vehicles of one platoon, (n,) NumPy array [m]."""
        return np.subtract.accumulate(np.concatenate([[self.x], self.s]))


@dataclass(frozen=True)
class DoubleIntegrators:
    """The paper's vehicles, which follow commands at once; exact under zero-order hold (paper, eq. 10)."""

    def begin(self, x: Number, s: Array, v: Array) -> Motion:
        """See `Plant.begin`."""
        return Motion(x, s, v)

    def advance(self, vehicles: Motion, a: Array, tau: float) -> tuple[Motion, Array]:
        """See `Plant.advance`."""
        moved = travelled(vehicles.v, a, tau)
        return Motion(vehicles.x + moved[0], spacings_after(vehicles.s, moved), vehicles.v + tau * a), a


IDEAL = DoubleIntegrators()


def relative(y: Array) -> Array:
    """y_{i-1} - y_i, as the spacings are defined (paper, section II).

    Parameters
    ----------
    y : (n, ...) array, one value for each vehicle, leader first

    Returns
    -------
    (n-1, ...) array, one value for each spacing
    """
    return y[:-1] - y[1:]


def advance(s: Array, v: Array, a: Array, tau: Number) -> tuple[Array, Array]:
    """Spacings and speeds a time tau after a sampling instant, exactly.

    s(tau) = s + D(tau v + tau^2/2 a) and v(tau) = v + tau a, with D the difference between vehicle i-1 and vehicle i.
    Spacings are integrated rather than positions, so that they keep their precision over any distance (ours).

    Parameters
    ----------
    s : (n-1, ...) array, spacings [m]
    v : (n, ...) array, speeds [m/s]
    a : (n, ...) array, accelerations held since the sampling instant [m/s2]
    tau : time since the sampling instant [s]

    Returns
    -------
    s, v : arrays of the same shapes, a time tau later [m], [m/s]
    """
    return spacings_after(s, travelled(v, a, tau)), v + tau * a


def spacings_after(s: Array, moved: Array) -> Array:
    """Spacings once every vehicle has travelled some distance (paper, eq. 10).

    Parameters
    ----------
    s : (n-1, ...) array, spacings before [m]
    moved : (n, ...) array, distance travelled since [m], from `travelled`

    Returns
    -------
    (n-1, ...) array, spacings after [m]
    """
    return s + relative(moved)


def travelled(v: Array, a: Array, tau: Number) -> Array:
    """Distance tau v + tau^2/2 a that each vehicle covers (paper, eq. 10).

    Parameters
    ----------
    v : (n, ...) array, speeds at the sampling instant [m/s]
    a : (n, ...) array, accelerations held since [m/s2]
    tau : time since the sampling instant [s]

    Returns
    -------
    (n, ...) array [m]
    """
    return tau * (v + 0.5 * tau * a)
