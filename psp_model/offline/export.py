"""The check that an ONNX file computes what was trained."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..network import INPUT, PARAMETERS, SCORES
from .errors import OfflineError
from .fit import apply
from .parquet import Dataset
from .recipes import Trained, output_scaling, scaled_starts

_ROWS = 200
_TOLERANCE = 2e-5  # of the outputs' size: float32 with the scaling folded in against float32 without


def check_export(path: Path, data: Dataset, parameters: Trained, ranking: Trained | None) -> float:
    """Compare the file in onnxruntime with the training framework on the data set's first starts.

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
    import onnxruntime

    session = onnxruntime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    starts, x = data.starts[:_ROWS].astype(np.float32), scaled_starts(data)[:_ROWS]
    shift, scale = output_scaling(data.problem)
    expected = {PARAMETERS: shift + scale * np.asarray(apply(parameters.scaled, x))}
    if ranking is not None:
        expected[SCORES] = np.asarray(apply(ranking.scaled, x))
    worst = 0.0
    for name, values in expected.items():
        (found,) = session.run([name], {INPUT: starts})
        worst = max(worst, float(np.abs(found - values).max() / np.abs(values).max()))
    if not worst < _TOLERANCE:
        raise OfflineError(f"{path} differs from the trained network by {worst:.1e} of its outputs: please report it")
    return worst
