"""An FMU's functions through bare ctypes: nothing between the caller and the library."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from ctypes import POINTER, byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from typing import Any

from harness import Unpacked

OK, WARNING, DISCARD, ERROR, FATAL = range(5)

_LOGGER = ctypes.CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)  # no arguments follow the format


class Callbacks(ctypes.Structure):
    """fmi2CallbackFunctions."""

    _fields_ = (
        ("logger", _LOGGER),
        ("allocateMemory", c_void_p),
        ("freeMemory", c_void_p),
        ("stepFinished", c_void_p),
        ("componentEnvironment", c_void_p),
    )


_VARIABLES = (c_void_p, c_void_p, c_size_t, c_void_p)
_STATE = (c_void_p, c_void_p)
ARGUMENTS: dict[str, Sequence[Any]] = {
    "SetDebugLogging": (c_void_p, c_int, c_size_t, c_void_p),
    "SetupExperiment": (c_void_p, c_int, c_double, c_double, c_int, c_double),
    **{name: (c_void_p,) for name in ("EnterInitializationMode", "ExitInitializationMode", "Terminate", "Reset")},
    **{f"{how}{kind}": _VARIABLES for how in ("Get", "Set") for kind in ("Real", "Integer", "Boolean", "String")},
    **{f"{how}FMUstate": _STATE for how in ("Get", "Set", "Free")},
    "SerializedFMUstateSize": (c_void_p, c_void_p, c_void_p),
    "SerializeFMUstate": (c_void_p, c_void_p, c_void_p, c_size_t),
    "DeSerializeFMUstate": (c_void_p, c_void_p, c_size_t, c_void_p),
    "GetDirectionalDerivative": (c_void_p, c_void_p, c_size_t, c_void_p, c_size_t, c_void_p, c_void_p),
    "SetRealInputDerivatives": (c_void_p, c_void_p, c_size_t, c_void_p, c_void_p),
    "GetRealOutputDerivatives": (c_void_p, c_void_p, c_size_t, c_void_p, c_void_p),
    "DoStep": (c_void_p, c_double, c_double, c_int),
    "CancelStep": (c_void_p,),
    **{f"Get{kind}Status": (c_void_p, c_int, c_void_p) for kind in ("", "Real", "Integer", "Boolean", "String")},
}


class Library:
    """The functions of an FMU, with their types.

    Parameters
    ----------
    fmu : unpacked
    """

    def __init__(self, fmu: Unpacked):
        self.fmu = fmu
        model = fmu.description.coSimulation.modelIdentifier
        self.functions = ctypes.CDLL(str(fmu.folder / "binaries" / "linux64" / f"{model}.so"))
        for name, arguments in ARGUMENTS.items():
            function = getattr(self.functions, f"fmi2{name}")
            function.argtypes, function.restype = arguments, c_int
        self.functions.fmi2Instantiate.restype = c_void_p
        self.functions.fmi2Instantiate.argtypes = (c_char_p, c_int, c_char_p, c_char_p, c_void_p, c_int, c_int)
        self.functions.fmi2FreeInstance.argtypes, self.functions.fmi2FreeInstance.restype = (c_void_p,), None
        variables = fmu.description.modelVariables
        self.outputs = [v.valueReference for v in variables if v.causality == "output"]
        self.reals = [v.valueReference for v in variables if v.type == "Real"]
        self.settable = [v.valueReference for v in variables if v.causality in ("parameter", "input")]
        self.integers = [v.valueReference for v in variables if v.type == "Integer"]


class Raw:
    """One instance; `messages` holds what it logged since it was last emptied.

    Parameters
    ----------
    library : of the FMU
    name : of the instance
    """

    def __init__(self, library: Library, name: str = "raw"):
        self.library, self.messages = library, list[str]()
        self.callbacks = Callbacks(logger=_LOGGER(self._log))
        description = library.fmu.description
        resources = (library.fmu.folder / "resources").as_uri().encode()
        self.component = library.functions.fmi2Instantiate(
            name.encode(), 1, description.guid.encode(), resources, byref(self.callbacks), 0, 1
        )
        if not self.component:
            raise RuntimeError(f"no instance: {self.messages}")

    def _log(self, environment: Any, name: Any, status: int, category: Any, form: bytes) -> None:
        self.messages.append(form.replace(b"%%", b"%").decode())

    def call(self, function: str, *arguments: Any) -> int:
        """An FMI function by its name without fmi2."""
        return int(getattr(self.library.functions, f"fmi2{function}")(self.component, *arguments))

    def free(self) -> None:
        """fmi2FreeInstance."""
        self.library.functions.fmi2FreeInstance(self.component)
        self.component = None

    def set_reals(self, references: Sequence[int], values: Sequence[float]) -> int:
        """Real variables by reference."""
        count = len(references)
        return self.call("SetReal", (c_uint * count)(*references), count, (c_double * count)(*values))

    def set_integer(self, reference: int, value: int) -> int:
        """One Integer variable."""
        return self.call("SetInteger", byref(c_uint(reference)), 1, byref(c_int(value)))

    def start(self) -> int:
        """Initialise as a well-behaved host does; the worst status."""
        statuses = [self.call("SetupExperiment", 0, 0.0, 0.0, 0, 0.0)]
        return max([*statuses, self.call("EnterInitializationMode"), self.call("ExitInitializationMode")])

    def outputs(self) -> tuple[float, ...]:
        """Every output; empty where they cannot be read."""
        count = len(self.library.outputs)
        values = (c_double * count)()
        status = self.call("GetReal", (c_uint * count)(*self.library.outputs), count, values)
        return tuple(values) if status <= WARNING else ()

    def usual_run(self, steps: int = 5) -> list[tuple[float, ...]]:
        """What a fresh or reset instance puts out over its first steps; empty where a call fails."""
        if self.start() > WARNING:
            return []
        seen = [self.outputs()]
        for k in range(steps):
            if self.call("DoStep", 0.01 * k, 0.01, 1) > WARNING:
                return []
            seen.append(self.outputs())
        return seen


def pointer_to(value: Any) -> Any:
    """The address of a ctypes value."""
    return POINTER(type(value))(value)
