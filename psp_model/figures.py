"""The numbers that a run is judged by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Figure:
    """One number a run is judged by.

    Attributes
    ----------
    label : what it is
    unit : its unit, "1" for none
    value : the number, SI
    """

    label: str
    unit: str
    value: float


def figures_table(title: str, figures: Sequence[Figure]) -> str:
    """Figures as text, one to a line below a title.

    Parameters
    ----------
    title : first line
    figures : the numbers
    """
    width = max(len(figure.label) for figure in figures)
    rows = (f"  {figure.label:<{width}}  {figure.value:.4g}{_suffix(figure.unit)}" for figure in figures)
    return "\n".join([title, *rows])


def warned(warnings: Sequence[str]) -> list[str]:
    """The first of some warnings as text below a table, and how many more there are.

    Parameters
    ----------
    warnings : sentences
    """
    more = f" (and {len(warnings) - 1} more)" if len(warnings) > 1 else ""
    return [f"  warning: {warnings[0]}{more}"] if warnings else []


def _suffix(unit: str) -> str:
    return "" if unit == "1" else f" {unit}"


def smallest(values: NDArray[np.float64]) -> float:
    """The smallest of some numbers, NaN where there are none: a lone vehicle has no spacing.

    Parameters
    ----------
    values : array of any shape
    """
    return float(values.min()) if values.size else float("nan")


def largest(values: NDArray[np.float64]) -> float:
    """The largest of some numbers, NaN where there are none.

    Parameters
    ----------
    values : array of any shape
    """
    return float(values.max()) if values.size else float("nan")
