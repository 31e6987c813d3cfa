"""The model's functions of single spacings and single vehicles as C, from its own functions by way of CasADi."""

from __future__ import annotations

from typing import Any

import casadi

from psp_model.law.cooperation import (
    Cooperation,
    Traffic,
    clearances,
    closing_speeds,
    contact_spacing,
    desired,
    feed_forward,
    model_spacing,
    viscosity,
)
from psp_model.law.extended import DrivenLeader, driven
from psp_model.law.feedback import command, command_towards
from psp_model.law.potential import PotentialParameters, on_hill, potential_slope
from psp_model.objective import acceleration_cost, spacing_cost
from psp_model.parameters import ObjectiveWeights, PlatoonParameters, generic
from psp_model.sampling.exact import first_contact
from psp_model.sampling.hold import advance, spacings_after, travelled
from psp_model.sampling.lemma1 import period_bounds
from psp_model.selection.feasible import cell_bound
from psp_model.vehicles.leader import between, held_for, on_line

from .scalar_c import Symbols, c_function
from .vehicle_kernels import actuation_kernels, prediction_kernels, uncertain_kernels

_HEAD = """/* From psp_model by way of CasADi; fmu_src/native/kernels.py wrote it. */
#ifndef PSP_KERNELS_H
#define PSP_KERNELS_H

#include <math.h>
"""


def _symbols(names: str) -> list[Any]:
    return [casadi.SX.sym(name) for name in names.split()]


def _with_tangent(name: str, inputs: Symbols, output: Any) -> str:
    """The directional derivative of a function: its inputs and a seed for each."""
    seeds = [casadi.SX.sym(f"d_{symbol.name()}") for symbol in inputs]
    tangent = casadi.jtimes(output, casadi.vertcat(*inputs), casadi.vertcat(*seeds))
    return c_function(f"{name}_tangent", [*inputs, *seeds], [tangent])


def _potential_kernels() -> str:
    s, b, alpha, r, p, hill, L, lam = inputs = _symbols("s b alpha r p hill L lam")
    constants = generic(PlatoonParameters, L=L, lam=lam)
    shape = generic(PotentialParameters, alpha=alpha, r=r, p=p, hill=hill)
    flat = generic(PotentialParameters, alpha=alpha, r=0.0, p=3.0, hill=0.0)
    slope, of_slope = potential_slope(s, shape, constants), [s, alpha, r, p, hill, L, lam]
    return (
        c_function("on_hill", [s, r], [on_hill(s, shape)])
        + c_function("slope", of_slope, [slope])
        + c_function("slope_off_hill", [s, alpha, L, lam], [potential_slope(s, flat, constants)])
        + c_function("cell_bound", inputs, cell_bound(s, b, shape, constants))
        + _with_tangent("slope", of_slope, slope)
    )


def _feedback_kernels() -> str:
    u, v, v_star, v_max, epsilon, mu = inputs = _symbols("u v v_star v_max epsilon mu")
    commanded = command(u, v, generic(PlatoonParameters, v_star=v_star, v_max=v_max, epsilon=epsilon, mu=mu))
    s, a, L, v_desired = _symbols("s a L v_desired")
    of_desired = generic(PlatoonParameters, v_max=v_max, epsilon=epsilon, mu=mu)
    of_spacing, of_speed = period_bounds(s, v, a, generic(PlatoonParameters, L=L, v_max=v_max))
    return (
        c_function("command", inputs, [commanded])
        + c_function(
            "command_towards",
            [u, v, v_desired, v_max, epsilon, mu],
            [command_towards(u, v, of_desired, v_desired)],
        )
        + c_function("spacing_period", [s, L, v_max], [of_spacing])
        + c_function("speed_bound", [v, a, v_max], [of_speed])
        + _with_tangent("command", inputs, commanded)
        + _with_tangent("spacing_period", [s, L, v_max], of_spacing)
        + _with_tangent("speed_bound", [v, a, v_max], of_speed)
    )


