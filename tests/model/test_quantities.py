"""Units stand once: structs, their docstrings, FMI variables and figures say the same as the table of quantities."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any

import pytest

from fmu_src.interface.controller import controller_table
from fmu_src.interface.leader import leader_table
from fmu_src.interface.plant import plant_table
from fmu_src.interface.platoon import platoon_table
from fmu_src.interface.variables import Variable
from psp_model import (
    Actuation,
    Cooperation,
    Errors,
    ObjectiveWeights,
    PlatoonParameters,
    PlatoonState,
    PotentialParameters,
    Sampling,
    simulate,
)
from psp_model.law.watching import Watched
from psp_model.platoon import Observation
from psp_model.quantities import FIELD_NAMES, QUANTITIES, quantity_of
from psp_model.sampling.hold import Motion

STRUCTS = (PlatoonParameters, ObjectiveWeights, PotentialParameters, Sampling, Cooperation, Actuation, Errors)
STATES = (PlatoonState, Motion, Observation)
NO_QUANTITIES = {
    "hill": "a switch",
    "policy": "a choice",
    "max_short_periods": "a count",
    "following": "a choice",
    "certificate": "a choice",
    "constants": "a struct",
    "cost": "two terms of J",
    "x_leader": "x of vehicle 1",
}
LIKE = {
    "insert_gap": "s",
    "gap_offered": "s",
    "insert_speed": "v",
    "v_desired": "v",
    "insert_length": "length",
    "join_brake_margin": "a",
    "join_a_min": "a",
    "leader_speed": "v",
    "leader_acceleration": "a",
    "v_high": "v",
    "v_low": "v",
    "clearance": "s",
    "acceleration": "a",
    "a_safe": "a",
    "a_desired": "a",
    "brake_margin": "a",
    "T_exact": "T",
    "rollout_horizon": "T",
    "max_age": "T",
    "phase": "T",
    "t_measured": "T",
    "begin": "T",
    "period": "T",
    "J_acceleration": "J",
    "J_gap": "J",
}
"""Variables with a name of their own, and the quantity that they are; what else has none is a count or a flag."""


def names_of(struct: Any) -> list[str]:
    return [field.name for field in fields(struct)] if is_dataclass(struct) else list(struct._fields)


def attributes(struct: Any) -> Iterator[tuple[str, str]]:
    """Names and descriptions in the docstring of a struct."""
    text = re.sub(r"\n {8}", " ", (struct.__doc__ or "").partition("Attributes\n")[2])
    for names, description in re.findall(r"^ {4}(\w[\w, ]*) : (.+)$", text, re.MULTILINE):
        yield from ((name.strip(), description) for name in names.split(","))


def tables() -> Iterator[Variable]:
    for table in (platoon_table(7, 1), controller_table(7), plant_table(7), leader_table()):
        yield from table


@pytest.mark.parametrize("struct", [*STRUCTS, *STATES], ids=lambda one: one.__name__)
def test_every_field_of_the_model_s_structs_is_a_quantity_or_says_why_not(struct: Any) -> None:
    for name in names_of(struct):
        assert (name in NO_QUANTITIES) != (FIELD_NAMES.get(name, name) in QUANTITIES), name


@pytest.mark.parametrize("struct", [*STRUCTS, PlatoonState, Motion, Watched], ids=lambda one: one.__name__)
def test_docstrings_give_the_units_of_the_table(struct: Any) -> None:
    described = dict(attributes(struct))
    assert described.keys() == set(names_of(struct))
    for name, description in described.items():
        units = re.findall(r"\[([\w/]+)\]", description)
        if name in NO_QUANTITIES or struct is Watched:
            continue
        if units:
            place = [one.strip() for one in _group(struct, name)].index(name) if len(units) > 1 else 0
            assert units[place] == quantity_of(name).unit, name
        else:
            assert struct in (PotentialParameters, ObjectiveWeights), f"{name} says no unit"


def _group(struct: Any, name: str) -> list[str]:
    """The names that stand before one description together."""
    found = re.search(rf"^ {{4}}((?:\w+, )*{name}(?:, \w+)*) :", struct.__doc__, re.MULTILINE)
    assert found
    return found[1].split(",")


def test_variables_have_the_units_of_the_table() -> None:
    counted = 0
    for variable in tables():
        base = variable.name.partition("[")[0]
        try:
            quantity = quantity_of(variable.name)
        except KeyError:
            expected = QUANTITIES[LIKE[base]].unit if base in LIKE else "1"
            assert variable.unit == expected, variable.name
            continue
        assert base not in LIKE and variable.unit == quantity.unit, variable.name
        counted += 1
    assert counted > 100


def test_every_numbered_variable_is_a_quantity_or_a_flag() -> None:
    numbered = {variable.name.partition("[")[0] for variable in tables() if "[" in variable.name}
    without = {name for name in numbered if name not in QUANTITIES and not name.endswith("_start")}
    without -= {name for name in without if name.endswith(("_measured", "_predicted"))}
    assert (
        without == {"vehicle", "saturated", "automated", "a_known", "followed", "clearance", "acceleration"}
        and {"x", "s", "v", "a", "s_start", "v_start"} <= numbered
    )


@pytest.mark.parametrize(
    ("name", "quantity"),
    [("lam", "lambda"), ("s[12]", "s"), ("v_start[3]", "v"), ("x_start", "x"), ("p_fixed", "p"), ("v_star", "v_star")],
)
def test_a_field_or_variable_finds_its_quantity(name: str, quantity: str) -> None:
    assert quantity_of(name) is QUANTITIES[quantity] and quantity_of(name).name == quantity


def test_what_is_no_quantity_has_none() -> None:
    for name in ("hill", "vehicle[1]", "", "lambda_"):
        with pytest.raises(KeyError):
            quantity_of(name)


def test_names_are_given_once_and_units_are_si() -> None:
    assert len({quantity.symbol for quantity in QUANTITIES.values()}) == len(QUANTITIES)
    assert {quantity.unit for quantity in QUANTITIES.values()} == {"1", "m", "s", "m/s", "m/s2", "1/s"}
    assert all(quantity.meaning and quantity.name == name for name, quantity in QUANTITIES.items())


def test_figures_of_a_run_have_units_of_the_table() -> None:
    run = simulate(([9.0], [30.0, 30.0]), "fixed", duration=0.1)
    units = {quantity.unit for quantity in QUANTITIES.values()}
    assert {figure.unit.replace("²", "2") for figure in run.figures()} <= units
