"""The whole state of a slave, in memory and as bytes: one way for all slaves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

import numpy as np

from psp_model.sampling.clock import Clock

from .state_check import clock, flag, fresh, record, variables

IN_MEMORY = {"in memory": True}
"""Metadata of fields that bytes leave out: the parameters are fixed, and hold the same values."""


@dataclass(frozen=True, eq=False)
class SlaveState:
    """Everything that a slave's future depends on.

    Attributes
    ----------
    values : the parameters and inputs, in the order of the table
    clock : where the last communication point is
    initialising : whether in initialisation mode
    part : the state of what the parameters describe, None before that exists
    """

    values: tuple[float, ...]
    clock: Clock
    initialising: bool
    part: Any


def as_json(value: Any) -> Any:
    """A state, or a part of one, as JSON, in which every number reads back exactly.

    The launcher adds a checksum and the FMU's identity to it.

    Parameters
    ----------
    value : made of dataclasses, named tuples, sequences, arrays and numbers
    """
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if is_dataclass(value):
        kept = [field.name for field in fields(value) if not field.metadata]
        return {name: as_json(getattr(value, name)) for name in kept}
    if hasattr(value, "_asdict"):
        return {name: as_json(one) for name, one in value._asdict().items()}
    return [as_json(one) for one in value] if isinstance(value, list | tuple) else value


def from_json(
    data: Any, integers: Sequence[bool], restore: Callable[[Any, tuple[float, ...], Clock], Any]
) -> SlaveState:
    """The state that `as_json` wrote, every field of it checked.

    Parameters
    ----------
    data : read from JSON
    integers : for each parameter and input, whether it is an Integer
    restore : makes the part from JSON, for values of parameters and inputs and a clock; checks every field of it

    Raises
    ------
    ValueError : if no run can reach such a state
    """
    state = record(data, [field.name for field in fields(SlaveState)])
    values, here = variables(state["values"], integers), clock(state["clock"])
    if state["part"] is None:
        fresh(here)
    part = None if state["part"] is None else restore(state["part"], values, here)
    return SlaveState(values, here, flag(state["initialising"]), part)
