"""The meaning of the variables in the model: the one place where FMI names and the model's structs meet.

Slaves, command line and the files for other tools all use it; the C of the native FMU reads the same names
(PSP_CONSTANTS_FIELDS and its like in psp_model.h, from `variable_names`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from math import isfinite
from typing import Any, TypeVar

import numpy as np

from psp_model.errors import ModelError
from psp_model.law.cooperation import PAPERS_LAW, Cooperation
from psp_model.law.extended import DrivenLeader
from psp_model.law.potential import PotentialParameters
from psp_model.membership import JoinMargin
from psp_model.parameters import Actuation, ObjectiveWeights, PlatoonParameters
from psp_model.quantities import FIELD_NAMES
from psp_model.sampling.policy import Certificate, Lemma1Policy, Sampling
from psp_model.selection.selectors import ParameterSource, Request
from psp_model.state import PlatoonState
from psp_model.validate import validate, validate_start
from psp_model.vehicles.braking import MOST

from .variables import Variable

Struct = TypeVar("Struct")
Read = Callable[[str], float]
"""The value of a variable by its name."""


def variable_names(kind: type[Any]) -> dict[str, str]:
    """FMI names of the fields of a struct whose fields are all variables.

    Parameters
    ----------
    kind : PlatoonParameters or ObjectiveWeights
    """
    return {field.name: FIELD_NAMES.get(field.name, field.name) for field in fields(kind)}


def _struct(kind: type[Struct], read: Read) -> Struct:
    return validate(kind(**{field: read(name) for field, name in variable_names(kind).items()}))


def constants_of(read: Read) -> PlatoonParameters:
    """The constants of the model.

    Parameters
    ----------
    read : value by name

    Raises
    ------
    ModelError : if one is outside the model's domain; the same for the functions below
    """
    return _struct(PlatoonParameters, read)


def weights_of(read: Read) -> ObjectiveWeights:
    """Weights and scales of the objective.

    Parameters
    ----------
    read : value by name
    """
    return _struct(ObjectiveWeights, read)


def choice_of(row: Variable, value: float) -> int:
    """An Integer parameter, checked against the bounds in its row.

    Parameters
    ----------
    row : of the table
    value : of the variable
    """
    chosen, low, high = int(value), int(row.minimum or 0), row.maximum
    if high is None and chosen < low:
        raise ModelError("count", row.name, chosen)
    if high is not None and not low <= chosen <= high:
        raise ModelError("choice", row.name, chosen, low, int(high))
    return chosen


def lengths_of(read: Read, n: int, L: float) -> np.ndarray[tuple[int], np.dtype[np.float64]] | None:
    """The lengths of vehicles, (n,) [m]; None where all are L.

    Parameters
    ----------
    read : value by name; a length of 0 stands for L
    n : vehicles
    L : smallest allowable spacing [m]
    """
    given = np.array([read(f"length[{i}]") for i in range(1, n + 1)])
    lengths = np.where(given == 0.0, L, given)
    return None if (lengths == L).all() else lengths


def cooperation_of(read: Read, rows: Mapping[str, Variable], n: int, L: float) -> Cooperation:
    """The parameters of the extended law; they are checked where the constants are known.

    Parameters
    ----------
    read : value by name
    rows : of the table by name
    n : vehicles
    L : smallest allowable spacing [m]
    """

    def given(name: str) -> float:
        return read(name) if name in rows else float(getattr(Cooperation, name))

    return Cooperation(
        kappa=given("kappa"),
        kappa_reach=given("kappa_reach"),
        time_gap=given("time_gap"),
        feedforward=given("feedforward"),
        following=choice_of(rows["following"], read("following")) if "following" in rows else Cooperation.following,
        closing_speed=given("closing_speed"),
        closing_spacing=given("closing_spacing"),
        closing_reach=given("closing_reach"),
        length=lengths_of(read, n, L),
    )


def actuation_of(read: Read, n: int) -> Actuation:
    """Dead time, lags and limits of vehicles.

    Parameters
    ----------
    read : value by name
    n : vehicles
    """
    lag, least, most = (
        np.array([read(f"{name}[{i}]") for i in range(1, n + 1)]) for name in ("actuator_lag", "a_min", "a_max")
    )
    return Actuation(read("actuation_delay"), lag if lag.any() else 0.0, least, most)


def sampling_of(read: Read, rows: Mapping[str, Variable]) -> Sampling:
    """Sampling period and policy.

    Parameters
    ----------
    read : value by name
    rows : of the table by name; max_short_periods and certificate may be missing
    """
    sampling = Sampling(read("T"), Lemma1Policy(choice_of(rows["lemma1_policy"], read("lemma1_policy"))))
    if "certificate" in rows:
        sampling = replace(sampling, certificate=Certificate(choice_of(rows["certificate"], read("certificate"))))
    if "max_short_periods" in rows:
        most = choice_of(rows["max_short_periods"], read("max_short_periods"))
        sampling = replace(sampling, max_short_periods=most)
    return validate(sampling)


def request_of(read: Read, rows: Mapping[str, Variable]) -> Request:
    """Where alpha, r, p come from.

    Parameters
    ----------
    read : value by name
    rows : of the table by name
    """

    def chosen(name: str) -> int:
        return choice_of(rows[name], read(name))

    request = Request(
        old=chosen("potential") == 1,
        source=ParameterSource(chosen("parameter_source")),
        fixed=PotentialParameters(read("alpha_fixed"), read("r_fixed"), read("p_fixed")),
        rollouts=chosen("rollout_count"),
        horizon=read("rollout_horizon"),
    )
    return request.checked()


def join_margin_of(read: Read) -> JoinMargin:
    """What joining asks for beside the certificate.

    Parameters
    ----------
    read : value by name
    """
    asked = JoinMargin(read("join_brake_margin"), read("join_a_min"))
    for name in ("join_brake_margin", "join_a_min"):
        if not isfinite(read(name)):
            raise ModelError("finite", name, read(name), "m/s2")
    if not 0.0 <= asked.brake_margin <= MOST:
        raise ModelError("join_brake_margin", asked.brake_margin, MOST)
    if not asked.a_min < 0.0:
        raise ModelError("join_a_min", asked.a_min)
    return asked


def leader_of(read: Read, v_max: float) -> DrivenLeader | None:
    """The first vehicle if it drives itself, None where it is automated.

    Parameters
    ----------
    read : value by name
    v_max : speed limit [m/s]
    """
    automated, speed, acceleration = (read(f"leader_{name}") for name in ("automated", "speed", "acceleration"))
    if not isfinite(automated):
        raise ModelError("finite", "leader_automated", automated, "1")
    if automated >= 0.5:
        return None
    for name, value, unit in (("speed", speed, "m/s"), ("acceleration", acceleration, "m/s2")):
        if not isfinite(value):
            raise ModelError("finite", f"leader_{name}", value, unit)
    if not 0.0 <= speed <= v_max:
        raise ModelError("leader_speed", speed, v_max)
    return DrivenLeader(speed, acceleration)


def start_of(read: Read, n: int, constants: PlatoonParameters, cooperation: Cooperation = PAPERS_LAW) -> PlatoonState:
    """The initial state of the first n vehicles.

    Parameters
    ----------
    read : value by name
    n : vehicles
    constants : of the model
    cooperation : with their lengths
    """
    s, v = [read(f"s_start[{i}]") for i in range(2, n + 1)], [read(f"v_start[{i}]") for i in range(1, n + 1)]
    return validate_start(PlatoonState(s, v, constants, read("x_start")), cooperation)
