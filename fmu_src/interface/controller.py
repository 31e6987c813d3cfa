"""The table of FMI variables of `PspController`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from psp_model.controller import PREDICTED_AGE, ControllerSettings
from psp_model.law.cooperation import Cooperation
from psp_model.parameters import NO_LIMIT

from .platoon import platoon_table
from .variables import Variable

DESCRIPTION = "Commands accelerations to a platoon of vehicles from their measured spacings and speeds"
_OF_THE_PLATOON = ("T", "L", "lambda", "v_star", "v_max", "epsilon", "mu", "z", "w1", "w2", "a_ref", "s_ref")
_CHOICES = ("potential", "parameter_source", "rollout_count")  # Integer: these stand together, as the native FMU has it
_FALLBACK = ("rollout_horizon", "alpha_fixed", "r_fixed", "p_fixed")


def _parameters(n: int, rows: dict[str, Variable]) -> Iterator[Variable]:
    yield from (rows[name] for name in (*_OF_THE_PLATOON, *_CHOICES))
    text = "At a sampling instant at which certificate does not certify T; 1: error, 2: warn and count"
    yield replace(rows["lemma1_policy"], description=text, maximum=2)
    text = "Where inputs are stale, not finite or outside the state space; 1: error, 2: the fail-safe command"
    yield Variable("bad_input", text, start=1, minimum=1, maximum=2, integer=True)
    yield rows["certificate"]
    text = "Whose speed a vehicle takes on; 1: the nearest vehicle ahead that is not automated, 2: its predecessor"
    yield Variable("following", text, start=Cooperation().following, minimum=1, maximum=2, integer=True)
    yield from (rows[name] for name in _FALLBACK)
    text = "Fail-safe acceleration, until standstill; from a_min to 0"
    yield Variable("a_safe", text, "m/s2", ControllerSettings.a_safe, maximum=0, nominal=2)
    text = f"Inputs older than this are stale, above 0; up to {PREDICTED_AGE:g} s vehicles are predicted over that age"
    yield Variable("max_age", text, "s", ControllerSettings.max_age, 0, nominal=1)
    text = "Time of the first sampling instant after the start, from 0 to below T"
    yield Variable("phase", text, "s", 0.0, 0, nominal=0.01)
    yield from _extended_law(rows)
    text = "Bound on the error of measured spacings, for T_max and T_exact"
    yield Variable("error_s", text, "m", 0.0, 0, nominal=0.1)
    text = "Bound on the error of measured speeds, for T_max and T_exact"
    yield Variable("error_v", text, "m/s", 0.0, 0, nominal=0.1)
    text = "Time from a command to its first effect, assumed in prediction"
    yield Variable("actuation_delay", text, "s", 0.0, 0, nominal=0.1)
    for i in range(1, n + 1):
        text = f"Time constant of the actuator of vehicle {i}, assumed in prediction; 0 for none"
        yield Variable(f"actuator_lag[{i}]", text, "s", 0.0, 0, nominal=0.1)
    for i in range(1, n + 1):
        yield Variable(f"length[{i}]", f"Length of vehicle {i}; 0 for L", "m", 0.0, 0, nominal=5)
    for i in range(1, n + 1):
        text = f"Least commanded acceleration of vehicle {i}, below 0; {-NO_LIMIT:g} stands for none"
        yield Variable(f"a_min[{i}]", text, "m/s2", -NO_LIMIT, maximum=0, nominal=5)
    for i in range(1, n + 1):
        text = f"Greatest commanded acceleration of vehicle {i}, above 0; {NO_LIMIT:g} stands for none"
        yield Variable(f"a_max[{i}]", text, "m/s2", NO_LIMIT, 0, nominal=5)


def _extended_law(rows: dict[str, Variable]) -> Iterator[Variable]:
    law = Cooperation()
    yield from (rows[name] for name in ("kappa", "kappa_reach"))
    text = "Clearance per speed that is taken off the spacing before the law is applied"
    yield Variable("time_gap", text, "s", float(law.time_gap), 0, nominal=1)
    text = "Share of the followed vehicle's acceleration that is commanded"
    yield Variable("feedforward", text, "1", float(law.feedforward), 0, 1)
    yield from (rows[f"closing_{name}"] for name in ("speed", "spacing", "reach"))


def _measured(n: int, rows: dict[str, Variable]) -> Iterator[Variable]:
    for i in range(2, n + 1):
        start, text = rows[f"s_start[{i}]"].start, f"Measured spacing between vehicle {i - 1} and vehicle {i}, above L"
        yield Variable(f"s[{i}]", text, "m", start, nominal=10, input=True, continuous=True)
    for i in range(1, n + 1):
        start, text = rows[f"v_start[{i}]"].start, f"Measured speed of vehicle {i}, from 0 to v_max"
        yield Variable(f"v[{i}]", text, "m/s", start, nominal=30, input=True, continuous=True)
    text = f"How many vehicles there are, 1 to {n}, a whole number; alpha, r, p are chosen anew where it changes"
    yield Variable("n_active", text, "1", float(n), 1, n, input=True)
    text = "alpha, r, p are chosen anew where this rises above 0.5"
    yield Variable("resolve", text, "1", 0.0, 0, 1, input=True)
    text = "Desired cruising speed from now on, from 0, to stand, to v_max; v_star if -1 or below"
    yield Variable("v_desired", text, "m/s", -1.0, nominal=30, input=True)
    text = "Time at which spacings and speeds were measured; if below 0, that is when they were last set"
    yield Variable("t_measured", text, "s", -1.0, nominal=100, input=True, continuous=True)
    text = "Derivative of v_desired"
    yield Variable("a_desired", text, "m/s2", 0.0, nominal=1, input=True, continuous=True)
    for i in range(1, n + 1):
        text = f"1 if vehicle {i} is automated; 0 if it drives itself, and others follow it"
        yield Variable(f"automated[{i}]", text, "1", 1.0, 0, 1, input=True)
    for i in range(1, n + 1):
        text = f"Acceleration of vehicle {i}, where it drives itself and communicates that"
        yield Variable(f"a_measured[{i}]", text, "m/s2", 0.0, nominal=1, input=True, continuous=True)
    for i in range(1, n + 1):
        text = f"1 if a_measured[{i}] is communicated, 0 if it is to be estimated from the speed"
        yield Variable(f"a_known[{i}]", text, "1", 1.0, 0, 1, input=True)


def _decided(n: int, rows: dict[str, Variable], known: tuple[str, ...]) -> Iterator[Variable]:
    for i in range(1, n + 1):
        text = f"Acceleration of vehicle {i}, commanded at the last sampling instant and held since"
        yield Variable(f"a[{i}]", text, "m/s2", nominal=1, dependencies=known)
    for i in range(1, n + 1):
        text = (
            f"1 if a_min or a_max cut the command of vehicle {i}, which Lemma 1's argument then does not cover, else 0"
        )
        yield Variable(f"saturated[{i}]", text, minimum=0, maximum=1, dependencies=known)
    yield Variable("alpha", "Scale of the potential in use; 1 with V_old", nominal=1e-3, dependencies=known)
    text = "Where the hill of the potential in use begins; 0 with V_old, which has none"
    yield Variable("r", text, "m", nominal=10, dependencies=known)
    text = "Exponent of the hill in use; 0 with V_old, which has none"
    yield Variable("p", text, nominal=5, dependencies=known)
    yield replace(rows["network_in_domain"], dependencies=known)
    text = "Lemma 1 at the last sampling instant: T is certified if it is below this; 0 with the fail-safe command"
    yield Variable("T_max", text, "s", nominal=0.1, dependencies=known)
    text = "1 if T is below T_max at the last sampling instant, else 0"
    yield Variable("lemma1_ok", text, minimum=0, maximum=1, dependencies=known)
    text = "The exact period at the last sampling instant: the commands held then end in contact or at a speed limit"
    yield Variable("T_exact", text, "s", nominal=1, dependencies=known)
    text = "1 if T is certified at the last sampling instant by what certificate chooses, else 0"
    yield Variable("certified", text, minimum=0, maximum=1, dependencies=known)
    text = "Sampling instants so far at which T was not certified, the fail-safe command aside"
    yield Variable("lemma1_violations", text, minimum=0, dependencies=known)
    text = "1 if the inputs were in order at the last sampling instant, 0 if the fail-safe command is given"
    yield Variable("input_ok", text, minimum=0, maximum=1, dependencies=known)
    yield Variable("input_faults", "Sampling instants so far with the fail-safe command", minimum=0, dependencies=known)
    yield Variable("choices", "How often alpha, r, p were chosen", minimum=0, dependencies=known)
    text = (
        "Largest constant deceleration at which vehicles that are not automated (or, without them, the leader) may "
        "brake to standstill from now on and nobody collides, at most 12"
    )
    yield Variable("brake_margin", text, "m/s2", minimum=0, nominal=5, dependencies=known)
    for i in range(2, n + 1):
        text = f"Spacing between vehicle {i - 1} and vehicle {i} at which the last command was decided"
        yield Variable(f"s_predicted[{i}]", text, "m", nominal=10, dependencies=known)
    for i in range(1, n + 1):
        text = f"Speed of vehicle {i} at which the last command was decided"
        yield Variable(f"v_predicted[{i}]", text, "m/s", nominal=30, dependencies=known)
    for i in range(1, n + 1):
        text = f"Number of the vehicle whose speed vehicle {i} takes on, 0 for none"
        yield Variable(f"followed[{i}]", text, minimum=0, maximum=n, dependencies=known)


def controller_table(capacity: int, default_source: int = 2) -> tuple[Variable, ...]:
    """The variables of `PspController`: parameters, inputs, outputs.

    Parameters
    ----------
    capacity : most vehicles N, at least 2
    default_source : start value of parameter_source; 1 where there are networks

    Returns
    -------
    tuple of Variable (ours)
    """
    rows = {row.name: row for row in platoon_table(capacity, default_source)}
    measured = tuple(_measured(capacity, rows))
    known = tuple(row.name for row in measured)
    return (*_parameters(capacity, rows), *measured, *_decided(capacity, rows, known))
