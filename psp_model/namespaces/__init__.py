"""Which array library an array belongs to, so that the model is written once for NumPy, JAX and CasADi."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""What the equations are annotated with: NumPy's arrays.  JAX arrays and CasADi symbols run through the same functions;
the type checker knows nothing of them."""

Number = float | NDArray[np.float64]
"""A number, or an array that broadcasts with the vehicles."""


def array_namespace(array: Any) -> Any:
    """The namespace (`where`, `maximum`, `sum`, ...) of the library that `array` comes from.

    NumPy and JAX arrays name theirs themselves (Python array API standard); CasADi symbols are served by an adapter;
    plain numbers and lists are NumPy's.
    """
    if isinstance(array, np.ndarray):
        return np
    if hasattr(array, "__array_namespace__"):
        return array.__array_namespace__()
    if type(array).__module__.startswith("casadi"):
        from . import casadi_symbols as casadi_namespace

        return casadi_namespace
    return np


def total(array: Any) -> Any:
    """The sum of `array` over its first axis, which is that of the vehicles."""
    if isinstance(array, np.ndarray):
        return np.add.reduce(array)  # what np.sum calls, several Python calls later
    return array_namespace(array).sum(array, axis=0)


def smallest(array: Any) -> Any:
    """The smallest value of `array` along its first axis, which is that of the vehicles."""
    if isinstance(array, np.ndarray):
        return np.minimum.reduce(array)  # what np.min calls, several Python calls later
    return array_namespace(array).min(array, axis=0)
