"""What an FMU says of calls that the standard forbids, and what is at fault where one is built."""

from __future__ import annotations

from psp_model.errors import PspError, TableError

SENTENCES = {
    "fixed": "%s is a fixed parameter: set it before initialisation ends, or reset the FMU first",
    "output": "%s is an output and cannot be set: set parameters only",
    "reference": "value reference %d belongs to no %s variable of this FMU: take it from modelDescription.xml",
    "state": "fmi2DeSerializeFMUstate was given a state that no run can come to, though its checksum fits: pass what "
    "fmi2SerializeFMUstate wrote",
    "memory": "there is no memory left in %s: end other programs, or build the FMU for fewer vehicles",
    "import": "the Python %s cannot import what %s needs (%s): install numpy and onnxruntime anew in that Python, or "
    "use the native FMU",
    "refused": "the operating system refused what %s needs (%s): allow that, or use the native FMU",
    "interrupted": "%s was interrupted by %s: reset the instance, or set a state that was saved before",
    "internal": "internal error in %s, %s: please report it with the start values that led to it",
}


class FmiError(TableError):
    """A call that a variable or the state of an FMU does not allow."""

    sentences = SENTENCES


class BuildError(PspError, RuntimeError):
    """What an FMU is built from or with is at fault."""


class ParameterError(PspError, ValueError):
    """A value that no parameter of an FMU can have, or a name that none has."""
