"""Several starts as one row: means, with the worst in brackets, in Markdown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from .measures import Measures


@dataclass(frozen=True)
class Column:
    """How a measure is shown.

    Attributes
    ----------
    title : with its unit
    digits : after the point
    worst : "max" or "min"
    """

    title: str
    digits: int
    worst: str = "max"


COLUMNS: Mapping[str, Column] = {
    "clearance_min": Column("least clearance [m]", 2, "min"),
    "ttc_min": Column("least TTC [s]", 2, "min"),
    "a_peak": Column("peak a [m/s2]", 2),
    "a_rms": Column("r.m.s. a [m/s2]", 2),
    "jerk_peak": Column("peak jerk [m/s3]", 1),
    "jerk_rms": Column("r.m.s. jerk [m/s3]", 2),
    "capacity": Column("capacity [veh/h]", 0, "min"),
    "spacing_mean": Column("mean spacing [m]", 1),
    "settling": Column("settled after [s]", 1),
    "amplification": Column("amplification", 2),
    "co2": Column("CO2 [g/km]", 1),
    "fuel": Column("fuel [g/km]", 1),
}


def _cell(values: Sequence[float], column: Column) -> str:
    """Mean over the starts that have one, and the worst; "-" where no start has one, "never" means infinite."""
    known = np.array([value for value in values if not np.isnan(value)])
    if not known.size:
        return "-"

    def shown(value: float) -> str:
        return f"{value:.{column.digits}f}" if np.isfinite(value) else "never"

    finite = known[np.isfinite(known)]
    worst = float(known.max() if column.worst == "max" else known.min())
    return shown(float(finite.mean()) if finite.size else np.inf) + (f" ({shown(worst)})" if known.size > 1 else "")


def _collisions(rows: Sequence[Measures]) -> str:
    """Pairs of vehicles that touched in all starts together, and in how many of the starts."""
    hit = sum(row.collisions > 0 for row in rows)
    return f"{sum(row.collisions for row in rows)}" + (f" (in {hit} of {len(rows)})" if hit and len(rows) > 1 else "")


def cells(drivers: Mapping[str, Sequence[Measures]]) -> dict[str, list[str]]:
    """What the table holds: the titles under the empty name, then a line of cells for each driver.

    Parameters
    ----------
    drivers : the starts' measures by name of the driver
    """
    lines = {"": ["collisions", *(column.title for column in COLUMNS.values())]}
    for name, rows in drivers.items():
        shown = [_cell([getattr(row, field) for row in rows], column) for field, column in COLUMNS.items()]
        lines[name] = [_collisions(rows), *shown]
    return lines


def table(drivers: Mapping[str, Sequence[Measures]]) -> str:
    """A Markdown table, one line for each driver: mean and, in brackets, worst of the starts; collisions are totals.

    Parameters
    ----------
    drivers : the starts' measures by name of the driver
    """
    titles, *rows = ([name, *line] for name, line in cells(drivers).items())
    lines = ["| " + " | ".join(line) + " |" for line in (titles, *rows)]
    return "\n".join([lines[0], "|---" * len(titles) + "|", *lines[1:]])
