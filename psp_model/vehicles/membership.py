"""What is remembered of vehicles, once others have joined or some have left (ours)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..law.watching import Watched
from .actuation import Actuators
from .prediction import Issued
from .road_law import Remembered


def rearranged(remembered: Remembered, members: Sequence[int | None], v: Any) -> Remembered:
    """The memory of a `RoadLaw` for another platoon (ours).

    Parameters
    ----------
    remembered : memory of the platoon before
    members : for each vehicle from here on its place before, counted from 0; None for one that was not there, of which
        nothing has been asked yet
    v : (m, ...) array, speeds of the vehicles from here on [m/s]

    Returns
    -------
    Remembered, without a predicted state
    """
    watched = remembered.watched
    if watched is not None:
        was, new = taken(watched.v, members), np.array([one is None for one in members])
        new = new.reshape(-1, *[1] * (np.ndim(v) - 1))
        watched = Watched(np.where(new, v, was), taken(watched.a, members), taken(watched.closing, members))
    issued = Issued(of_members(remembered.issued.actuators, members), remembered.issued.span)
    return Remembered(issued, watched)


def of_members(actuators: Actuators, members: Sequence[int | None]) -> Actuators:
    """The actuators of another platoon: those of vehicles that stay, and others that hold 0 (ours).

    Parameters
    ----------
    members : as for `rearranged`
    """
    queue = tuple((due, taken(command, members)) for due, command in actuators.queue)
    return Actuators(taken(actuators.a, members), taken(actuators.command, members), queue)


def taken(rows: Any, members: Sequence[int | None]) -> Any:
    """The rows of the members, and rows of 0 for those that were not there (ours).

    Parameters
    ----------
    rows : (n, ...) array
    members : as for `rearranged`

    Returns
    -------
    (m, ...) array
    """
    found = np.zeros((len(members), *rows.shape[1:]))
    for place, before in enumerate(members):
        if before is not None:
            found[place] = rows[before]
    return found
