"""The controller FMU, driven by fmpy from one sampling instant to the next."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from ctypes import c_double, c_int, c_size_t, c_uint32, c_void_p
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import TrafficError
from .messages import callbacks

Vector = NDArray[np.float64]

_OTHERS = ("n_active", "resolve", "v_desired", "t_measured")  # inputs after spacings and speeds
_WARNING = 1  # the worst fmi2Status of a successful call


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
        n = self.capacity = sum(name.startswith("a[") for name in self.variables)
        spacings, speeds = [f"s[{i}]" for i in range(2, n + 1)], [f"v[{i}]" for i in range(1, n + 1)]
        self.inputs = (*spacings, *speeds, *_OTHERS)
        named = (f"{name}[{i}]" for name in ("a", "saturated") for i in range(1, n + 1))
        self.outputs = (*named, "lemma1_ok", "input_ok")
        self.resting = np.array([float(self.variables[name].start) for name in self.inputs])  # start values

    def require_room(self, vehicles: int) -> None:
        """Check that this many vehicles fit.

        Parameters
        ----------
        vehicles : n

        Raises
        ------
        TrafficError : where they do not
        """
        if vehicles > self.capacity:
            raise TrafficError(
                f"{vehicles} vehicles do not fit: this controller is for {self.capacity} at most, build one for "
                f"{vehicles}"
            )

    def elements(self, name: str) -> list[str]:
        """The variable of that name or, where each vehicle has one of its own, all of theirs.

        Parameters
        ----------
        name : with or without an index
        """
        return [name] if name in self.variables else [f"{name}[{i}]" for i in range(1, self.capacity + 1)]

    def references(self, *names: str) -> Any:
        """Value references as fmpy takes them."""
        return (c_uint32 * len(names))(*(self.variables[name].valueReference for name in names))


_LOG = logging.getLogger("psp_traffic")


def _log(name: str, status: int, sentence: str) -> None:
    """A message of an instance goes to Python's logging."""
    _LOG.log(logging.WARNING if status == 1 else logging.ERROR, "%s: %s", name, sentence)


