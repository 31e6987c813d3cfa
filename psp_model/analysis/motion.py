"""A run seen from a frame that drives along, and how fast its spacings change."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..run import Run
from ..sampling.hold import relative


def moving_frame(run: Run, speed: float) -> NDArray[np.float64]:
    """Positions seen from a frame that drives at constant speed with where the leader started.

    Parameters
    ----------
    run : the run
    speed : of the frame [m/s]

    Returns
    -------
    (K, n) array [m]
    """
    return run.x - run.x[0, 0] - speed * (run.time - run.time[0])[:, None]


def closing_speeds(run: Run) -> NDArray[np.float64]:
    """ds_i/dt = v_{i-1} - v_i.

    Parameters
    ----------
    run : the run

    Returns
    -------
    (K, n-1) array [m/s]
    """
    return relative(run.v.T).T
