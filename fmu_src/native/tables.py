"""C headers with what the native FMU takes from Python: variables, sentences, limits and the network's numbers."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
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
    table: Sequence[Variable], vehicles: int, guid: str, networks: Mapping[int, NetworkFile], component: str
) -> str:
    """psp_model.h: number of vehicles, value references, start values, names, sentences and limits.

    Parameters
    ----------
    table : the variables; value references are places in it
    vehicles : n
    guid : of the FMU
    networks : that go into the FMU, by number of vehicles
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
        "NETWORK": int(bool(networks)),
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
    yield f"static const PspLayer {name}[] = {{{', '.join(rows)}}};"


def _candidates(graph: Any) -> Any:
    """The triples that the network ranks, (K, 3)."""
    constants = {tensor.name: numpy_helper.to_array(tensor) for tensor in graph.initializer}
    return constants[next((node.input[0] for node in graph.node if DICTIONARY in node.output), DICTIONARY)]


def _tables(vehicles: int, network: NetworkFile) -> tuple[list[str], str, int, int]:
    """The tables of one network, its row in the table of networks, its widest layer and how many triples it ranks."""
    graph = onnx.load_from_string(network.content).graph
    name, parameters = f"NETWORK_{vehicles}", _chain(graph, PARAMETERS)
    widest = max(max(weights.shape) for weights, _, _ in parameters)
    lines = [*_layers(f"{name}_PARAMETERS", parameters)]
    row = {"vehicles": str(vehicles), "parameters": f"{name}_PARAMETERS", "parameter_layers": str(len(parameters))}
    rows = 0
    if {SCORES, DICTIONARY} <= {port.name for port in graph.output}:
        scores, candidates = _chain(graph, SCORES), _candidates(graph)
        widest, rows = max(widest, *(max(weights.shape) for weights, _, _ in scores)), len(candidates)
        lines += _layers(f"{name}_SCORES", scores)
        triples = ", ".join(f"{{{_floats(triple)}}}" for triple in candidates)
        lines.append(f"static const float {name}_CANDIDATES[][3] = {{{triples}}};")
        row |= {"scores": f"{name}_SCORES", "score_layers": str(len(scores))}
        row |= {"candidates": f"{name}_CANDIDATES", "candidate_count": str(rows)}
    row |= {bound: repr(value) for bound, value in network.domain.items()}
    row["trained"] = "{" + ", ".join(f".{constant} = {value!r}" for constant, value in network.constants.items()) + "}"
    return lines, "{" + ", ".join(f".{key} = {value}" for key, value in row.items()) + "}", widest, rows


_NETWORK_TYPES = """typedef struct {
    int rows, columns;
    const float *weights, *bias;
    bool relu;
} PspLayer;

typedef struct {
    int vehicles, parameter_layers, score_layers, candidate_count;
    const PspLayer *parameters, *scores; /* no scores where it ranks nothing */
    const float (*candidates)[3];
    double gap_min, gap_max, speed_min, speed_max, standstill, headway;
    Constants trained;
} PspNetwork;
"""


def network_header(networks: Mapping[int, NetworkFile]) -> str:
    """psp_network.h: the layers of the networks, their candidates, and what they were trained for.

    Parameters
    ----------
    networks : that go into the FMU, by number of vehicles
    """
    lines = ["#ifndef PSP_NETWORK_H", "#define PSP_NETWORK_H", ""]
    if networks:
        made = [_tables(vehicles, network) for vehicles, network in networks.items()]
        lines += [_NETWORK_TYPES, f"#define PSP_WIDEST {max(widest for _, _, widest, _ in made)}"]
        lines += [f"#define PSP_MOST_CANDIDATES {max(1, *(rows for _, _, _, rows in made))}", ""]
        lines += [line for tables, _, _, _ in made for line in tables]
        lines += ["static const PspNetwork PSP_NETWORKS[] = {", *(f"    {row}," for _, row, _, _ in made), "};"]
    return "/* Written by fmu_src/native/tables.py. */\n" + "\n".join([*lines, "", "#endif", ""])
