"""Trained weights to an ONNX file: plain layers, pooled over the spacings if the number of vehicles is free."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..selection import network
from ..selection.search.engine import Problem
from ..state import StartDomain
from ..whole_file import write_whole
from .structures import PerSpacing, Structure

_Ports = dict[str, list[str | int | None]]  # shapes by name
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
    vehicles : smallest and largest number of vehicles of a network for any number
    """

    problem: Problem
    domain: StartDomain
    recipe: str
    data_sha256: str
    command: str
    seed: int = 0
    data_command: str = ""
    vehicles: tuple[int, int] | None = None

    def entries(self) -> dict[str, str]:
        """The metadata as ONNX keeps it."""
        problem = self.problem
        objective = asdict(problem.weights) | {"T": problem.T, "horizon": problem.horizon}
        numbers = {"psp_vehicles": str(problem.vehicles)}
        if self.vehicles is not None:
            numbers = dict(zip(("psp_vehicles_min", "psp_vehicles_max"), map(str, self.vehicles), strict=True))
        return numbers | {
            "psp_domain": json.dumps(self.domain.as_dict()),
            "psp_constants": json.dumps(asdict(problem.constants)),
            "psp_objective": json.dumps(objective),
            "psp_data_sha256": self.data_sha256,
            "psp_recipe": self.recipe,
            "psp_command": self.command,
            "psp_seed": str(self.seed),
            "psp_data_command": self.data_command,
        }


def write_network(
    path: Path,
    parameters: Layers,
    origin: Provenance,
    scores: Layers | None = None,
    dictionary: Any = None,
    structure: Structure | None = None,
) -> None:
    """Write the file that `psp_model.selection.network` reads.

    Parameters
    ----------
    path : the file
    parameters : layers from raw start to alpha, r, p
    origin : for the metadata
    scores : layers from raw start to a score for each row of `dictionary`
    dictionary : (K, 3) candidates
    structure : of both; a chain of layers for one number of vehicles without
    """
    import onnx
    from onnx import TensorProto, helper

    graph = _Graph()
    if isinstance(structure, PerSpacing):
        inputs: _Ports = {network.GAPS: ["batch", "gaps"], network.SPEEDS: ["batch", "vehicles"]}
        start, shared = graph.windows(structure.radius), len(structure.widths)
    else:
        inputs = {network.INPUT: ["batch", len(parameters[0][0])]}
        start, shared = network.INPUT, 0
    graph.network(parameters, shared, start, "parameters", network.PARAMETERS)
    outputs: _Ports = {network.PARAMETERS: ["batch", 3]}
    if scores is not None:
        graph.network(scores, shared, start, "scores", network.SCORES)
        graph.node("Identity", [graph.constant("dictionary_values", dictionary)], network.DICTIONARY)
        outputs |= {network.SCORES: ["batch", len(dictionary)], network.DICTIONARY: [len(dictionary), 3]}
    given, made = (
        [helper.make_tensor_value_info(name, TensorProto.FLOAT, shape) for name, shape in side.items()]
        for side in (inputs, outputs)
    )
    model = helper.make_model(
        helper.make_graph(graph.nodes, "platoon", given, made, graph.initialisers),
        producer_name="psp-platoon",
        opset_imports=[helper.make_opsetid("", 13)],
        ir_version=8,
    )
    helper.set_model_props(model, origin.entries())
    onnx.checker.check_model(model, full_check=True)
    write_whole(path, model.SerializeToString())


class _Graph:
    """Nodes and constants of a graph in the making."""

    def __init__(self) -> None:
        self.nodes: list[Any] = []
        self.initialisers: list[Any] = []

    def node(self, operator: str, inputs: Sequence[str], output: str, **attributes: Any) -> str:
        """Add a node; the name of its output."""
        from onnx import helper

        self.nodes.append(helper.make_node(operator, list(inputs), [output], **attributes))
        return output

    def constant(self, name: str, values: Any, kind: Any = np.float32) -> str:
        """Add a constant; its name."""
        from onnx import numpy_helper

        self.initialisers.append(numpy_helper.from_array(np.asarray(values, dtype=kind), name))
        return name

    def network(self, layers: Layers, shared: int, value: str, name: str, output: str) -> None:
        """Layers from `value` to `output`: the first `shared` for every spacing, pooled, the others behind them."""
        if shared:
            value = self._pooled(layers[:shared], value, name)
        for number, (W, b) in enumerate(layers[shared:], start=shared + 1):
            last = number == len(layers)
            weights, bias = self.constant(f"{name}_W{number}", W), self.constant(f"{name}_b{number}", b)
            value = self.node("Gemm", [value, weights, bias], output if last else f"{name}_z{number}")
            if not last:
                value = self.node("Relu", [value], f"{name}_h{number}")

    def _pooled(self, layers: Layers, value: str, name: str) -> str:
        """Layers for every spacing, then mean and maximum over the spacings."""
        for number, (W, b) in enumerate(layers, start=1):
            product = self.node("MatMul", [value, self.constant(f"{name}_W{number}", W)], f"{name}_y{number}")
            total = self.node("Add", [product, self.constant(f"{name}_b{number}", b)], f"{name}_z{number}")
            value = self.node("Relu", [total], f"{name}_h{number}")
        parts = [
            self.node(f"Reduce{kind}", [value], f"{name}_{kind.lower()}", axes=[1], keepdims=0)
            for kind in ("Mean", "Max")
        ]
        return self.node("Concat", parts, f"{name}_pooled", axis=1)

    def windows(self, radius: int) -> str:
        """[batch, spacings, 4 (2 radius + 1)]: length, speeds in front and behind, 1; with its neighbours."""
        from onnx import helper

        last, one = np.iinfo(np.int64).max, self.constant("axis", [1], np.int64)
        two = self.constant("channel", [2], np.int64)
        length = self.node("Unsqueeze", [network.GAPS, two], "length")
        speeds = self.node("Unsqueeze", [network.SPEEDS, two], "all_speeds")
        front, rear = self._slice(speeds, 0, -1, one, "front"), self._slice(speeds, 1, last, one, "rear")
        shape = self.node("Shape", [length], "shape")
        filled = helper.make_tensor("one", 1, [1], [1.0])
        there = self.node("ConstantOfShape", [shape], "there", value=filled)
        channels = self.node("Concat", [length, front, rear, there], "channels", axis=2)
        margins = self.constant("margins", [0, radius, 0, 0, radius, 0], np.int64)
        padded = self.node("Pad", [channels, margins], "padded")
        ends = [*range(-2 * radius, 0), last]
        parts = [self._slice(padded, k, end, one, f"neighbour{k}") for k, end in enumerate(ends)]
        return self.node("Concat", parts, "windows", axis=2)

    def _slice(self, value: str, first: int, end: int, axis: str, output: str) -> str:
        bounds = [self.constant(f"{output}_{name}", [at], np.int64) for name, at in (("first", first), ("end", end))]
        return self.node("Slice", [value, *bounds, axis], output)
