"""The initial state of a platoon, and the domain that starts are drawn from."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
from numpy import ndarray
from numpy.typing import ArrayLike, NDArray

from .errors import ModelError
from .parameters import PlatoonParameters


def read_only(values: ArrayLike) -> NDArray[np.float64]:
    """A read-only float64 copy of numbers (ours).

    Parameters
    ----------
    values : numbers, a list or an array

    Raises
    ------
    ValueError : where they do not make an array
    """
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array


def seal(*arrays: object) -> None:
    """Make NumPy arrays read-only before they are handed out; arrays of other libraries are so in any case (ours).

    Parameters
    ----------
    arrays : of any shape
    """
    for array in arrays:
        if isinstance(array, ndarray):
            array.setflags(False)  # type: ignore[call-arg]  # `write`; three times as fast as by name


@dataclass(frozen=True, eq=False, init=False)
class PlatoonState:
    """Spacings and speeds of n >= 1 vehicles (paper, section II), and where the leader is.

    Lists and tuples are accepted.  `validate` checks that the state lies in the state space Omega.

    Attributes
    ----------
    s : (n-1,) array, spacings [m], that behind the leader first; read-only
    v : (n,) array, speeds [m/s], leader first; read-only
    constants : the constants that Omega depends on
    x_leader : position of vehicle 1 [m]
    """

    s: NDArray[np.float64]
    v: NDArray[np.float64]
    constants: PlatoonParameters
    x_leader: float

    def __init__(
        self, s: ArrayLike, v: ArrayLike, constants: PlatoonParameters | None = None, x_leader: float = 0.0
    ) -> None:
        object.__setattr__(self, "s", read_only(s))
        object.__setattr__(self, "v", read_only(v))
        object.__setattr__(self, "constants", constants or PlatoonParameters())
        object.__setattr__(self, "x_leader", x_leader)

    def __reduce__(self) -> tuple[object, ...]:
        """Made anew where it is copied or unpickled, as NumPy forgets there that arrays are read-only."""
        return type(self), (self.s, self.v, self.constants, self.x_leader)

    def __repr__(self) -> str:
        s, v = (" ".join(f"{value:.4g}" for value in np.ravel(part)) for part in (self.s, self.v))
        return f"PlatoonState of {self.v.size} vehicles: spacings [{s}] m, speeds [{v}] m/s"


Start = PlatoonState | tuple[ArrayLike, ArrayLike] | list[ArrayLike]
"""A start: a state, or a pair of (n-1,) spacings [m] and (n,) speeds [m/s]."""


def as_state(start: Start) -> PlatoonState:
    """The state that a start stands for, with the paper's constants where it is a pair (ours).

    Parameters
    ----------
    start : a state, or a pair of spacings and speeds

    Raises
    ------
    ModelError : where it is neither
    """
    if isinstance(start, PlatoonState):
        return start
    try:
        s, v = start
        return PlatoonState(s, v)
    except (TypeError, ValueError):
        raise ModelError("start", shortened(repr(start))) from None


def shortened(text: str, most: int = 60) -> str:
    """A text on one line, for sentences (ours).

    Parameters
    ----------
    text : of any length
    most : characters that are left of it
    """
    text = " ".join(text.split())
    return text if len(text) <= most else f"{text[: most - 4]} ..."


@dataclass(frozen=True)
class StartDomain:
    """The starts that networks are trained on (paper, sections IV and V).

    Attributes
    ----------
    gap_min, gap_max : bounds of every spacing [m]
    speed_min, speed_max : bounds of every speed [m/s]
    standstill : standstill distance, the paper's s-bar [m] (ours: L)
    headway : smallest headway of a rear vehicle, the paper's rho [s] (ours)
    """

    gap_min: float = 8.0
    gap_max: float = 12.0
    speed_min: float = 27.0
    speed_max: float = 33.0
    standstill: float = 5.0
    headway: float = 0.1

    def contains(self, s: ArrayLike, v: ArrayLike) -> NDArray[np.bool_] | np.bool_:
        """Whether each start lies in the domain: inside all bounds and s_i > standstill + headway v_i.

        Parameters
        ----------
        s : (n-1, ...) array, spacings [m]
        v : (n, ...) array, speeds [m/s]

        Returns
        -------
        (...) array of booleans
        """
        s, v = np.asarray(s), np.asarray(v)
        inside = ((s >= self.gap_min) & (s <= self.gap_max)).all(axis=0)
        inside = inside & ((v >= self.speed_min) & (v <= self.speed_max)).all(axis=0)
        return inside & (s > self.standstill + self.headway * v[1:]).all(axis=0)

    def draw(
        self, rng: np.random.Generator, vehicles: int, count: int
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Independent starts, uniform over the domain.

        Every vehicle's spacing and speed are drawn together and drawn again until they keep the headway, which is
        the same as rejecting whole starts because the condition couples no two vehicles.

        Parameters
        ----------
        rng : source of randomness
        vehicles : n
        count : number of starts B

        Returns
        -------
        s, v : (n-1, B) and (n, B) arrays [m], [m/s]
        """
        v = rng.uniform(self.speed_min, self.speed_max, (vehicles, count))
        s = rng.uniform(self.gap_min, self.gap_max, (vehicles - 1, count))
        while (close := s <= self.standstill + self.headway * v[1:]).any():
            s[close] = rng.uniform(self.gap_min, self.gap_max, close.sum())
            v[1:][close] = rng.uniform(self.speed_min, self.speed_max, close.sum())
        return s, v

    def as_dict(self) -> dict[str, float]:
        """The bounds by name, for metadata."""
        return asdict(self)
