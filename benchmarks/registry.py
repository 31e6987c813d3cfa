"""The measurements: one module each, with a function `measure(context)` that gives the lines of the table."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from .rounds import Row


@dataclass(frozen=True)
class Context:
    """How to measure.

    Attributes
    ----------
    quick : a smoke run: everything runs, the figures mean nothing
    say : shows progress
    peers : folder with the virtual environments of the peers
    """

    quick: bool
    say: Callable[[str], None]
    peers: Path

    def rounds(self, usual: int) -> int:
        """How many rounds."""
        return 1 if self.quick else usual


@dataclass(frozen=True)
class Measurement:
    """One entry.

    Attributes
    ----------
    name : of the module, and of the JSON file
    title : heading of its part of the table
    extra : the extra of the project that it needs, empty where the default install will do
    """

    name: str
    title: str
    extra: str = ""

    def measure(self, context: Context) -> list[Row]:
        """The lines of the table."""
        rows: list[Row] = import_module(f"{__package__}.{self.name}").measure(context)
        return rows


MEASUREMENTS = (
    Measurement("steps", "A step of the FMU", "native"),
    Measurement("model", "A step of the model in NumPy", "native"),
    Measurement("predictor", "A step of the controller that predicts", "native"),
    Measurement("network", "The network", "native"),
    Measurement("first_step", "From loading the FMU to the end of the first step", "native"),
    Measurement("instances", "Many instances in one process", "native"),
    Measurement("car_following", "Car-following on one lane", "sumo"),
    Measurement("search", "The offline search", "offline"),
    Measurement("dataset", "Making a data set", "offline"),
    Measurement("agreement", "Native against Python FMU", "native"),
    Measurement("seeing", "What people look at", "test"),
)