class Platoon:
    """One instance: measured spacings and speeds in, accelerations out.

    Parameters
    ----------
    fmu : the unpacked FMU
    name : of the instance
    parameters : start values by name; without an index for all vehicles
    T : sampling period and communication step [s]
    inputs, outputs : where to keep them, as long as `fmu.inputs` and `fmu.outputs`; arrays of its own if not given
    """

    def __init__(
        self,
        fmu: ControllerFmu,
        name: str,
        parameters: Mapping[str, float],
        T: float,
        inputs: Vector | None = None,
        outputs: Vector | None = None,
    ):
        from fmpy.fmi2 import FMU2Slave

        self._callbacks = callbacks(name, partial(_log, name))
        model = fmu.description
        identifier = model.coSimulation.modelIdentifier
        self._slave = FMU2Slave(
            guid=model.guid, unzipDirectory=fmu.folder, modelIdentifier=identifier, instanceName=name
        )
        self._slave.instantiate(callbacks=self._callbacks, loggingOn=True)  # otherwise it logs errors only
        self._slave.setupExperiment(startTime=0.0)
        given = {one: value for name, value in (dict(parameters) | {"T": T}).items() for one in fmu.elements(name)}
        for parameter, value in given.items():
            variable = fmu.variables[parameter]
            if variable.type == "Integer":
                self._slave.setInteger([variable.valueReference], [int(value)])
            else:
                self._slave.setReal([variable.valueReference], [float(value)])
        self._fmu, self._name, self.T, self._step = fmu, name, T, 0
        self.inputs = np.zeros(len(fmu.inputs)) if inputs is None else inputs
        self.outputs = np.zeros(len(fmu.outputs)) if outputs is None else outputs
        self.inputs[:] = fmu.resting
        self._bind()
        self._started = False
        self.saturated = 0
        self.uncertified_from = self.fault_from = np.inf  # [s]

    def _bind(self) -> None:
        """The three calls of a step with their arguments made once: fmpy's own calls cost more than the controller."""
        fmu, dll, component = self._fmu, self._slave.dll, c_void_p(self._slave.component)
        self._now = c_double(0.0)

        def bound(function: str, *arguments: Any) -> Callable[[], int]:
            return partial(dll[function], component, *arguments)

        def all_of(names: Sequence[str], values: Vector) -> tuple[Any, Any, Any]:
            return fmu.references(*names), c_size_t(len(names)), values.ctypes.data_as(c_void_p)

        self._do_step = bound("fmi2DoStep", self._now, c_double(self.T), c_int(1))
        self._set_inputs = bound("fmi2SetReal", *all_of(fmu.inputs, self.inputs))
        self._get_outputs = bound("fmi2GetReal", *all_of(fmu.outputs, self.outputs))

    def _fail(self, function: str, status: int) -> None:
        time = self._step * self.T
        raise TrafficError(f"{function} of {self._name} failed with status {status} at t = {time:g} s: see its message")

    def decide(self) -> None:
        """Hand `inputs` over at a sampling instant, step to the next, fetch `outputs`: the command computed there.

        Set, step, get is the order that FMI 2.0 (4.2.4) allows; get before step is not.

        Raises
        ------
        TrafficError : where the FMU fails; its message has gone to Python's logging
        """
        if (status := self._set_inputs()) > _WARNING:
            self._fail("fmi2SetReal", status)
        if not self._started:
            self._slave.enterInitializationMode()
            self._slave.exitInitializationMode()
            self._started = True
        self._now.value = self._step * self.T
        if (status := self._do_step()) > _WARNING:
            self._fail("fmi2DoStep", status)
        if (status := self._get_outputs()) > _WARNING:
            self._fail("fmi2GetReal", status)
        self._step += 1

    def command(self, s: Vector, v: Vector, measured_at: float, v_desired: float = -1.0) -> Vector:
        """Accelerations for the vehicles, from the inputs at this sampling instant.

        Parameters
        ----------
        s, v : (n-1,) spacings [m] and (n,) speeds [m/s]
        measured_at : when [s]
        v_desired : desired speed, below 0 for v_star [m/s]

        Returns
        -------
        (n,) array [m/s2]
        """
        capacity, n = self._fmu.capacity, v.size
        self._fmu.require_room(n)
        self.inputs[: n - 1], self.inputs[capacity - 1 : capacity - 1 + n] = s, v
        self.inputs[-len(_OTHERS) :] = n, 0.0, v_desired, measured_at
        self.decide()
        self.saturated += int(self.outputs[capacity : capacity + n].sum())
        time = (self._step - 1) * self.T  # of the instant
        if not self.outputs[2 * capacity]:
            self.uncertified_from = min(self.uncertified_from, time)
        if not self.outputs[2 * capacity + 1]:
            self.fault_from = min(self.fault_from, time)
        return self.outputs[:n].copy()

    def reports(self) -> dict[str, float]:
        """The figures reported by the controller."""
        names = ("lemma1_violations", "input_faults", "choices", "alpha", "r", "p", "network_in_domain", "T_max")
        values = self._slave.getReal([self._fmu.variables[name].valueReference for name in names])
        own = {"saturated": self.saturated, "uncertified_from": self.uncertified_from, "fault_from": self.fault_from}
        return dict(zip(names, values, strict=True)) | {name: float(value) for name, value in own.items()}

    def close(self) -> None:
        """Free the instance."""
        self._slave.terminate()
        self._slave.freeInstance()


class Fleet:
    """Platoons of equal size with an instance each; inputs and outputs are rows of two matrices.

    Parameters
    ----------
    fmu : the unpacked FMU
    platoons : how many
    parameters : start values by name; without an index for all vehicles
    T : sampling period and communication step [s]
    """

    def __init__(self, fmu: ControllerFmu, platoons: int, parameters: Mapping[str, float], T: float):
        self._fmu = fmu
        self._inputs = np.zeros((platoons, len(fmu.inputs)))
        self._outputs = np.zeros((platoons, len(fmu.outputs)))
        rows = zip(self._inputs, self._outputs, strict=True)
        self._platoons = [
            Platoon(fmu, f"platoon{k}", parameters, T, inputs, outputs) for k, (inputs, outputs) in enumerate(rows)
        ]

    def command(self, s: Vector, v: Vector, measured_at: float) -> Vector:
        """Accelerations for the vehicles of all platoons.

        Parameters
        ----------
        s, v : (K, n-1) spacings [m] and (K, n) speeds [m/s] of K platoons
        measured_at : when [s]

        Returns
        -------
        (K, n) array [m/s2]
        """
        before, n = self._fmu.capacity - 1, v.shape[1]
        self._fmu.require_room(n)
        self._inputs[:, : n - 1], self._inputs[:, before : before + n] = s, v
        self._inputs[:, -len(_OTHERS) :] = n, 0.0, -1.0, measured_at
        for platoon in self._platoons:
            platoon.decide()
        return self._outputs[:, :n].copy()

    def close(self) -> None:
        """Free the instances."""
        for platoon in self._platoons:
            platoon.close()
