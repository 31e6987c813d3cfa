"""The initial state of a platoon, and the domain that starts are drawn from."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import ModelError
from .parameters import PlatoonParameters


@dataclass(frozen=True, eq=False)
class PlatoonState:
    """Gaps and speeds of n >= 1 vehicles inside the state space Omega (paper, section II), and where the leader is.

    Attributes
    ----------
    s : (n-1,) array, gaps [m], leader's first; above L
    v : (n,) array, speeds [m/s], leader first; in [0, v_max]
    constants : the constants that Omega depends on
    x_leader : position of vehicle 1 [m]

    Raises
    ------
    ModelError : where shapes disagree or a value is not finite or outside Omega, naming the vehicle
    """

    s: NDArray[np.float64]
    v: NDArray[np.float64]
    constants: PlatoonParameters = field(default_factory=PlatoonParameters)
    x_leader: float = 0.0

    def __post_init__(self) -> None:
        s, v = np.array(self.s, dtype=float), np.array(self.v, dtype=float)
        object.__setattr__(self, "s", s)
        object.__setattr__(self, "v", v)
        if s.ndim != 1 or v.ndim != 1 or s.size != v.size - 1:
            raise ModelError("shape", s.size, v.size)
        if not np.isfinite(self.x_leader):
            raise ModelError("finite", "x_start", self.x_leader, "m")
        for i, gap in enumerate(s, start=2):
            _require(np.isfinite(gap), "finite", f"s_start[{i}]", gap, "m")
            _require(gap > 0, "gap_order", i, gap, i, i - 1)
            _require(gap > self.constants.L, "gap", i, gap, self.constants.L)
        for i, speed in enumerate(v, start=1):
            _require(np.isfinite(speed), "finite", f"v_start[{i}]", speed, "m/s")
            _require(speed >= 0, "speed_backwards", i, speed, self.constants.v_max, i)
            _require(speed <= self.constants.v_max, "speed", i, speed, self.constants.v_max, i)


def _require(holds: Any, key: str, *values: object) -> None:
    if not holds:
        raise ModelError(key, *values)


@dataclass(frozen=True)
class StartDomain:
    """The starts that networks are trained on (paper, sections IV and V).

    Attributes
    ----------
    gap_min, gap_max : bounds of every gap [m]
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

    def contains(self, s: Any, v: Any) -> Any:
        """Whether each start lies in the domain: inside all bounds and s_i > standstill + headway v_i.

        Parameters
        ----------
        s : (n-1, ...) array, gaps [m]
        v : (n, ...) array, speeds [m/s]

        Returns
        -------
        (...) array of booleans
        """
        inside = ((s >= self.gap_min) & (s <= self.gap_max)).all(axis=0)
        inside &= ((v >= self.speed_min) & (v <= self.speed_max)).all(axis=0)
        return inside & (s > self.standstill + self.headway * v[1:]).all(axis=0)

    def draw(self, rng: np.random.Generator, vehicles: int, count: int) -> tuple[Any, Any]:
        """Independent starts, uniform over the domain.

        Every vehicle's gap and speed are drawn together and drawn again until they keep the headway, which is
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
