"""The constants of the model, the weights of its objective and the parameters of its potential."""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import isfinite
from typing import Any, Protocol

from .errors import ModelError

HILL_WIDTH = 3.0  # [m] the paper's convention: the hill spans [r, r + 3 m]
ALPHA_MIN, ALPHA_MAX = 1e-3, 1e-1  # [1] paper, feasible set
P_MIN, P_MAX = 3.0, 9.0  # [1] paper, feasible set

_UNITS = {"L": "m", "lam": "m", "v_star": "m/s", "v_max": "m/s", "epsilon": "m/s2", "mu": "1/s", "z": "m/s2"}
_UNITS |= {"w1": "1", "w2": "1", "a_ref": "m/s2", "s_ref": "m", "alpha": "1", "r": "m", "p": "1"}


class PotentialShape(Protocol):
    """What the potential needs to know of its parameters: numbers, arrays or symbols that broadcast with the gaps."""

    @property
    def alpha(self) -> Any: ...

    @property
    def r(self) -> Any: ...

    @property
    def p(self) -> Any: ...

    @property
    def hill(self) -> Any: ...


class Constants(Protocol):
    """What the model needs to know of its constants: numbers or symbols."""

    @property
    def L(self) -> Any: ...

    @property
    def lam(self) -> Any: ...

    @property
    def v_star(self) -> Any: ...

    @property
    def v_max(self) -> Any: ...

    @property
    def epsilon(self) -> Any: ...

    @property
    def mu(self) -> Any: ...


def _require_finite(instance: Any) -> None:
    """Raise ModelError if a field of `instance` is NaN or infinite."""
    for field in fields(instance):
        value = getattr(instance, field.name)
        if not isfinite(value):
            name = "lambda" if field.name == "lam" else field.name
            raise ModelError("finite", name, value, _UNITS.get(field.name, "1"))


@dataclass(frozen=True)
class PlatoonParameters:
    """The constants of the closed loop (paper, section V, except where marked ours).

    Attributes
    ----------
    L : smallest allowable gap [m]
    lam : gap from which vehicles no longer repel each other, the paper's lambda [m]
    v_star : desired cruising speed [m/s]
    v_max : speed limit [m/s]
    epsilon : width over which f is smoothed [m/s2]
    mu : smallest feedback gain [1/s]
    z : limit of |V_new'| on the hill [m/s2]

    Raises
    ------
    ModelError : where a constant is not finite or not in the model's domain
    """

    L: float = 5.0
    lam: float = 20.0
    v_star: float = 30.0
    v_max: float = 35.0
    epsilon: float = 0.2
    mu: float = 0.5
    z: float = 4.0

    def __post_init__(self) -> None:
        _require_finite(self)
        if not self.L > 0:
            raise ModelError("L", self.L)
        if not self.lam > self.L + HILL_WIDTH:
            raise ModelError("lambda", self.lam, self.L + HILL_WIDTH)
        if not self.v_max > 0:
            raise ModelError("v_max", self.v_max)
        if not self.v_star > 0:
            raise ModelError("v_star_backwards", self.v_star, self.v_max)
        if not self.v_star < self.v_max:
            raise ModelError("v_star", self.v_star, self.v_max)
        for name in ("epsilon", "mu", "z"):
            if not getattr(self, name) > 0:
                raise ModelError(name, getattr(self, name))


@dataclass(frozen=True)
class ObjectiveWeights:
    """Weights and scales of the objective J.

    Attributes
    ----------
    w1, w2 : weights of acceleration and of gaps [1] (paper, section V)
    a_ref : scale of acceleration [m/s2] (ours: equal to z)
    s_ref : scale of the gaps [m] (ours: equal to lambda)

    Raises
    ------
    ModelError : where a weight is negative or a scale is not positive
    """

    w1: float = 0.5
    w2: float = 0.5
    a_ref: float = 4.0
    s_ref: float = 20.0

    def __post_init__(self) -> None:
        _require_finite(self)
        for name in ("w1", "w2"):
            if not getattr(self, name) >= 0:
                raise ModelError(name, getattr(self, name))
        for name in ("a_ref", "s_ref"):
            if not getattr(self, name) > 0:
                raise ModelError(name, getattr(self, name))


@dataclass(frozen=True)
class PotentialParameters:
    """One potential out of the family V_new (paper, eq. of V_new); V_old is the member without a hill.

    Attributes
    ----------
    alpha : scale of the repulsion [1]
    r : where the hill begins; it ends at r + 3 m [m]
    p : exponent of the hill [1]
    hill : 1 with the hill (V_new), 0 without (V_old) [1]

    Only finiteness is required here: whether a triple lies in the feasible set depends on the constants and is the
    business of `feasible.require_feasible`.

    Raises
    ------
    ModelError : where a parameter is not finite
    """

    alpha: float
    r: float
    p: float
    hill: float = 1.0

    def __post_init__(self) -> None:
        _require_finite(self)


V_OLD = PotentialParameters(alpha=1.0, r=0.0, p=0.0, hill=0.0)
"""The paper's V_old: alpha = 1 and no hill, so r and p mean nothing and are 0."""

BEST_FIXED = PotentialParameters(alpha=1e-3, r=11.0, p=5.5)
"""The fixed triple that serves 7 vehicles best on average (ours, measured); the fallback of the network."""
