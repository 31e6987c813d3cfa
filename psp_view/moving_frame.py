"""A run seen from a frame that drives along."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from psp_model.run import Run


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
