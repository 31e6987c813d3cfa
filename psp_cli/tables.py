"""Tables for the terminal: plain text, so that they can be piped and pasted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from psp_model.figures import Figure


def figures_table(columns: Mapping[str, Sequence[Figure]]) -> str:
    """A row per figure with its unit, a column per run.

    Parameters
    ----------
    columns : the figures of each run, by its name

    Returns
    -------
    lines of text
    """
    rows = [["", *columns]]
    for line in zip(*columns.values(), strict=True):
        unit = "" if line[0].unit == "1" else f" [{line[0].unit}]"
        rows.append([line[0].label + unit, *(f"{figure.value:.6g}" for figure in line)])
    return aligned(rows)


def as_dict(figures: Sequence[Figure]) -> dict[str, dict[str, str | float]]:
    """The figures of a run for JSON: value and unit by name.

    Parameters
    ----------
    figures : of the run
    """
    return {figure.label: {"value": figure.value, "unit": figure.unit} for figure in figures}


def aligned(rows: Sequence[Sequence[str]]) -> str:
    """Columns of text: the first to the left, the others to the right.

    Parameters
    ----------
    rows : cells
    """
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    lines = (
        "  ".join(
            cell.ljust(width) if i == 0 else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in rows
    )
    return "\n".join(line.rstrip() for line in lines)