def _cooperation_kernels() -> str:
    """The terms of the extended law, from platoons of two vehicles or of one."""
    s, v, v_front, length, time_gap, L, v_max = _symbols("s v v_front length time_gap L v_max")
    kappa, kappa_reach, speed, begins, ends = _symbols("kappa kappa_reach closing_speed closing_spacing closing_reach")
    share, wanted, closing, rate = _symbols("feedforward v_desired closing a_desired")
    constants, pair = generic(PlatoonParameters, L=L, v_max=v_max), casadi.vertcat(v_front, v)
    lengths = casadi.vertcat(length, length)
    one = generic(Cooperation, length=lengths, time_gap=time_gap, kappa=kappa, kappa_reach=kappa_reach)
    closes = generic(Cooperation, closing_speed=speed, closing_spacing=begins, closing_reach=ends)
    faster = generic(Traffic, v_desired=wanted, closing=closing)
    return (
        c_function("contact_spacing", [s, length, L], [contact_spacing(s, one, constants)])
        + c_function("clearance", [s, length, L], [clearances(s, one, constants)])
        + c_function("model_spacing", [s, v, length, time_gap, L], [model_spacing(s, pair, one, constants)])
        + c_function("drag", [s, v_front, v, kappa, kappa_reach, L], [viscosity(s, pair, one, constants)[1]])
        + c_function("closing_share", [s, speed, begins, ends], [closing_speeds(s, closes)[1]])
        + c_function("closing_up", [wanted, closing, v_max], [desired(v, faster, one, constants)[0]])
        + c_function("feed_forward", [v, rate, share, v_max], [feed_forward(v, rate, share, constants)])
    )


def _certificate_kernels() -> str:
    """How long distances last, and a leader that drives itself."""
    c, b, a, v, speed, acceleration, T, v_max = _symbols("c b a v speed acceleration T v_max")
    contact = first_contact(c, b, a)
    leader = DrivenLeader(speed, acceleration)
    return (
        c_function("first_contact", [c, b, a], [contact])
        + _with_tangent("first_contact", [c, b, a], contact)
        + c_function(
            "driven",
            [v, speed, acceleration, T, v_max],
            [driven(v, leader, T, generic(PlatoonParameters, v_max=v_max))],
        )
    )


def _motion_kernels() -> str:
    s, moved_front, moved, v, a, tau = _symbols("s moved_front moved v a tau")
    spacing = spacings_after(s, casadi.vertcat(moved_front, moved))
    speed = advance(s, casadi.vertcat(v, v), casadi.vertcat(a, a), tau)[1][1]
    squares, spacings, dv, da, w1, w2, a_ref, s_ref = _symbols("squares spacings dv da w1 w2 a_ref s_ref")
    weights = generic(ObjectiveWeights, w1=w1, w2=w2, a_ref=a_ref, s_ref=s_ref)
    return (
        c_function("spacing_after", [s, moved_front, moved], [spacing])
        + c_function("speed_after", [v, a, tau], [speed])
        + c_function("travelled", [v, a, tau], [travelled(v, a, tau)])
        + c_function("acceleration_cost", [squares, tau, w1, a_ref], [acceleration_cost(squares, tau, weights)])
        + c_function("spacing_cost", [spacings, dv, da, tau, w2, s_ref], [spacing_cost(spacings, dv, da, tau, weights)])
    )


def _leader_kernels() -> str:
    high, low, cosine = of_wave = _symbols("high low cosine")
    now, later, T = of_speeds = _symbols("now later T")
    of_line = _symbols("time begin end first last")
    return (
        c_function("between", of_wave, [between(high, low, cosine)])
        + c_function("on_line", of_line, [on_line(*of_line)])
        + c_function("held_for", of_speeds, [held_for(now, later, T)])
    )


def kernels_header() -> str:
    """psp_kernels.h: potential, law, Lemma 1, motion, objective and actuators of single spacings and vehicles.

    Returns
    -------
    C source; the same for the same model and CasADi version
    """
    parts = (
        _potential_kernels(),
        _feedback_kernels(),
        _cooperation_kernels(),
        _certificate_kernels(),
        _motion_kernels(),
        actuation_kernels(),
        uncertain_kernels(),
        prediction_kernels(),
        _leader_kernels(),
    )
    return _HEAD + "".join(parts) + "\n#endif\n"
