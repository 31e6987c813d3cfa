"""The check that an ONNX file computes what was trained."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..selection.network import GAPS, INPUT, PARAMETERS, SCORES, SPEEDS, import_onnxruntime
from .errors import OfflineError
from .mixture import Mixture
from .recipes import Trained, output_scaling
from .structures import PerSpacing

_ROWS = 200
_TOLERANCE = 2e-5  # of the outputs' size: float32 with the scaling folded in against float32 without


def check_export(path: Path, data: Mixture, parameters: Trained, ranking: Trained | None) -> float:
    """Compare the file in onnxruntime with the training framework on the first starts of each data set.

    Parameters
    ----------
    path : the ONNX file
    data : for starts
    parameters, ranking : what was trained

    Returns
    -------
    the largest difference, as a share of the outputs' size

    Raises
    ------
    OfflineError : where the outputs differ
    """
    session = import_onnxruntime().InferenceSession(str(path), providers=["CPUExecutionProvider"])
    shift, scale = output_scaling(data.problem)
    worst = 0.0
    for one in data.sets:
        starts, spacings = one.starts[:_ROWS].astype(np.float32), one.problem.vehicles - 1
        rows = parameters.structure.rows(one.starts[:_ROWS], one.domain)
        expected = {PARAMETERS: shift + scale * np.asarray(parameters.structure.apply(parameters.scaled, rows))}
        if ranking is not None:
            expected[SCORES] = np.asarray(ranking.structure.apply(ranking.scaled, rows))
        inputs = {INPUT: starts}
        if isinstance(parameters.structure, PerSpacing):
            inputs = {GAPS: starts[:, :spacings], SPEEDS: starts[:, spacings:]}
        for name, values in expected.items():
            (found,) = session.run([name], inputs)
            worst = max(worst, float(np.abs(found - values).max() / np.abs(values).max()))
    if not worst < _TOLERANCE:
        raise OfflineError(f"{path} differs from the trained network by {worst:.1e} of its outputs: please report it")
    return worst
