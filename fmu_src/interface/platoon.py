"""The one table of FMI variables of `PspPlatoon`; everything that names a variable is derived from it."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import cycle, islice

from psp_model.law.cooperation import Cooperation
from psp_model.law.potential import BEST_FIXED
from psp_model.membership import JoinMargin
from psp_model.objective import HORIZON
from psp_model.parameters import ALPHA_MAX, ALPHA_MIN, P_MAX, P_MIN, ObjectiveWeights, PlatoonParameters
from psp_model.sampling.policy import Sampling
from psp_model.vehicles.braking import MOST

from .variables import Variable

DESCRIPTION = (
    "A platoon of automated vehicles on one lane, under sampled feedback from performance-sensitive potentials"
)
FIRST_SPACINGS = (
    10.0,
    9.4,
    11.2,
    9.0,
    10.6,
    8.8,
)  # [m] start values, repeated down the platoon; inside the paper's ranges
FIRST_SPEEDS = (30.0, 31.5, 28.5, 29.5, 32.0, 28.0, 30.5)  # [m/s] likewise


def _constants() -> Iterator[Variable]:
    c, w = PlatoonParameters(), ObjectiveWeights()
    text = "Sampling period, above 0; certified where below T_max or, with certificate 2, below T_exact"
    yield Variable("T", text, "s", Sampling().T, 0, nominal=0.01)
    yield Variable("L", "Smallest allowable spacing, above 0", "m", c.L, 0, nominal=5)
    yield Variable("lambda", "Spacing at which the repulsion ends, above L + 3 m", "m", c.lam, 0, nominal=20)
    yield Variable("v_star", "Desired cruising speed, above 0 and below v_max", "m/s", c.v_star, 0, nominal=30)
    yield Variable("v_max", "Speed limit, above 0", "m/s", c.v_max, 0, nominal=35)
    yield Variable("epsilon", "Width over which the function f is smoothed, above 0", "m/s2", c.epsilon, 0, nominal=0.2)
    yield Variable("mu", "Smallest feedback gain, above 0", "1/s", c.mu, 0, nominal=0.5)
    yield Variable("z", "Limit of the slope of V_new on its hill, above 0", "m/s2", c.z, 0, nominal=4)
    yield Variable("w1", "Weight of acceleration in J", "1", w.w1, 0, nominal=0.5)
    yield Variable("w2", "Weight of the spacings in J", "1", w.w2, 0, nominal=0.5)
    yield Variable("a_ref", "Scale of acceleration in J, above 0", "m/s2", w.a_ref, 0, nominal=4)
    yield Variable("s_ref", "Scale of the spacings in J, above 0", "m", w.s_ref, 0, nominal=20)


def _choices(n: int, default_source: int) -> Iterator[Variable]:
    def choice(name: str, description: str, start: int, low: int, high: int | None) -> Variable:
        return Variable(name, description, start=start, minimum=low, maximum=high, integer=True)

    yield choice("potential", "1: V_old, 2: V_new", 2, 1, 2)
    text = (
        "Where alpha, r, p come from; 1: the network, from the initial state, 2: alpha_fixed, r_fixed, p_fixed, "
        "3: the network's candidates, rolled out from the initial state; network and rollouts judge by the paper's law"
    )
    yield choice("parameter_source", text, default_source, 1, 3)
    text = (
        "At a sampling instant at which certificate does not certify T; 1: error, 2: warn and count, "
        "3: shorter periods until certified"
    )
    yield choice("lemma1_policy", text, Sampling().policy, 1, 3)
    text = "What certifies T: 1: Lemma 1, T < T_max, 2: the exact period, T < T_exact"
    yield choice("certificate", text, Sampling().certificate, 1, 2)
    text = "Most shortened sampling periods in one communication step with lemma1_policy 3"
    yield choice("max_short_periods", text, Sampling().max_short_periods, 1, None)
    text = "Most rollouts at initialisation with parameter_source 3"
    yield choice("rollout_count", text, 16, 1, 1000)
    text = "How many vehicles there are at the start: the first ones of s_start and v_start"
    yield choice("n_start", text, n, 1, n)
    text = "Horizon of the rollouts with parameter_source 3, above 0"
    yield Variable("rollout_horizon", text, "s", HORIZON, 0, nominal=20)
    text = "alpha with parameter_source 2, and where the network cannot be used"
    yield Variable("alpha_fixed", text, "1", BEST_FIXED.alpha, ALPHA_MIN, ALPHA_MAX, 1e-3)
    text = "r with parameter_source 2, and where the network cannot be used; above L, at most lambda - 3 m"
    yield Variable("r_fixed", text, "m", BEST_FIXED.r, 0, nominal=10)
    text = "p with parameter_source 2, and where the network cannot be used"
    yield Variable("p_fixed", text, "1", BEST_FIXED.p, P_MIN, P_MAX, 5)


def _extended_law(n: int) -> Iterator[Variable]:
    law, none = Cooperation(), JoinMargin()
    yield Variable("kappa", "Viscosity of vehicles at the smallest spacing", "1/s", float(law.kappa), 0, nominal=1)
    text = "Spacing at which viscosity has faded to 0, above L"
    yield Variable("kappa_reach", text, "m", float(law.kappa_reach), 0, nominal=30)
    text = "By how much a vehicle may be faster than its predecessor in order to close up; 0: none closes up"
    yield Variable("closing_speed", text, "m/s", float(law.closing_speed), 0, nominal=1)
    text = "Spacing at which closing up sets in"
    yield Variable("closing_spacing", text, "m", float(law.closing_spacing), 0, nominal=15)
    text = "Spacing at which closing up has faded to 0, above closing_spacing"
    yield Variable("closing_reach", text, "m", float(law.closing_reach), 0, nominal=100)
    text = "Brake margin that the platoon with a joining vehicle must have; 0: not checked"
    yield Variable("join_brake_margin", text, "m/s2", none.brake_margin, 0, MOST, nominal=3)
    text = "What vehicles can brake with, for join_brake_margin, below 0"
    yield Variable("join_a_min", text, "m/s2", none.a_min, maximum=0, nominal=5)
    for i in range(1, n + 1):
        text = f"Length of the vehicle that is at place {i} at the start; 0 for L"
        yield Variable(f"length[{i}]", text, "m", 0.0, 0, nominal=5)


def _starts(n: int) -> Iterator[Variable]:
    yield Variable("x_start", "Initial position of vehicle 1, the leader", "m", 0.0, nominal=100)
    for i, spacing in enumerate(islice(cycle(FIRST_SPACINGS), n - 1), start=2):
        text = f"Initial spacing between vehicle {i - 1} and vehicle {i}, above length[{i - 1}]"
        yield Variable(f"s_start[{i}]", text, "m", spacing, 0, nominal=10)
    for i, speed in enumerate(islice(cycle(FIRST_SPEEDS), n), start=1):
        yield Variable(f"v_start[{i}]", f"Initial speed of vehicle {i}, at most v_max", "m/s", speed, 0, nominal=30)


def _joining(n: int) -> Iterator[Variable]:
    yield Variable("insert", "A vehicle joins where this rises above 0.5", "1", 0.0, 0, 1, input=True)
    text = "Place of the vehicle that the new one joins behind, 1 for the leader; 0: it joins ahead of the leader"
    yield Variable("insert_behind", text, "1", float(n), 0, n, input=True)
    text = "Spacing from the new vehicle to the one it joins behind or, where it becomes the leader, to the old leader"
    yield Variable("insert_gap", text, "m", 20.0, 0, nominal=10, input=True)
    yield Variable("insert_speed", "Speed of the new vehicle, at most v_max", "m/s", 30.0, 0, nominal=30, input=True)
    text = "Length of the new vehicle; 0 for L"
    yield Variable("insert_length", text, "m", 0.0, 0, nominal=5, input=True)
    yield Variable("remove", "A vehicle leaves where this rises above 0.5", "1", 0.0, 0, 1, input=True)
    yield Variable("remove_place", "Place of the vehicle that leaves, 1 for the leader", "1", 1.0, 1, n, input=True)


def _leader() -> Iterator[Variable]:
    text = "1 if vehicle 1 is automated; 0 if it drives itself, and the others follow it"
    yield Variable("leader_automated", text, "1", 1.0, 0, 1, input=True)
    text = "Speed of vehicle 1 where it drives itself, at most v_max"
    yield Variable("leader_speed", text, "m/s", FIRST_SPEEDS[0], 0, nominal=30, input=True, continuous=True)
    text = "Acceleration of vehicle 1 over the next sampling period, where it drives itself"
    yield Variable("leader_acceleration", text, "m/s2", 0.0, nominal=1, input=True, continuous=True)


def _motion(n: int) -> Iterator[Variable]:
    spacings = [f"s_start[{i}]" for i in range(2, n + 1)]
    for i in range(1, n + 1):
        known = ("n_start", "x_start", *spacings[: i - 1])
        text = f"Position of vehicle {i}"
        yield Variable(f"x[{i}]", text, "m", nominal=100, continuous=True, initial_dependencies=known)
    for i in range(1, n + 1):
        known = ("n_start", f"v_start[{i}]")
        text = f"Speed of vehicle {i}"
        yield Variable(f"v[{i}]", text, "m/s", nominal=30, continuous=True, initial_dependencies=known)
    for i in range(1, n + 1):
        text = f"Acceleration of vehicle {i}, commanded at the last sampling instant and held since"
        yield Variable(f"a[{i}]", text, "m/s2", nominal=1)
    for i in range(2, n + 1):
        text = f"Spacing between vehicle {i - 1} and vehicle {i}"
        known = ("n_start", f"s_start[{i}]")
        yield Variable(f"s[{i}]", text, "m", nominal=10, continuous=True, initial_dependencies=known)


def _reports() -> Iterator[Variable]:
    yield Variable("alpha", "Scale of the potential in use; 1 with V_old", nominal=1e-3)
    yield Variable("r", "Where the hill of the potential in use begins; 0 with V_old, which has none", "m", nominal=10)
    yield Variable("p", "Exponent of the hill in use; 0 with V_old, which has none", nominal=5)
    text = "1 if spacings and speeds lay in a network's training domain when alpha, r, p were chosen, else 0"
    yield Variable("network_in_domain", text, minimum=0, maximum=1)
    text = "Lemma 1 at the last sampling instant: T is certified if it is below this"
    yield Variable("T_max", text, "s", nominal=0.1)
    yield Variable("lemma1_ok", "1 if T is below T_max at the last sampling instant, else 0", minimum=0, maximum=1)
    text = "The exact period at the last sampling instant: when vehicles would touch or reach a speed limit"
    yield Variable("T_exact", text, "s", nominal=1)
    text = "1 if T is certified at the last sampling instant by what certificate chooses, else 0"
    yield Variable("certified", text, minimum=0, maximum=1)
    yield Variable("lemma1_violations", "Sampling instants so far at which T was not certified", minimum=0)
    nothing: tuple[str, ...] = ()
    text = "Objective so far, J_acceleration + J_gap"
    yield Variable("J", text, nominal=10, continuous=True, minimum=0, initial_dependencies=nothing)
    text = "Term of the objective so far that stems from acceleration, weighted by w1"
    yield Variable("J_acceleration", text, nominal=1, continuous=True, minimum=0, initial_dependencies=nothing)
    text = "Term of the objective so far that stems from the spacings, weighted by w2"
    yield Variable("J_gap", text, nominal=10, continuous=True, minimum=0, initial_dependencies=nothing)


def _members(n: int) -> Iterator[Variable]:
    nothing: tuple[str, ...] = ()
    start = ("n_start",)
    text = "How many vehicles there are; what belongs to the places behind them is 0"
    yield Variable("n_active", text, minimum=1, maximum=n, initial_dependencies=start)
    for i in range(1, n + 1):
        text = f"Number of the vehicle at place {i}: 1, 2, ... at the start, then in the order of joining; 0: none"
        yield Variable(f"vehicle[{i}]", text, minimum=0, initial_dependencies=start)
    text = "1 if the last change that was asked for was made, or none was, else 0"
    yield Variable("change_ok", text, minimum=0, maximum=1, initial_dependencies=nothing)
    text = "A spacing at which the vehicle that was refused last could have joined, 0 if there was none"
    yield Variable("gap_offered", text, "m", minimum=0, nominal=10, initial_dependencies=nothing)
    yield Variable("changes", "Vehicles that joined or left so far", minimum=0, initial_dependencies=nothing)
    yield Variable("refusals", "Changes refused so far", minimum=0, initial_dependencies=nothing)


_JOIN_MARGIN = ("join_brake_margin", "join_a_min")


def joining_names(vehicles: int) -> set[str]:
    """Names of the variables that only vehicles that join or leave need.

    Parameters
    ----------
    vehicles : most vehicles N
    """
    return {"n_start", *_JOIN_MARGIN, *(row.name for rows in (_joining(vehicles), _members(vehicles)) for row in rows)}


def platoon_table(vehicles: int, default_source: int = 1) -> tuple[Variable, ...]:
    """The variables of `PspPlatoon`: parameters, inputs, outputs; value references are places in the table.

    Parameters
    ----------
    vehicles : most vehicles N, at least 2
    default_source : start value of parameter_source; 2 where there is no network for N vehicles

    Returns
    -------
    tuple of Variable (names and units: the design; rollout_*, max_short_periods, joining and leaving: ours)
    """
    choices = _choices(vehicles, default_source)
    parameters = (_constants(), choices, _extended_law(vehicles), _starts(vehicles))
    groups = (*parameters, _joining(vehicles), _leader(), _motion(vehicles), _reports(), _members(vehicles))
    return tuple(variable for group in groups for variable in group)
