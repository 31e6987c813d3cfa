"""What all tests share: no logger that fmpy was ever given may go, and tests say what they need from the system.

fmpy turns messages into text in a C library that hands all of them to the last logger it was shown.  Once a run with a
logger of its own is over, that logger is freed, and a later run without one crashes the process at its first message.
"""

from __future__ import annotations

from typing import Any

import fmpy.fmi2
import fmpy.simulation
import pytest

from system_packages import require

_logger_type = fmpy.fmi2.fmi2CallbackLoggerTYPE
_kept: list[Any] = []


def _for_good(function: Any) -> Any:
    _kept.append(_logger_type(function))
    return _kept[-1]


fmpy.fmi2.fmi2CallbackLoggerTYPE = fmpy.simulation.fmi2CallbackLoggerTYPE = _for_good


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Before anything is built for a test, ask whether the system has what the test needs."""
    for mark in item.iter_markers("system"):
        require(*mark.args)
