"""The few array functions that the model uses, for CasADi's column vectors (ours)."""

from __future__ import annotations

from typing import Any

import casadi


def where(condition: Any, yes: Any, no: Any) -> Any:
    """`yes` where `condition` holds, else `no`, element by element; both are evaluated."""
    return casadi.if_else(condition, yes, no)


def maximum(a: Any, b: Any) -> Any:
    """The larger of `a` and `b`, element by element."""
    return casadi.fmax(a, b)


def minimum(a: Any, b: Any) -> Any:
    """The smaller of `a` and `b`, element by element."""
    return casadi.fmin(a, b)


def concat(parts: list[Any]) -> Any:
    """`parts` one below the other; empty ones are left out, as CasADi cuts a scalar to 1 by 0 and not to 0 by 1."""
    return casadi.vertcat(*(part for part in parts if part.numel()))


def sum(vector: Any, axis: int = 0) -> Any:
    """The sum of a column `vector` over the vehicles, its only axis (`axis` is 0)."""
    return casadi.sum1(vector)


def min(vector: Any, axis: int = 0) -> Any:
    """The smallest of a column `vector` over the vehicles, its only axis (`axis` is 0)."""
    return casadi.mmin(vector)


def abs(vector: Any) -> Any:
    """The absolute value of `vector`, element by element."""
    return casadi.fabs(vector)


def sqrt(vector: Any) -> Any:
    """The square root of `vector`, element by element."""
    return casadi.sqrt(vector)


def expm1(vector: Any) -> Any:
    """exp(`vector`) - 1 without cancellation, element by element."""
    return casadi.expm1(vector)


def log(vector: Any) -> Any:
    """The natural logarithm of `vector`, element by element."""
    return casadi.log(vector)
