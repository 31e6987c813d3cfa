"""Several data sets as one to train on: the same problem but for the number of vehicles."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..selection.search.engine import Problem
from ..selection.search.search import Grid
from ..state import StartDomain
from .errors import OfflineError
from .parquet import Dataset
from .structures import Structure

Array = NDArray[Any]


@dataclass(frozen=True)
class Mixture:
    """Data sets to train one network on.

    Attributes
    ----------
    sets : at least one

    Raises
    ------
    OfflineError : where they differ in more than starts and number of vehicles
    """

    sets: tuple[Dataset, ...]

    def __post_init__(self) -> None:
        def kind(data: Dataset) -> object:
            return replace(data.problem, vehicles=2), data.domain, data.effort, data.tables is None

        if any(kind(data) != kind(self.sets[0]) for data in self.sets):
            raise OfflineError(
                "these data sets differ in constants, objective, domain, effort or tables: give data sets that were "
                "made alike but for the number of vehicles, the starts and their seed"
            )

    @property
    def problem(self) -> Problem:
        """What was solved, with the number of vehicles of the first data set."""
        return self.sets[0].problem

    @property
    def domain(self) -> StartDomain:
        """Where the starts come from."""
        return self.sets[0].domain

    @property
    def grid(self) -> Grid:
        """The grid that the tables stand on: it does not depend on the number of vehicles."""
        return self.sets[0].grid

    @property
    def vehicles(self) -> tuple[int, int]:
        """The smallest and the largest number of vehicles."""
        numbers = [data.problem.vehicles for data in self.sets]
        return min(numbers), max(numbers)

    @cached_property
    def triples(self) -> Array:
        """(B, 3) the optima."""
        return np.concatenate([data.triples for data in self.sets])

    @cached_property
    def J(self) -> Array:
        """(B,) at the optima."""
        return np.concatenate([data.J for data in self.sets])

    @property
    def tables(self) -> Array | None:
        """(B, R, P) J on the grid, None where the data sets have none."""
        tables = [data.tables for data in self.sets if data.tables is not None]
        return np.concatenate(tables) if tables else None

    @property
    def sha256(self) -> str:
        """Hashes of the data sets' content, with blanks between them."""
        return " ".join(data.sha256 for data in self.sets)

    def rows(self, structure: Structure) -> Array:
        """What a network of this structure sees of all starts."""
        return np.concatenate([structure.rows(data.starts, self.domain) for data in self.sets])
