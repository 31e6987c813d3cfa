"""An FMU of ours, driven through fmpy's thin C binding: statuses and log messages are kept, nothing is hidden."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from ctypes import byref, c_double, c_int, c_uint
from pathlib import Path
from weakref import ref

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave, addLoggerProxy, defaultCallbacks, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE

from psp_model import StartDomain

OK, WARNING, DISCARD, ERROR, FATAL = range(5)


class Unpacked:
    """An FMU on disk, unpacked once for many instances."""

    def __init__(self, path: Path, folder: Path):
        self.path = path
        self.folder = Path(extract(str(path), str(folder)))
        self.description = read_model_description(str(self.folder), validate=False)
        self.reference = {variable.name: variable.valueReference for variable in self.description.modelVariables}
        self.integer = {variable.name for variable in self.description.modelVariables if variable.type == "Integer"}
        self.vehicles = sum(name.startswith("a[") for name in self.reference)


class Instance:
    """One instance; every FMI call returns its status and leaves its messages in `messages`."""

    def __init__(self, fmu: Unpacked, name: str = "platoon", logging: bool = True):
        self.fmu, self.messages = fmu, []
        model = fmu.description
        self.slave = FMU2Slave(
            guid=model.guid,
            unzipDirectory=str(fmu.folder),
            modelIdentifier=model.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.callbacks = fmi2CallbackFunctions()
        me = ref(self)  # tests/conftest.py keeps the logger, which must not keep the instance
        self.callbacks.logger = fmi2CallbackLoggerTYPE(lambda *said: me() and me()._log(*said))
        self.callbacks.allocateMemory = defaultCallbacks.allocateMemory
        self.callbacks.freeMemory = defaultCallbacks.freeMemory
        addLoggerProxy(byref(self.callbacks))  # turns format and arguments into text
        self.slave.instantiate(callbacks=self.callbacks, loggingOn=logging)

    def _log(self, environment, name, status, category, message):
        self.messages.append((status, message.decode()))

    def call(self, function: str, *arguments) -> int:
        """Call an FMI function and return its status instead of raising on errors."""
        try:
            return getattr(self.slave, function)(self.slave.component, *arguments)
        except FMICallException as error:
            return error.status

    def set(self, values: Mapping[str, float]) -> int:
        """Set parameters by name; the worst status comes back."""
        worst = OK
        for name, value in values.items():
            integer = name in self.fmu.integer
            kind, function = (c_int, "fmi2SetInteger") if integer else (c_double, "fmi2SetReal")
            worst = max(worst, self.call(function, byref(c_uint(self.fmu.reference[name])), 1, byref(kind(value))))
        return worst

    def initialise(self, values: Mapping[str, float] | None = None, start_time: float = 0.0) -> int:
        """Set up, set, enter and leave initialisation; the worst status comes back."""
        statuses = [self.call("fmi2SetupExperiment", 0, 0.0, start_time, 0, 0.0), self.set(values or {})]
        statuses.append(self.call("fmi2EnterInitializationMode"))
        statuses.append(self.call("fmi2ExitInitializationMode"))
        return max(statuses)

    def step(self, time: float, size: float) -> int:
        """fmi2DoStep."""
        return self.call("fmi2DoStep", time, size, 1)

    def get(self, *names: str) -> list[float]:
        """Real variables by name."""
        return self.slave.getReal([self.fmu.reference[name] for name in names])

    def group(self, name: str) -> list[float]:
        """All of x, v, a, s and their like, in the order of the vehicles."""
        first = 2 if name in ("s", "clearance") else 1
        return self.get(*(f"{name}[{i}]" for i in range(first, self.fmu.vehicles + 1)))

    def outputs(self) -> list[float]:
        """Every output."""
        return self.get(*(v.name for v in self.fmu.description.modelVariables if v.causality == "output"))

    def close(self) -> None:
        """fmi2FreeInstance; the library stays loaded."""
        self.slave.freeInstance()


def starts(s: Sequence[float], v: Sequence[float]) -> dict[str, float]:
    """Start values by name."""
    named = {f"s_start[{i}]": spacing for i, spacing in enumerate(s, start=2)}
    return named | {f"v_start[{i}]": speed for i, speed in enumerate(v, start=1)}


def random_start(seed: int, vehicles: int = 7) -> tuple[list[float], list[float]]:
    """Spacings and speeds drawn from the paper's ranges."""
    s, v = StartDomain().draw(np.random.default_rng(seed), vehicles, 1)
    return s[:, 0].tolist(), v[:, 0].tolist()


def run(instance: Instance, first: int, count: int, step: float = 0.01) -> list[list[float]]:
    """Outputs after each of `count` steps, the first from time first * step."""
    seen = []
    for k in range(first, first + count):
        assert instance.step(k * step, step) == OK
        seen.append(instance.outputs())
    return seen
