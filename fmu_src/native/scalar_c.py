"""A CasADi function of numbers as a C function of numbers, from its instructions (`casadi.Function.instruction_id`).

CasADi itself writes functions over arrays of pointers.  A static inline function that takes and returns numbers can be
merged into the loop over the vehicles by the compiler: the cost per vehicle is the same however many there are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isinf
from typing import Any

import casadi

from ..errors import BuildError

Symbols = Sequence[Any]

_OPERATIONS = {  # {0} and {1} are names or constants
    casadi.OP_ADD: "({0} + {1})",
    casadi.OP_SUB: "({0} - {1})",
    casadi.OP_MUL: "({0} * {1})",
    casadi.OP_DIV: "({0} / {1})",
    casadi.OP_NEG: "(-{0})",
    casadi.OP_LOG: "log({0})",
    casadi.OP_EXP: "exp({0})",
    casadi.OP_EXPM1: "expm1({0})",
    casadi.OP_POW: "pow({0}, {1})",
    casadi.OP_CONSTPOW: "pow({0}, {1})",
    casadi.OP_SQRT: "sqrt({0})",
    casadi.OP_SQ: "({0} * {0})",
    casadi.OP_TWICE: "(2.0 * {0})",
    casadi.OP_INV: "(1.0 / {0})",
    casadi.OP_LT: "({0} < {1})",
    casadi.OP_LE: "({0} <= {1})",
    casadi.OP_EQ: "({0} == {1})",
    casadi.OP_NE: "({0} != {1})",
    casadi.OP_NOT: "(!{0})",
    casadi.OP_AND: "({0} && {1})",
    casadi.OP_OR: "({0} || {1})",
    casadi.OP_FABS: "fabs({0})",
    casadi.OP_SIGN: "({0} < 0.0 ? -1.0 : {0} > 0.0 ? 1.0 : 0.0)",
    casadi.OP_FMIN: "({0} < {1} ? {0} : {1})",
    casadi.OP_FMAX: "({0} > {1} ? {0} : {1})",
    casadi.OP_IF_ELSE_ZERO: "({0} ? {1} : 0.0)",
}


@dataclass(frozen=True)
class _Step:
    """One instruction, whose result has a place of its own.

    Attributes
    ----------
    operation : CasADi's number for it; None for a choice between two values
    operands : places of what it is computed from
    text : of a constant or an input
    """

    operation: int | None
    operands: tuple[int, ...] = ()
    text: str = ""

    def written(self, names: Sequence[str]) -> str:
        """The expression in C, its operands by their names."""
        operands = [names[place] for place in self.operands]
        if self.operation is None:
            return "({} ? {} : {})".format(*operands)
        return _OPERATIONS[self.operation].format(*operands)


def _steps(function: Any, names: Sequence[str]) -> tuple[list[_Step], list[int]]:
    """The instructions of a function, and the places of its results."""
    steps: list[_Step] = []
    at: dict[int, int] = {}  # where the value that a work variable of CasADi's holds was computed
    results = [-1] * function.n_out()
    for number in range(function.n_instructions()):
        operation, given = function.instruction_id(number), function.instruction_input(number)
        taken = function.instruction_output(number)
        if operation == casadi.OP_OUTPUT:
            results[taken[0]] = at[given[0]]
            continue
        if operation == casadi.OP_CONST:
            step = _Step(operation, text=_constant(function.instruction_constant(number)))
        elif operation == casadi.OP_INPUT:
            step = _Step(operation, text=names[given[0]])
        elif operation in _OPERATIONS:
            step = _Step(operation, tuple(at[work] for work in given))
        else:
            raise BuildError(
                f"CasADi's operation {operation} is not known here",
                "install the CasADi that psp-platoon[native] asks for, or add it to fmu_src/native/scalar_c.py",
            )
        at[taken[0]] = len(steps)
        steps.append(step)
    return steps, results


def _constant(value: float) -> str:
    if isinf(value):
        return "INFINITY" if value > 0 else "(-INFINITY)"
    return repr(float(value)) if value >= 0 else f"({float(value)!r})"


def _with_choices(steps: Sequence[_Step]) -> list[_Step]:
    """(c ? x : 0) + (!c ? y : 0), which is what CasADi makes of a choice, as (c ? x : y)."""

    def chosen(step: _Step) -> _Step:
        terms = [steps[place] for place in step.operands]
        if step.operation != casadi.OP_ADD or any(term.operation != casadi.OP_IF_ELSE_ZERO for term in terms):
            return step
        (condition, x), (otherwise, y) = (term.operands for term in terms)
        opposite = steps[otherwise].operation == casadi.OP_NOT and steps[otherwise].operands == (condition,)
        return _Step(None, (condition, x, y)) if opposite else step

    return [chosen(step) for step in steps]


def _needed(steps: Sequence[_Step], results: Sequence[int]) -> set[int]:
    """Places of what the results depend on."""
    found: set[int] = set()
    waiting = list(results)
    while waiting:
        place = waiting.pop()
        if place not in found:
            found.add(place)
            waiting += steps[place].operands
    return found


def c_function(name: str, inputs: Symbols, outputs: Symbols) -> str:
    """A static inline function in C: a number per input; the result is returned, several are put into pointers.

    Parameters
    ----------
    name : what is behind psp_
    inputs : scalar symbols
    outputs : scalar expressions of them

    Raises
    ------
    BuildError : where an expression needs an operation that is not known here
    """
    function = casadi.Function(name, list(inputs), list(outputs))
    arguments = [symbol.name() for symbol in inputs]
    steps, results = _steps(function, arguments)
    steps = _with_choices(steps)
    needed, names = _needed(steps, results), [""] * len(steps)
    lines: list[str] = []
    for place, step in enumerate(steps):
        if step.text:
            names[place] = step.text
        elif place in needed:
            names[place] = f"t{len(lines)}"
            lines.append(f"const double {names[place]} = {step.written(names)};")
    several = len(results) > 1
    lines += [f"{f'*out_{k} =' if several else 'return'} {names[place]};" for k, place in enumerate(results)]
    parameters = [f"double {argument}" for argument in arguments]
    parameters += [f"double *out_{k}" for k in range(len(results))] if several else []
    body, kind = "\n    ".join(lines), "void" if several else "double"
    return f"\nstatic inline {kind} psp_{name}({', '.join(parameters)})\n{{\n    {body}\n}}\n"
