"""The messages of FMUs that fmpy drives, handed to whoever listens to the instance."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import byref
from functools import cache
from typing import Any

Hear = Callable[[int, str], None]
"""Takes the status and the sentence of a message."""

_LISTENING: dict[str, Hear] = {}


def callbacks(name: str, hear: Hear) -> Any:
    """The callbacks of an instance, as fmpy takes them; keep them as long as the instance.

    Parameters
    ----------
    name : of the instance
    hear : takes its messages; of several instances of a name the last one's takes all
    """
    from fmpy.fmi2 import addLoggerProxy, defaultCallbacks, fmi2CallbackFunctions

    _LISTENING[name] = hear
    found = fmi2CallbackFunctions()
    found.logger, found.allocateMemory = _logger(), defaultCallbacks.allocateMemory
    found.freeMemory = defaultCallbacks.freeMemory
    addLoggerProxy(byref(found))
    return found


def _say(_environment: Any, name: bytes, status: int, _category: bytes, message: bytes) -> None:
    hear = _LISTENING.get(name.decode())
    if hear is not None:
        hear(status, message.decode(errors="replace"))


@cache
def _logger() -> Any:
    """One logger for all instances, never replaced: fmpy's proxy passes all messages to the last one registered."""
    from fmpy.fmi2 import fmi2CallbackLoggerTYPE

    return fmi2CallbackLoggerTYPE(_say)
