"""What an FMI variable is: a row of the tables in platoon.py, controller.py, plant.py and leader.py."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Variable:
    """One FMI variable: a row of the table.

    Attributes
    ----------
    name : name in FMI's structured convention
    description : one sentence
    unit : unit, "1" for none
    start : start value of a parameter or input, None for an output
    minimum, maximum, nominal : bounds and typical size, None where there is none
    integer : Integer instead of Real
    continuous : output that varies between sampling instants
    initial_dependencies : names of the parameters that decide an output's initial value; None means all
    input : input instead of parameter
    dependencies : names of the inputs that an output depends on at a communication point
    """

    name: str
    description: str
    unit: str = "1"
    start: float | None = None
    minimum: float | None = None
    maximum: float | None = None
    nominal: float | None = None
    integer: bool = False
    continuous: bool = False
    initial_dependencies: tuple[str, ...] | None = None
    input: bool = False
    dependencies: tuple[str, ...] = ()

    @property
    def causality(self) -> str:
        """FMI causality: a variable with a start value is a parameter or an input."""
        if self.input:
            return "input"
        return "output" if self.start is None else "parameter"

    @property
    def variability(self) -> str:
        """FMI variability."""
        if self.causality == "parameter":
            return "fixed"
        return "continuous" if self.continuous else "discrete"

    @property
    def initial(self) -> str | None:
        """FMI initial; inputs have none."""
        if self.input:
            return None
        return "calculated" if self.start is None else "exact"

    @property
    def fmi_type(self) -> str:
        """FMI type."""
        return "Integer" if self.integer else "Real"
