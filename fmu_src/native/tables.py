"""C headers with what the native FMU takes from Python: variables, sentences, limits and the network's numbers."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Any

import numpy as np
from onnx.helper import get_attribute_value

import onnx
from onnx import numpy_helper
from psp_model.errors import SENTENCES
from psp_model.network import DICTIONARY, INPUT, PARAMETERS, SCORES
from psp_model.parameters import ALPHA_MAX, ALPHA_MIN, P_MAX, P_MIN

from ..python_runtime import NetworkFile
from ..variables import Variable

Layer = tuple[Any, Any, bool]  # weights (rows, columns), bias (rows,), whether a Relu follows


def _text(value: str) -> str:
    return json.dumps(value, ensure_ascii=True)  # the escapes of JSON are among C's


def _group(name: str) -> str:
    """`x` for x[3]: the variables of one array stand together."""
    return name.split("[")[0]


def model_header(
    table: Sequence[Variable], vehicles: int, guid: str, network: NetworkFile | None, component: str
) -> str:
    """psp_model.h: number of vehicles, value references, start values, names, sentences and limits.

    Parameters
    ----------
    table : the variables; value references are places in it
    vehicles : n
    guid : of the FMU
    network : that goes into the FMU, None without one
    component : header that says what an instance holds
    """
    integers = [place for place, variable in enumerate(table) if variable.integer]
    if integers != list(range(integers[0], integers[0] + len(integers))):
        raise ValueError("the Integer variables must stand together in the table")
    kinds = ["parameter", "input", "output"]
    if (causalities := [variable.causality for variable in table]) != sorted(causalities, key=kinds.index):
        raise ValueError("the table must hold parameters, then inputs, then outputs")
    starts = [variable.start for variable in table if variable.start is not None]
    defines: dict[str, object] = {
        "N": vehicles,
        "COUNT": len(table),
        "FIRST_INPUT": causalities.count("parameter"),
        "FIRST_OUTPUT": len(starts),
        "COMPONENT": _text(component),
        "NETWORK": int(network is not None),
    }
    defines |= {"FIRST_INTEGER": f"{integers[0]}u", "INTEGER_COUNT": f"{len(integers)}u", "GUID": _text(guid)}
    defines |= {"ALPHA_MIN": ALPHA_MIN, "ALPHA_MAX": ALPHA_MAX, "P_MIN": P_MIN, "P_MAX": P_MAX}
    for group, members in groupby(enumerate(table), lambda row: _group(row[1].name)):
        defines[group] = next(iter(members))[0]
    lines = ["#ifndef PSP_MODEL_H", "#define PSP_MODEL_H", ""]
    lines += [f"#define PSP_{name} {value}" for name, value in defines.items()]
    lines += ["", "#define PSP_STARTS {" + ", ".join(repr(float(start)) for start in starts) + "}"]
    lines += ["#define PSP_NAMES {" + ", ".join(_text(variable.name) for variable in table) + "}", ""]
    lines += [f"#define PSP_SENTENCE_{key} {_text(sentence)}" for key, sentence in SENTENCES.items()]
    return "/* Written by fmu_src/native/tables.py. */\n" + "\n".join([*lines, "", "#endif", ""])


def _chain(graph: Any, output: str) -> list[Layer]:
    """The layers from the graph's input to `output`, which must be a plain chain of Gemm and Relu."""
    constants = {tensor.name: numpy_helper.to_array(tensor) for tensor in graph.initializer}
    made_by = {name: node for node in graph.node for name in node.output}
    layers: list[Layer] = []
    name, relu = output, False
    while name != INPUT:
        node = made_by[name]
        if node.op_type == "Gemm":
            attributes = {a.name: get_attribute_value(a) for a in node.attribute}
            weights = constants[node.input[1]]
            if attributes.pop("transB", 0) == 0:
                weights = weights.T
            if any(value not in (0, 1.0) for value in attributes.values()) or attributes.get("transA"):
                raise ValueError(f"Gemm {node.name} of the network has factors that are not 1")
            layers.insert(0, (weights, constants[node.input[2]].reshape(-1), relu))
        elif node.op_type not in ("Relu", "Identity"):
            raise ValueError(f"the network has a {node.op_type}, and only Gemm and Relu can go into the native FMU")
        relu = node.op_type == "Relu"
        name = node.input[0]
    return layers


def _floats(values: Any) -> str:
    return ", ".join(f"{float(value).hex()}f" for value in np.asarray(values, dtype=np.float32).ravel())


def _layers(name: str, layers: Sequence[Layer]) -> Iterator[str]:
    for place, (weights, bias, _) in enumerate(layers):
        yield f"static const float {name}_W{place}[] = {{{_floats(weights)}}};"
        yield f"static const float {name}_B{place}[] = {{{_floats(bias)}}};"
    rows = (
        f"{{{weights.shape[0]}, {weights.shape[1]}, {name}_W{place}, {name}_B{place}, {str(relu).lower()}}}"
        for place, (weights, _, relu) in enumerate(layers)
    )
    yield f"static const PspLayer PSP_{name}_LAYERS[] = {{{', '.join(rows)}}};"
    yield f"#define PSP_{name}_LAYER_COUNT {len(layers)}"


def _dictionary(graph: Any) -> Iterator[str]:
    """The candidates and the chain that ranks them, where the network has them."""
    if not {SCORES, DICTIONARY} <= {port.name for port in graph.output}:
        yield "#define PSP_DICTIONARY 0"
        return
    constants = {tensor.name: numpy_helper.to_array(tensor) for tensor in graph.initializer}
    source = next((node.input[0] for node in graph.node if DICTIONARY in node.output), DICTIONARY)
    rows = constants[source]
    yield f"#define PSP_DICTIONARY {len(rows)}"
    yield f"static const float PSP_DICTIONARY_ROWS[][3] = {{{', '.join(f'{{{_floats(row)}}}' for row in rows)}}};"
    yield from _layers("SCORE", _chain(graph, SCORES))


def network_header(network: NetworkFile | None) -> str:
    """psp_network.h: the layers of the network, its candidates, and what it was trained for.

    Parameters
    ----------
    network : that goes into the FMU, None without one
    """
    lines = ["#ifndef PSP_NETWORK_H", "#define PSP_NETWORK_H", "", "typedef struct {", "    int rows, columns;"]
    lines += ["    const float *weights, *bias;", "    bool relu;", "} PspLayer;", ""]
    if network is not None:
        graph = onnx.load_from_string(network.content).graph
        chains = [_chain(graph, PARAMETERS)]
        chains += [_chain(graph, SCORES)] if SCORES in {port.name for port in graph.output} else []
        widest = max(max(weights.shape) for chain in chains for weights, _, _ in chain)
        names = {f"PSP_{name.upper()}": repr(value) for name, value in network.domain.items()}
        fields = ", ".join(f".{name} = {value!r}" for name, value in network.constants.items())
        lines += [f"#define {name} {value}" for name, value in names.items()]
        lines += [f"#define PSP_TRAINED_CONSTANTS {{{fields}}}", f"#define PSP_WIDEST {widest}", ""]
        lines += [*_layers("PARAMETER", chains[0]), *_dictionary(graph)]
    return "/* Written by fmu_src/native/tables.py. */\n" + "\n".join([*lines, "", "#endif", ""])
