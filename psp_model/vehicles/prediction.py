"""Where the vehicles will be when the next command takes effect: sampled-data predictor feedback (ours)."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..law.cooperation import Cooperation, Traffic, contact_spacing, cooperative_command, is_off
from ..law.potential import Potential
from ..namespaces import Array, Number, array_namespace
from ..parameters import Actuation, PlatoonParameters
from ..sampling.hold import spacings_after
from .actuation import Actuators, Foreign, at_rest, commanded, drive, settle
from .ride import ride, unless_standing

CLOSEST = 1e-3  # [m] a predicted clearance of 0 or less counts as this: the law is not defined there (ours)


class Issued(NamedTuple):
    """What the controller knows of the actuators: their modelled state `span` before now, and all commands since.

    Attributes
    ----------
    actuators : modelled state a time `span` ago; the queue holds what has been commanded since, and before
    span : age of the oldest measurement that can be predicted from [s]
    """

    actuators: Actuators
    span: float


class Predicted(NamedTuple):
    """The vehicles at the time at which a command given now takes effect.

    Attributes
    ----------
    s, v : (n-1, ...) spacings [m] and (n, ...) speeds [m/s]
    a : (n, ...) accelerations then, 0 for vehicles that stand [m/s2]
    """

    s: Array
    v: Array
    a: Array


def nothing_issued(v: Array, span: float) -> Issued:
    """Before the first command: actuators hold 0 (ours).

    Parameters
    ----------
    v : (n, ...) array, speeds [m/s]
    span : as in `Issued` [s]
    """
    return Issued(at_rest(v), span)


def issue(issued: Issued, a: Array, T: float, actuation: Actuation) -> Issued:
    """What is known one sampling period after a command has been given (ours).

    Parameters
    ----------
    a : (n, ...) accelerations commanded [m/s2]
    T : time until the next sampling instant [s]
    """
    told = commanded(issued.actuators, a, actuation, -issued.span)
    return Issued(settle(told, actuation, T), issued.span)


def predict(
    issued: Issued, s: Array, v: Array, age: float, actuation: Actuation, foreign: Foreign | None = None
) -> Predicted:
    """The vehicles a dead time from now, from what was measured `age` ago (ours).

    For what was measured without error, with the true dead time and lags, exact but for vehicles that drive
    themselves; these are extrapolated with the accelerations given.

    Parameters
    ----------
    s, v : (n-1, ...) spacings [m] and (n, ...) speeds [m/s], measured
    age : how old they are, up to the span [s]
    """
    actuators, horizon = issued.actuators, age + actuation.actuation_delay
    if issued.span == 0.0 and horizon == 0.0 and foreign is None:  # the state is that which was measured
        return Predicted(s, v, unless_standing(v, actuators.command if is_off(actuation.actuator_lag) else actuators.a))
    if issued.span > age:
        actuators = settle(actuators, actuation, issued.span - age)
    then, moved, actuators = drive(v, actuators, actuation, horizon, foreign)
    a = actuators.command if is_off(actuation.actuator_lag) else actuators.a
    if foreign is not None:
        a = array_namespace(v).where(foreign.automated > 0.5, a, foreign.a)
    return Predicted(spacings_after(s, moved), then, unless_standing(then, a))


def later(predicted: Predicted, span: Number) -> Predicted:
    """The vehicles a time later if they keep their accelerations, down to standstill (ours).

    Parameters
    ----------
    span : time [s]
    """
    v, moved, _ = ride(predicted.v, predicted.a, predicted.a, 0.0, span)
    return Predicted(spacings_after(predicted.s, moved), v, unless_standing(v, predicted.a))


def predictive_command(
    predicted: Predicted,
    shape: Potential,
    constants: PlatoonParameters,
    cooperation: Cooperation,
    traffic: Traffic,
    lag: Number,
) -> Array:
    """The law a lag ahead: command + lag (d/dt) command is what a first-order lag turns into the command (ours).

    The law is evaluated at the predicted state and the longest lag after it; a vehicle takes the mean of the two with
    the share of the longest lag that its own has.

    Parameters
    ----------
    lag : time constants of the actuators, a number or (n, ...) array [s]

    Returns
    -------
    (n, ...) array [m/s2]
    """

    def at(state: Predicted) -> Array:
        xp = array_namespace(state.v)
        v = xp.minimum(state.v, constants.v_max)
        room = contact_spacing(state.s, cooperation, constants) - constants.L
        s = xp.where(room > 0.0, state.s, state.s + (CLOSEST - room))
        return cooperative_command(s, v, shape, constants, cooperation, _with_rates(traffic, state.a))

    if is_off(lag):
        return at(predicted)
    longest = np.max(lag) if isinstance(lag, np.ndarray) else lag
    ahead = at(later(predicted, longest))
    if not isinstance(lag, np.ndarray):
        return ahead
    share = lag / longest if longest > 0.0 else lag
    if (share == 1.0).all():
        return ahead
    return share * ahead + (1.0 - share) * at(predicted)


def _with_rates(traffic: Traffic, a: Array) -> Traffic:
    """The traffic with the accelerations of vehicles that drive themselves as predicted."""
    return traffic if traffic.automated is None else replace(traffic, a=a)
