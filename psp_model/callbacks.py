"""Callbacks for warnings, and how they are copied and pickled with the object that calls them."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from contextvars import ContextVar
from copy import deepcopy
from typing import Any, TypeVar

_TRYING: ContextVar[bool] = ContextVar("_TRYING", default=False)

Self = TypeVar("Self", bound="Warns")


def silent(sentence: str) -> None:
    """Ignore a warning.

    Parameters
    ----------
    sentence : the warning
    """


class Warns:
    """An object with a callback `warn`, which is no part of its state.

    Copies, deep ones too, call the same callback.  A pickle keeps it where pickle can; a lambda, a function inside a
    function or a method of an open file is replaced by `silent`, and has to be set again.
    """

    warn: Callable[[str], None]

    def __getstate__(self) -> dict[str, Any]:
        return vars(self) | {"warn": _picklable(self.warn)}

    def __copy__(self: Self) -> Self:
        return self._with(vars(self))

    def __deepcopy__(self: Self, memo: dict[int, Any]) -> Self:
        made = memo[id(self)] = self._with({"warn": self.warn})
        vars(made).update({name: deepcopy(value, memo) for name, value in vars(self).items() if name != "warn"})
        return made

    def _with(self: Self, state: dict[str, Any]) -> Self:
        """An object of the same class with this state: what `copy` would make without `__getstate__`."""
        made = object.__new__(type(self))
        vars(made).update(state)
        return made


def _picklable(warn: Callable[[str], None]) -> Callable[[str], None]:
    """The callback, or `silent` where it cannot be pickled."""
    if _TRYING.get():  # it belongs to an object that holds the one being pickled
        return warn
    token = _TRYING.set(True)
    try:
        pickle.dumps(warn)
    except Exception:  # pickle raises whatever the callback's own object does
        return silent
    finally:
        _TRYING.reset(token)
    return warn
