"""FMUs of ours that a command steps by itself, by fmpy."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from psp_model.errors import parts_of
from psp_traffic.messages import callbacks

from .bad_input import BadInput

_WARNING = 1  # fmi2Status


class Instance:
    """One instance of an FMU.

    Parameters
    ----------
    fmu : the file
    folder : to unpack it to

    Attributes
    ----------
    warnings : sentences that it has logged
    """

    def __init__(self, fmu: Path, folder: Path):
        from fmpy import extract, read_model_description
        from fmpy.fmi2 import FMU2Slave

        unpacked = extract(str(fmu), str(folder / fmu.stem))
        model = read_model_description(unpacked)
        self._variables = {variable.name: variable for variable in model.modelVariables}
        self.warnings: list[str] = []
        self._errors: list[str] = []
        self._callbacks = callbacks(fmu.stem, self.hear)
        identifier = model.coSimulation.modelIdentifier
        self._slave = FMU2Slave(
            guid=model.guid, unzipDirectory=unpacked, modelIdentifier=identifier, instanceName=fmu.stem
        )
        self._call("instantiate", callbacks=self._callbacks, loggingOn=True)

    def _call(self, function: str, *arguments: Any, **named: Any) -> Any:
        """A call of fmpy's; BadInput with the FMU's own sentence where it fails."""
        try:
            return getattr(self._slave, function)(*arguments, **named)
        except Exception as error:  # fmpy's own exceptions say which call failed; the FMU's sentence says why
            problem, remedy = parts_of(self._errors[-1] if self._errors else f"{function} failed: {error}")
            raise BadInput(problem, remedy) from None

    def references(self, names: Iterable[str]) -> list[int]:
        """Value references of variables.

        Parameters
        ----------
        names : of the variables
        """
        return [self._variables[name].valueReference for name in names]

    def begin(self, values: Mapping[str, float]) -> None:
        """Set start values, and pass initialisation at time 0.

        Parameters
        ----------
        values : of parameters and inputs, by name; what the FMU does not have is left out

        Raises
        ------
        BadInput : with the FMU's sentence, here and below
        """
        self._call("setupExperiment", startTime=0.0)
        for name, value in values.items():
            variable = self._variables.get(name)
            if variable is None or variable.causality == "output":
                continue
            kind, given = ("setInteger", int(value)) if variable.type == "Integer" else ("setReal", float(value))
            self._call(kind, [variable.valueReference], [given])
        self._call("enterInitializationMode")
        self._call("exitInitializationMode")

    def set(self, references: Sequence[int], values: Sequence[float]) -> None:
        """Set Real inputs.

        Parameters
        ----------
        references, values : of the inputs
        """
        self._call("setReal", references, values)

    def get(self, references: Sequence[int]) -> list[float]:
        """Real outputs.

        Parameters
        ----------
        references : of the outputs
        """
        values: list[float] = self._call("getReal", references)
        return values

    def step(self, time: float, size: float) -> None:
        """Step.

        Parameters
        ----------
        time, size : communication point and step [s]
        """
        self._call("doStep", currentCommunicationPoint=time, communicationStepSize=size)

    def hear(self, status: int, sentence: str) -> None:
        """Take a message of the FMU.

        Parameters
        ----------
        status, sentence : as it logs them
        """
        (self.warnings if status == _WARNING else self._errors).append(sentence)

    def close(self) -> None:
        """Free it, wherever it is."""
        with suppress(Exception):  # fmpy says of a failed step what has been said already
            self._slave.freeInstance()
