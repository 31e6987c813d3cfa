"""What a controller of measured vehicles decides, and what it remembers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..law.cooperation import clearances
from ..law.following import followed_by
from ..law.potential import V_OLD, PotentialParameters
from ..sampling.policy import Certificate
from ..state import read_only
from ..vehicles.braking import MOST, Braking, brake_margin
from ..vehicles.road_law import Remembered
from .settings import ControllerSettings

Vector = NDArray[np.float64]


class Basis(NamedTuple):
    """What a decision was based on, as far as it is shown.

    Attributes
    ----------
    s, v : (n-1,) spacings [m] and (n,) speeds [m/s], measured
    age : how old they were [s]
    automated : (n,) 1 for vehicles that are controlled, 0 for those that drive themselves
    s_predicted, v_predicted, a_predicted : (n-1,), (n,), (n,) what was predicted for the time at which the command
        takes effect [m], [m/s], [m/s2]
    """

    s: Vector
    v: Vector
    age: float
    automated: Vector
    s_predicted: Vector
    v_predicted: Vector
    a_predicted: Vector


@dataclass(frozen=True, eq=False)
class Command:
    """What the controller decided at a sampling instant, and all that it remembers of the past.

    Attributes
    ----------
    a : (N,) commanded accelerations [m/s2], 0 for vehicles that are not active or drive themselves
    saturated : (N,) whether a_min or a_max cut the feedback, so that Lemma 1's argument does not cover the vehicle
    in_order : whether the inputs were valid; if not, this is the fail-safe command
    T_max : Lemma 1's bound for the command [s], 0 with the fail-safe command
    T_exact : the exact period for it [s], 0 with the fail-safe command
    violations, faults : sampling instants so far that the chosen certificate did not certify, and with invalid inputs
    choices : how often alpha, r, p were selected
    n_active : vehicles under control at the last selection
    in_domain : whether the vehicles were in a network's training domain at the last selection
    resolve : the input at the last sampling instant
    shape : the potential in use
    basis : what was measured and predicted at the last instant with valid inputs, None before the first
    memory : commands on their way and estimates of others, None where nothing is remembered
    """

    a: Vector
    saturated: NDArray[np.bool_]
    in_order: bool
    T_max: float
    T_exact: float
    violations: int
    faults: int
    choices: int
    n_active: int
    in_domain: bool
    resolve: float
    shape: PotentialParameters
    basis: Basis | None = None
    memory: Remembered | None = None


def no_command(settings: ControllerSettings) -> Command:
    """The state before the first sampling instant: nothing is commanded.

    Parameters
    ----------
    settings : of the controller
    """
    nobody, request = read_only(np.zeros(settings.capacity)), settings.request
    shape = V_OLD if request.old else request.fixed
    return Command(nobody, nobody > 0, True, 0.0, 0.0, 0, 0, 0, 0, False, 0.0, shape)


def certified_period(settings: ControllerSettings, T_max: float, T_exact: float) -> float:
    """The bound on the sampling period that counts, by the certificate chosen [s].

    Parameters
    ----------
    settings : of the controller
    T_max, T_exact : Lemma 1's bound and the exact period [s]
    """
    return T_exact if settings.sampling.certificate == Certificate.EXACT else T_max


def is_certified(settings: ControllerSettings, command: Command) -> bool:
    """Whether the certificate chosen certifies T for a command.

    Parameters
    ----------
    settings, command : of the controller
    """
    return certified_period(settings, command.T_max, command.T_exact) > settings.sampling.T


def margin_of(settings: ControllerSettings, command: Command) -> float:
    """How hard those who drive themselves, or the leader, may brake from now on: `brake_margin` [m/s2].

    They brake from the time of the measurement on.  Until a brake command takes effect, vehicles drive with their mean
    predicted acceleration.

    Parameters
    ----------
    settings, command : of the controller

    Returns
    -------
    from 0 to 12, which is also what it is before the first instant; 0 with the fail-safe command
    """
    basis = command.basis
    if not command.in_order:
        return 0.0
    if basis is None:
        return MOST
    cooperation, actuation = settings.of(basis.v.size)
    dead_time = basis.age + actuation.actuation_delay
    a = (basis.v_predicted - basis.v) / dead_time if dead_time > 0.0 else basis.a_predicted
    vehicles = Braking(basis.v, a, dead_time, actuation.actuator_lag, actuation.a_min)
    apart = clearances(basis.s, cooperation, settings.constants)
    return float(brake_margin(apart, vehicles, basis.automated))


def followed_of(settings: ControllerSettings, command: Command) -> Vector:
    """The number of the vehicle whose speed each one takes on, 0 for none, (N,).

    Parameters
    ----------
    settings, command : of the controller
    """
    found = np.zeros(settings.capacity)
    if command.basis is not None:
        automated = command.basis.automated
        found[: automated.size] = followed_by(automated, settings.cooperation.following)
    return found
