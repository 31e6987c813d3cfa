"""What a command raises when its input is no good."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .errors import InputError


def BadInput(problem: str, remedy: str | None = None) -> InputError:  # raised like a class
    """The error to raise, made where it is raised: its root lies in the model, which takes longer to import than help.

    Parameters
    ----------
    problem : what is wrong; without `remedy` the whole sentence
    remedy : what to do about it
    """
    from .errors import InputError

    return InputError(problem, remedy)


def of_the_user(error: BaseException) -> bool:
    """Whether the user can mend it: all such errors have one root.

    Parameters
    ----------
    error : what was raised; while the model has not been imported it cannot be one of its errors
    """
    errors = sys.modules.get("psp_model.errors")
    return errors is not None and isinstance(error, errors.PspError)
