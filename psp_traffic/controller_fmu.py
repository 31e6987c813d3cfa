"""The controller FMU, driven by fmpy from one sampling instant to the next."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from ctypes import byref, c_double, c_uint32
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


class ControllerFmu:
    """One or more instances of PspController; each has its own vehicles.

    Parameters
    ----------
    fmu : the file
    folder : to unpack it to
    """

    def __init__(self, fmu: Path, folder: Path):
        from fmpy import extract, read_model_description

        self.folder = extract(str(fmu), str(folder))
        self.description = read_model_description(self.folder)
        self.variables = {variable.name: variable for variable in self.description.modelVariables}
        self.capacity = sum(name.startswith("a[") for name in self.variables)

    def references(self, *names: str) -> Any:
        """Value references as fmpy takes them."""
        return (c_uint32 * len(names))(*(self.variables[name].valueReference for name in names))


_LOG = logging.getLogger("psp_traffic")


def _say(environment: Any, name: bytes, status: int, category: bytes, message: bytes) -> None:
    _LOG.log(logging.WARNING if status == 1 else logging.ERROR, "%s: %s", name.decode(), message.decode())


@cache
def _logger() -> Any:
    """One logger for all instances and for good: fmpy's proxy passes all messages to the last one it was shown."""
    from fmpy.fmi2 import fmi2CallbackLoggerTYPE

    return fmi2CallbackLoggerTYPE(_say)


def _callbacks() -> Any:
    """What an instance calls back; its messages go to Python's logging."""
    from fmpy.fmi2 import addLoggerProxy, defaultCallbacks, fmi2CallbackFunctions

    found = fmi2CallbackFunctions()
    found.logger, found.allocateMemory = _logger(), defaultCallbacks.allocateMemory
    found.freeMemory = defaultCallbacks.freeMemory
    addLoggerProxy(byref(found))
    return found


class Platoon:
    """One instance: measured gaps and speeds in, accelerations out.

    Parameters
    ----------
    fmu : the unpacked FMU
    name : of the instance
    parameters : start values by name
    T : sampling period and communication step [s]
    """

    def __init__(self, fmu: ControllerFmu, name: str, parameters: Mapping[str, float], T: float):
        from fmpy.fmi2 import FMU2Slave

        self._callbacks = _callbacks()
        model = fmu.description
        identifier = model.coSimulation.modelIdentifier
        self._slave = FMU2Slave(
            guid=model.guid, unzipDirectory=fmu.folder, modelIdentifier=identifier, instanceName=name
        )
        self._slave.instantiate(callbacks=self._callbacks)
        self._slave.setupExperiment(startTime=0.0)
        n, self.T, self._step = fmu.capacity, T, 0
        for parameter, value in (dict(parameters) | {"T": T}).items():
            variable = fmu.variables[parameter]
            if variable.type == "Integer":
                self._slave.setInteger([variable.valueReference], [int(value)])
            else:
                self._slave.setReal([variable.valueReference], [float(value)])
        self._fmu = fmu
        gaps, speeds = [f"s[{i}]" for i in range(2, n + 1)], [f"v[{i}]" for i in range(1, n + 1)]
        self._inputs = fmu.references(*gaps, *speeds, "n_active", "resolve", "v_desired", "t_measured")
        names = [f"{name}[{i}]" for name in ("a", "saturated") for i in range(1, n + 1)]
        self._outputs = fmu.references(*names, "lemma1_ok", "input_ok")
        self._sent = (c_double * len(self._inputs))()
        self._received = (c_double * len(self._outputs))()
        self.s, self.v = np.full(n - 1, 20.0), np.full(n, 20.0)
        self._started = False
        self.saturated = 0
        self.uncertified_from = self.fault_from = np.inf  # [s]

    def command(self, s: Vector, v: Vector, measured_at: float, v_desired: float = -1.0) -> Vector:
        """Accelerations for the vehicles, from the inputs at this sampling instant.

        Parameters
        ----------
        s, v : (n-1,) gaps [m] and (n,) speeds [m/s]
        measured_at : when [s]
        v_desired : desired speed, below 0 for v_star [m/s]

        Returns
        -------
        (n,) array [m/s2]
        """
        slave, n = self._slave, v.size
        self.s[: n - 1], self.v[:n] = s, v
        if self._started:
            slave.fmi2DoStep(slave.component, self._step * self.T, self.T, 1)
            self._step += 1
        self._sent[:] = [*self.s, *self.v, float(n), 0.0, v_desired, measured_at]
        slave.fmi2SetReal(slave.component, self._inputs, len(self._inputs), self._sent)
        if not self._started:
            slave.enterInitializationMode()
            slave.exitInitializationMode()
            self._started = True
        slave.fmi2GetReal(slave.component, self._outputs, len(self._outputs), self._received)
        capacity = self.v.size
        self.saturated += int(sum(self._received[capacity : capacity + n]))
        time = self._step * self.T
        if not self._received[2 * capacity]:
            self.uncertified_from = min(self.uncertified_from, time)
        if not self._received[2 * capacity + 1]:
            self.fault_from = min(self.fault_from, time)
        return np.array(self._received[:n])

    def reports(self) -> dict[str, float]:
        """What the controller says of itself."""
        names = ("lemma1_violations", "input_faults", "choices", "alpha", "r", "p", "network_in_domain", "T_max")
        values = self._slave.getReal([self._fmu.variables[name].valueReference for name in names])
        own = {"saturated": self.saturated, "uncertified_from": self.uncertified_from, "fault_from": self.fault_from}
        return dict(zip(names, values, strict=True)) | {name: float(value) for name, value in own.items()}

    def close(self) -> None:
        """Free the instance."""
        self._slave.terminate()
        self._slave.freeInstance()
