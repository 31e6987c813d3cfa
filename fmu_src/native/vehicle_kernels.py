"""Kernels of vehicles that act late and softly, of how they brake, and of what is certified for them."""

from __future__ import annotations

from typing import Any

import casadi

from psp_model.law.watching import nearer
from psp_model.parameters import Actuation, PlatoonParameters, generic
from psp_model.sampling.uncertain import Errors, contact_bound, spacing_bound, speed_bounds
from psp_model.vehicles.actuation import limited
from psp_model.vehicles.braking import hardest
from psp_model.vehicles.ride import (
    approached,
    faded,
    first_felt,
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
        + c_function("nearer_stop_at_once", [v, command, span, low], [nearer_stop(v, command, command, 0.0, span, low)])
    )


def uncertain_kernels() -> str:
    """Bounds on the sampling period of single spacings and single vehicles that are known within bounds."""
    s, v, dv, da, most, least = _symbols("s v dv da most least")
    error_s, error_v, L, v_max = _symbols("error_s error_v L v_max")
    errors, constants = Errors(error_s, error_v), generic(PlatoonParameters, L=L, v_max=v_max)
    faster, slower = speed_bounds(v, most, least, errors, constants)
    return (
        c_function("spacing_bound", [s, error_s, L, v_max], [spacing_bound(s, errors, constants)])
        + c_function("contact_bound", [s, dv, da, error_s, error_v, L], [contact_bound(s, dv, da, errors, constants)])
        + c_function("speeds_bound", [v, most, least, error_v, v_max], [casadi.fmin(faster, slower)])
    )


def prediction_kernels() -> str:
    """What is remembered of others, and how hard a vehicle may brake."""
    before, value, share, needed, v, t = _symbols("before value share needed v t")
    return c_function("nearer", [before, value, share], [nearer(before, value, share)]) + c_function(
        "hardest", [needed, v, t], [hardest(needed, v, t)]
    )
