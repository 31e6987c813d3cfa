"""Kernels of vehicles that act late and softly, one vehicle at a time (psp_model/vehicles)."""

from __future__ import annotations

from typing import Any

import casadi

from psp_model.parameters import Actuation, generic
from psp_model.vehicles.actuation import (
    approached,
    faded,
    first_felt,
    limited,
    nearer_stop,
    turning,
    uninterrupted,
    unless_standing,
    unstopped,
)

from .scalar_c import c_function


def _symbols(names: str) -> list[Any]:
    return [casadi.SX.sym(name) for name in names.split()]


def actuation_kernels() -> str:
    """What an actuator and a vehicle do under one command; `gone` and `kept` are the shares that `faded` gives."""
    v, a, command, lag, span, gone, kept = _symbols("v a command lag span gone kept")
    low, a_min, a_max = _symbols("low a_min a_max")
    limits, ride = generic(Actuation, a_min=a_min, a_max=a_max), [v, a, command, lag, span]
    at_once = [*unstopped(v, command, command, 0.0, span, (1.0, 0.0))][:2]
    return (
        c_function("limited", [command, a_min, a_max], [limited(command, limits)])
        + c_function("unless_standing", [v, a], [unless_standing(v, a)])
        + c_function("first_felt", [a, command, lag], [first_felt(a, command, lag)])
        + c_function("faded", [lag, span], [*faded(span, lag, span)])
        + c_function("approached", [a, command, gone], [approached(a, command, gone)])
        + c_function("unstopped", [*ride, gone, kept], [*unstopped(v, a, command, lag, span, (gone, kept))])
        + c_function("unstopped_at_once", [v, command, span], at_once)
        + c_function("turning", [a, command, lag], [turning(a, command, lag)])
        + c_function("uninterrupted", ride, [*uninterrupted(*ride)])
        + c_function("nearer_stop", [*ride, low], [nearer_stop(v, a, command, lag, span, low)])
    )
