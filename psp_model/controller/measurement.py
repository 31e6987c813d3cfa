"""What a controller of measured vehicles is told at a sampling instant, and whether that is in order."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite, nextafter

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ModelError
from ..law.cooperation import Cooperation, contact_spacing
from ..parameters import PlatoonParameters
from ..sampling.policy import Lemma1Policy
from ..vehicles.road_law import Seen
from .settings import ControllerSettings

Vector = NDArray[np.float64]

ROUNDING = 1e-6  # [1] of L or v_max: what is measured so little outside the state space is taken as its bound (ours)


@dataclass(frozen=True, eq=False, init=False)
class Measurement:
    """The inputs at a sampling instant; lists and tuples are accepted.

    Attributes
    ----------
    s, v : (N-1,) spacings [m] and (N,) speeds [m/s], leader first; only the first n_active vehicles count
    n_active : vehicles on the lane that the controller looks at
    resolve : replan, that is select alpha, r, p again, where this rises above 0.5
    age : time since spacings and speeds were measured [s]
    age_rounding : how far the age may be off because clocks are rounded [s]
    v_desired : desired speed of vehicles that follow no vehicle instead of v_star, 0 to stand, None for v_star [m/s]
        (ours: the paper has one v_star for good)
    a_desired : its derivative [m/s2]
    automated : (N,) 0 for a vehicle that drives itself, 1 else; None where all are automated
    a_measured, a_known : (N,) accelerations communicated by vehicles that drive themselves [m/s2], None for none; and 0
        for those whose acceleration is not communicated, 1 else, None for all.  Others are estimated from speeds
    """

    s: Vector
    v: Vector
    n_active: float
    resolve: float = 0.0
    age: float = 0.0
    age_rounding: float = 0.0
    v_desired: float | None = None
    a_desired: float = 0.0
    automated: Vector | None = None
    a_measured: Vector | None = None
    a_known: Vector | None = None

    def __init__(
        self,
        s: ArrayLike,
        v: ArrayLike,
        n_active: float,
        resolve: float = 0.0,
        age: float = 0.0,
        age_rounding: float = 0.0,
        v_desired: float | None = None,
        a_desired: float = 0.0,
        automated: ArrayLike | None = None,
        a_measured: ArrayLike | None = None,
        a_known: ArrayLike | None = None,
    ) -> None:
        for name, array in (("s", s), ("v", v)):
            object.__setattr__(self, name, np.asarray(array, dtype=np.float64))
        for name, optional in (("automated", automated), ("a_measured", a_measured), ("a_known", a_known)):
            object.__setattr__(self, name, None if optional is None else np.asarray(optional, dtype=np.float64))
        object.__setattr__(self, "n_active", n_active)
        object.__setattr__(self, "resolve", resolve)
        object.__setattr__(self, "age", age)
        object.__setattr__(self, "age_rounding", age_rounding)
        object.__setattr__(self, "v_desired", v_desired)
        object.__setattr__(self, "a_desired", a_desired)


def in_order(settings: ControllerSettings, measured: Measurement) -> Seen:
    """The inputs of the active vehicles, inside the state space.

    What lies outside by no more than ROUNDING is taken as the bound, a spacing as the next number above L: vehicles
    that stand have speeds and spacings such as -1e-18 m/s and L - 1e-12 m.  Under policy 1, which asks for spacings
    above L + v_max T, a spacing of L or less is rejected all the same.  With lengths, L is where vehicles touch.

    Parameters
    ----------
    settings : of the controller
    measured : the inputs

    Raises
    ------
    ModelError : where an input is not in order
    """
    n, v_max = measured.n_active, settings.constants.v_max
    if not (1 <= n <= settings.capacity and n == int(n)):
        raise ModelError("active", n, settings.capacity)
    if not isfinite(measured.age):
        raise ModelError("age", measured.age)
    if not measured.age <= settings.max_age + measured.age_rounding:
        raise ModelError("stale", measured.age, settings.max_age)
    if settings.predicts and not measured.age <= settings.oldest + measured.age_rounding:
        raise ModelError("older_input", measured.age, settings.oldest)
    for name, unit in (("resolve", "1"), ("a_desired", "m/s2")):
        if not isfinite(value := getattr(measured, name)):
            raise ModelError("finite", name, value, unit)
    automated, a, known = _communicated(measured, int(n))
    desired = measured.v_desired
    if desired is not None:
        _require_desired(desired, v_max)
        desired = min(max(desired, 0.0), v_max)
    s, v = _motion(settings, measured.s[: int(n) - 1], measured.v[: int(n)])
    age = min(max(measured.age, 0.0), settings.oldest)
    return Seen(s, v, age, automated, a, known, desired, measured.a_desired)


def drives_itself(measured: Measurement) -> NDArray[np.bool_]:
    """(N,) whether a vehicle is said to drive itself.

    Parameters
    ----------
    measured : the inputs
    """
    if measured.automated is None:
        return np.zeros(measured.v.size, dtype=bool)
    drives: NDArray[np.bool_] = measured.automated <= 0.5
    return drives


def _communicated(measured: Measurement, n: int) -> tuple[Vector | None, Vector | None, Vector | None]:
    """Flags of automated vehicles, accelerations communicated and their flags, as `Seen` has them; ModelError else."""
    if measured.automated is None or (flags := measured.automated[:n]).min() == 1.0 == flags.max():
        return None, None, None
    _require_finite("automated", "1", flags, np.ones(n, dtype=bool))
    drives = drives_itself(measured)[:n]
    if not drives.any():
        return None, None, None
    known, a, used = measured.a_known, measured.a_measured, drives
    if known is not None:
        _require_finite("a_known", "1", known[:n], drives)
        used = drives & (known[:n] > 0.5)
        known = np.where(used, 1.0, 0.0)
    if a is not None:
        _require_finite("a_measured", "m/s2", a[:n], used)
        a = np.where(used, a[:n], 0.0)
    return np.where(drives, 0.0, 1.0), a, known


def _require_finite(name: str, unit: str, values: Vector, used: NDArray[np.bool_]) -> None:
    """Raise ModelError where a value that is used is not finite."""
    for i in np.flatnonzero(~np.isfinite(values) & used).tolist():
        raise ModelError("finite", f"{name}[{i + 1}]", values[i], unit)


def _motion(settings: ControllerSettings, s: Vector, v: Vector) -> tuple[Vector, Vector]:
    """Spacings and speeds inside the state space; ModelError where they are not in order."""
    L, v_max = settings.constants.L, settings.constants.v_max
    cooperation, _ = settings.of(v.size)
    contact = contact_spacing(s, cooperation, settings.constants)
    above_L = nextafter(L, inf)
    least = above_L if settings.sampling.policy == Lemma1Policy.ERROR else L - ROUNDING * L
    apart, inside = (
        (contact >= least) & (s > 0.0) & (s < inf),
        (v >= -ROUNDING * v_max) & (v <= v_max + ROUNDING * v_max),
    )
    if not apart.all():
        i = int(np.argmin(apart))
        raise _bad_spacing(i + 2, s[i], settings.constants, cooperation)
    if not inside.all():
        i = int(np.argmin(inside))
        raise _bad_speed(i + 1, v[i], v_max)
    return np.where(contact >= above_L, s, s + (above_L - contact)), np.minimum(np.maximum(v, 0.0), v_max)


def _require_desired(desired: float, v_max: float) -> None:
    """Raise ModelError where a desired speed lies outside [0, v_max], rounding aside."""
    if not np.isfinite(desired):
        raise ModelError("v_desired_finite", desired, v_max)
    if desired < -ROUNDING * v_max:
        raise ModelError("v_desired_backwards", desired)
    if desired > v_max + ROUNDING * v_max:
        raise ModelError("v_desired", desired, v_max)


def _bad_spacing(vehicle: int, spacing: float, constants: PlatoonParameters, cooperation: Cooperation) -> ModelError:
    """What to say of a measured spacing that is not in order."""
    if not np.isfinite(spacing):
        return ModelError("finite", f"s[{vehicle}]", spacing, "m")
    if spacing <= 0:
        return ModelError("measured_order", vehicle, spacing, vehicle, vehicle - 1)
    ahead = length_ahead(vehicle, constants, cooperation)
    if ahead != constants.L:
        return ModelError("measured_clearance", vehicle, spacing, vehicle - 1, ahead)
    return ModelError("measured_spacing", vehicle, spacing, constants.L)


def length_ahead(vehicle: int, constants: PlatoonParameters, cooperation: Cooperation) -> float:
    """The length of the vehicle ahead of another one [m].

    Parameters
    ----------
    vehicle : number of the one behind, from 2
    constants, cooperation : of the law
    """
    length = cooperation.length
    if length is None:
        return constants.L
    return float(np.broadcast_to(np.ravel(length), (1,))[0] if np.size(length) == 1 else np.ravel(length)[vehicle - 2])


def _bad_speed(vehicle: int, speed: float, v_max: float) -> ModelError:
    """What to say of a measured speed that is not in order."""
    if not np.isfinite(speed):
        return ModelError("finite", f"v[{vehicle}]", speed, "m/s")
    if speed < 0:
        return ModelError("measured_backwards", vehicle, speed)
    return ModelError("measured_speed", vehicle, speed, v_max)
