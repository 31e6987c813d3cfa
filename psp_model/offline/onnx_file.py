"""Trained weights to an ONNX file: plain chains of Gemm and Relu, with all scaling folded into the weights."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import network
from ..state import StartDomain
from .engine import Problem
from .whole_file import write_whole

Layers = Sequence[tuple[NDArray[Any], NDArray[Any]]]


@dataclass(frozen=True)
class Provenance:
    """Where a network comes from; goes into the file's metadata.

    Attributes
    ----------
    problem, domain : what it was trained for
    recipe : how
    data_sha256 : content hash of the data set
    command : the command that made it
    seed : of its training
    data_command : the command that makes the data set
    """

    problem: Problem
    domain: StartDomain
    recipe: str
    data_sha256: str
    command: str
    seed: int = 0
    data_command: str = ""

    def entries(self) -> dict[str, str]:
        """The metadata as ONNX keeps it."""
        problem = self.problem
        objective = asdict(problem.weights) | {"T": problem.T, "horizon": problem.horizon}
        return {
            "psp_vehicles": str(problem.vehicles),
            "psp_domain": json.dumps(self.domain.as_dict()),
            "psp_constants": json.dumps(asdict(problem.constants)),
            "psp_objective": json.dumps(objective),
            "psp_data_sha256": self.data_sha256,
            "psp_recipe": self.recipe,
            "psp_command": self.command,
            "psp_seed": str(self.seed),
            "psp_data_command": self.data_command,
        }


def fold_scaling(layers: Layers, shift: Any, scale: Any, out_shift: Any, out_scale: Any) -> Layers:
    """The same network on raw input and with raw output, so that no scaling is left outside its weights (ours).

    Parameters
    ----------
    layers : (W (in, out), b (out,)) of a network on (x - shift) / scale whose output y means out_shift + out_scale y
    shift, scale : (in,) arrays
    out_shift, out_scale : (out,) arrays

    Returns
    -------
    layers in float32
    """
    folded = [(np.asarray(W, dtype=float), np.asarray(b, dtype=float)) for W, b in layers]
    W, b = folded[0]
    folded[0] = (W / np.asarray(scale)[:, None], b - (np.asarray(shift) / scale) @ W)
    W, b = folded[-1]
    folded[-1] = (W * out_scale, b * out_scale + out_shift)
    return [(W.astype(np.float32), b.astype(np.float32)) for W, b in folded]


def write_network(
    path: Path, parameters: Layers, origin: Provenance, scores: Layers | None = None, dictionary: Any = None
) -> None:
    """Write the file that `psp_model.network` reads.

    Parameters
    ----------
    path : the file
    parameters : layers from raw start to alpha, r, p
    origin : for the metadata
    scores : layers from raw start to a score for each row of `dictionary`
    dictionary : (K, 3) candidates
    """
    import onnx
    from onnx import TensorProto, helper, numpy_helper

    nodes, initialisers = _chain(parameters, "parameters", network.PARAMETERS)
    outputs = [helper.make_tensor_value_info(network.PARAMETERS, TensorProto.FLOAT, ["batch", 3])]
    if scores is not None:
        more_nodes, more_initialisers = _chain(scores, "scores", network.SCORES)
        table = np.asarray(dictionary, dtype=np.float32)
        nodes += [*more_nodes, helper.make_node("Identity", ["dictionary_values"], [network.DICTIONARY])]
        initialisers += [*more_initialisers, numpy_helper.from_array(table, "dictionary_values")]
        outputs.append(helper.make_tensor_value_info(network.SCORES, TensorProto.FLOAT, ["batch", len(table)]))
        outputs.append(helper.make_tensor_value_info(network.DICTIONARY, TensorProto.FLOAT, list(table.shape)))
    columns = len(parameters[0][0])
    inputs = [helper.make_tensor_value_info(network.INPUT, TensorProto.FLOAT, ["batch", columns])]
    graph = helper.make_graph(nodes, "platoon", inputs, outputs, initialisers)
    model = helper.make_model(
        graph, producer_name="psp-platoon", opset_imports=[helper.make_opsetid("", 13)], ir_version=8
    )
    helper.set_model_props(model, origin.entries())
    onnx.checker.check_model(model)
    write_whole(path, model.SerializeToString())


def _chain(layers: Layers, name: str, output: str) -> tuple[list[Any], list[Any]]:
    """Gemm, Relu, Gemm, Relu, ..., Gemm from the input to `output`."""
    from onnx import helper, numpy_helper

    nodes, initialisers, value = [], [], network.INPUT
    for number, (W, b) in enumerate(layers, start=1):
        last = number == len(layers)
        weights, bias, result = f"{name}_W{number}", f"{name}_b{number}", output if last else f"{name}_z{number}"
        initialisers += [numpy_helper.from_array(np.asarray(W, np.float32), weights)]
        initialisers += [numpy_helper.from_array(np.asarray(b, np.float32), bias)]
        nodes.append(helper.make_node("Gemm", [value, weights, bias], [result]))
        if not last:
            value = f"{name}_h{number}"
            nodes.append(helper.make_node("Relu", [result], [value]))
    return nodes, initialisers
