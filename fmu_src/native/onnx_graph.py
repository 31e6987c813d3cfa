"""The layers of an ONNX network as numbers, for the tables in C."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from onnx.helper import get_attribute_value

from onnx import numpy_helper
from psp_model.offline.structures import CHANNELS, Layered, PerSpacing
from psp_model.selection.network import DICTIONARY, INPUT, ParameterNetwork
from psp_model.state import StartDomain


@dataclass(frozen=True)
class Layer:
    """One layer.

    Attributes
    ----------
    weights, bias : (rows, columns) and (rows,) arrays
    relu : whether a Relu follows
    """

    weights: Any
    bias: Any
    relu: bool


@dataclass(frozen=True)
class Chain:
    """Layers one after the other, optionally with the spacings pooled in between.

    Attributes
    ----------
    layers : all of them
    shared : how many of them are in front of the pooling; 0 if nothing is pooled
    """

    layers: tuple[Layer, ...]
    shared: int

    @property
    def radius(self) -> int:
        """The number of neighbours on each side that the shared layers take with a spacing."""
        return (self.layers[0].weights.shape[1] // CHANNELS - 1) // 2 if self.shared else 0

    @property
    def widest(self) -> int:
        """The most numbers that go into a layer or come out of one."""
        return max(max(layer.weights.shape) for layer in self.layers)


def candidates(graph: Any) -> Any:
    """The triples that the network ranks, (K, 3)."""
    constants = {tensor.name: numpy_helper.to_array(tensor) for tensor in graph.initializer}
    return constants[next((node.input[0] for node in graph.node if DICTIONARY in node.output), DICTIONARY)]


def chain_to(graph: Any, output: str) -> Chain:
    """The layers from the graph's input, or from the windows around the spacings, to `output`.

    Raises
    ------
    ValueError : if the graph differs from what psp_model/offline/onnx_file.py writes
    """
    constants = {tensor.name: numpy_helper.to_array(tensor) for tensor in graph.initializer}
    made_by = {name: node for node in graph.node for name in node.output}
    layers: list[Layer] = []
    behind, name, relu = 0, output, False
    while name not in (INPUT, "windows"):
        node = made_by[name]
        if node.op_type in ("Gemm", "Add"):
            layers.insert(0, _layer(node, made_by, constants, relu))
        elif node.op_type == "Concat":
            behind = len(layers)
            _require_pooling([made_by[part] for part in node.input])
        elif node.op_type not in ("Relu", "Identity", "MatMul", "ReduceMean"):
            raise ValueError(f"the network has a {node.op_type}, which cannot go into the native FMU")
        relu = node.op_type == "Relu"
        name = node.input[0]
    return Chain(tuple(layers), len(layers) - behind if name == "windows" else 0)


def require_same(chain: Chain, network: ParameterNetwork) -> None:
    """Check that the layers give what the file gives, so that no other network than this one goes into C.

    Parameters
    ----------
    chain : to the network's answer
    network : reads the file

    Raises
    ------
    ValueError : where they differ
    """
    vehicles = network.vehicles[len(network.vehicles) // 2]
    s, v = network.domain.draw(np.random.default_rng(0), vehicles, 1)
    widths = tuple(layer.weights.shape[0] for layer in chain.layers[: chain.shared])
    structure = PerSpacing(vehicles - 1, widths, chain.radius) if chain.shared else Layered(vehicles)
    rows = structure.rows(np.concatenate([s, v]).T, StartDomain(-1.0, 1.0, -1.0, 1.0))  # these bounds scale nothing
    (found,) = structure.apply([(layer.weights.T, layer.bias) for layer in chain.layers], rows)
    answer = network.evaluate(s[:, 0], v[:, 0])
    if not np.allclose(found, [answer.alpha, answer.r, answer.p], rtol=1e-3, atol=1e-5):
        raise ValueError("the network is wired in another way than psp train wires it")


def _layer(node: Any, made_by: dict[str, Any], constants: dict[str, Any], relu: bool) -> Layer:
    """The layer that a Gemm, or an Add behind a MatMul, makes."""
    if node.op_type == "Add":
        return Layer(constants[made_by[node.input[0]].input[1]].T, constants[node.input[1]].reshape(-1), relu)
    attributes = {a.name: get_attribute_value(a) for a in node.attribute}
    weights = constants[node.input[1]]
    if attributes.pop("transB", 0) == 0:
        weights = weights.T
    if any(value not in (0, 1.0) for value in attributes.values()) or attributes.get("transA"):
        raise ValueError(f"Gemm {node.name} of the network has factors that are not 1")
    return Layer(weights, constants[node.input[2]].reshape(-1), relu)


def _require_pooling(parts: list[Any]) -> None:
    """Check that what is joined are mean and maximum of the same values."""
    if [part.op_type for part in parts] != ["ReduceMean", "ReduceMax"] or parts[0].input != parts[1].input:
        raise ValueError("the network joins something else than mean and maximum over the spacings")
