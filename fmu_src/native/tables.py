"""C headers with what the native FMU takes from Python: variables, sentences, limits and the network's numbers."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from textwrap import wrap
from typing import Any

import numpy as np

import onnx
from psp_model import errors
from psp_model.law.watching import CLOSING_TIME
from psp_model.parameters import ALPHA_MAX, ALPHA_MIN, P_MAX, P_MIN, ObjectiveWeights, PlatoonParameters
from psp_model.quantities import quantity_of
from psp_model.selection.network import DICTIONARY, PARAMETERS, SCORES
from psp_model.vehicles.braking import MOST
from psp_model.vehicles.leader import Profile

from ..errors import SENTENCES, BuildError
from ..interface.meaning import variable_names
from ..interface.variables import Variable
from ..networks import NetworkFile
from .onnx_graph import Chain, Layer, candidates, chain_to, require_same

_LONGEST_LINE = 120
# Structs of C, by the model's: the generated lists X(field, variable, unit) name their fields.
_STRUCTS: dict[str, type[Any]] = {"CONSTANTS": PlatoonParameters, "WEIGHTS": ObjectiveWeights}
_TRIPLE = ("alpha", "r", "p")  # of a potential; whether there is a hill is no variable


def _text(value: str) -> str:
    return json.dumps(value, ensure_ascii=True)  # the escapes of JSON are among C's


def _group(name: str) -> str:
    """`x` for x[3]: the variables of one array stand together."""
    return name.split("[")[0]


def _fields(name: str, variables: Mapping[str, str]) -> list[str]:
    """A list of fields as a macro that takes another one: X(field, variable, unit) for each."""
    rows = [f"    X({field}, {of}, {_text(quantity_of(of).unit)})" for field, of in variables.items()]
    return ["", f"#define PSP_{name}_FIELDS(X) \\", *(f"{row} \\" for row in rows[:-1]), rows[-1]]


def model_header(
    table: Sequence[Variable], vehicles: int, guid: str, networks: Mapping[int, NetworkFile], component: str
) -> str:
    """psp_model.h: number of vehicles, value references, fields of the model's structs, sentences and limits.

    Parameters
    ----------
    table : the variables; value references are places in it
    vehicles : n
    guid : of the FMU
    networks : that go into the FMU, by number of vehicles
    component : header that says what an instance holds
    """
    integers = [place for place, variable in enumerate(table) if variable.integer]
    first = integers[0] if integers else 0
    if integers != list(range(first, first + len(integers))):
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
    defines |= {"FIRST_INTEGER": f"{first}u", "INTEGER_COUNT": f"{len(integers)}u", "GUID": _text(guid)}
    defines |= {"ALPHA_MIN": ALPHA_MIN, "ALPHA_MAX": ALPHA_MAX, "P_MIN": P_MIN, "P_MAX": P_MAX}
    defines |= {"CLOSING_TIME": CLOSING_TIME, "HARDEST": MOST}
    for group, members in groupby(enumerate(table), lambda row: _group(row[1].name)):
        defines[group] = next(iter(members))[0]
    lines = ["#ifndef PSP_MODEL_H", "#define PSP_MODEL_H", ""]
    lines += [f"#define PSP_{name} {value}" for name, value in defines.items()]
    for struct, kind in _STRUCTS.items():
        lines += _fields(struct, variable_names(kind))
    lines += _fields("TRIPLE", dict(zip(_TRIPLE, _TRIPLE, strict=True)))
    sentences = errors.SENTENCES | SENTENCES
    lines += ["", *(f"#define PSP_SENTENCE_{key} {_text(sentence)}" for key, sentence in sentences.items())]
    return "/* Written by fmu_src/native/tables.py. */\n" + "\n".join([*lines, "", "#endif", ""])


def _array(declaration: str, values: Iterable[str]) -> list[str]:
    """An array in lines that every compiler takes: C11 promises 4095 characters."""
    return [f"{declaration} = {{", *wrap(", ".join(values), _LONGEST_LINE, break_on_hyphens=False), "};"]


def table_header(table: Sequence[Variable]) -> str:
    """psp_table.h: start values and names of the variables, for the one file that includes it.

    Parameters
    ----------
    table : the variables
    """
    starts = (repr(float(variable.start)) for variable in table if variable.start is not None)
    names = (_text(variable.name) for variable in table)
    lines = ['#include "psp_model.h"', "", *_array("static const double STARTS[PSP_FIRST_OUTPUT]", starts)]
    lines += _array("const char *const PSP_VARIABLE_NAMES[PSP_COUNT]", names)
    return "/* Written by fmu_src/native/tables.py. */\n" + "\n".join([*lines, ""])


def profile_header(profile: Profile | None) -> str:
    """psp_profile.h: the rows of a speed profile, for the one file that includes it.

    Parameters
    ----------
    profile : None where the leader drives a wave
    """
    columns = {} if profile is None else {"TIMES": profile.times, "SPEEDS": profile.speeds}
    lines = [
        f"#define PSP_PROFILE {0 if profile is None else len(profile.times)} /* rows; 0: there is no profile */",
        "",
    ]
    for name, numbers in columns.items():
        lines += _array(f"static const double PROFILE_{name}[PSP_PROFILE]", map(repr, map(float, numbers)))
    return "/* Written by fmu_src/native/tables.py. */\n" + "\n".join([*lines, ""])


def _floats(values: Any) -> list[str]:
    """The shortest decimals that are read back as the same floats."""
    return [f"{value!s}f" for value in np.asarray(values, dtype=np.float32).ravel()]


def _layers(name: str, layers: Sequence[Layer]) -> Iterator[str]:
    for place, layer in enumerate(layers):
        yield from _array(f"static const float {name}_W{place}[]", _floats(layer.weights))
        yield from _array(f"static const float {name}_B{place}[]", _floats(layer.bias))
    shapes = (", ".join(map(str, layer.weights.shape)) for layer in layers)
    rows = (
        f"{{{shape}, {name}_W{place}, {name}_B{place}, {str(layer.relu).lower()}}}"
        for place, (shape, layer) in enumerate(zip(shapes, layers, strict=True))
    )
    yield from _array(f"static const PspLayer {name}[]", rows)


def _initialiser(chain: Chain, name: str) -> str:
    """The chain as C writes it."""
    return f"{{.layers = {name}, .count = {len(chain.layers)}, .shared = {chain.shared}, .radius = {chain.radius}}}"


def _tables(name: str, network: NetworkFile) -> tuple[list[str], int, int]:
    """The tables of one network, its widest layer and how many triples it ranks.

    Raises
    ------
    BuildError : where the network holds something that the C code does not know
    """
    try:
        return _checked_tables(name, network)
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        remedy = "export it with psp train, or build the Python FMU"
        raise BuildError(f"the network file {network.name} cannot go into C ({error})", remedy) from None


def _checked_tables(name: str, network: NetworkFile) -> tuple[list[str], int, int]:
    graph = onnx.load_from_string(network.content).graph
    parameters = chain_to(graph, PARAMETERS)
    require_same(parameters, network.reader)
    widest, lines, rows = parameters.widest, [*_layers(f"{name}_PARAMETERS", parameters.layers)], 0
    row = {"parameters": _initialiser(parameters, f"{name}_PARAMETERS")}
    if {SCORES, DICTIONARY} <= {port.name for port in graph.output}:
        scores, triples = chain_to(graph, SCORES), candidates(graph)
        widest, rows = max(widest, scores.widest), len(triples)
        lines += _layers(f"{name}_SCORES", scores.layers)
        listed = (f"{{{', '.join(_floats(triple))}}}" for triple in triples)
        lines += _array(f"static const float {name}_CANDIDATES[][3]", listed)
        row |= {"scores": _initialiser(scores, f"{name}_SCORES")}
        row |= {"candidates": f"{name}_CANDIDATES", "candidate_count": str(rows)}
    row |= {bound: repr(value) for bound, value in network.domain.items()}
    row["trained"] = "{" + ", ".join(f".{constant} = {value!r}" for constant, value in network.constants.items()) + "}"
    fields = ", ".join(f".{key} = {value}" for key, value in row.items())
    return [*lines, f"static const PspNetwork {name} = {{{fields}}};"], widest, rows


_NETWORK_TYPES = """typedef struct {
    int rows, columns;
    const float *weights, *bias;
    bool relu;
} PspLayer;

/* The first `shared` layers see each spacing with `radius` neighbours on both sides; behind them these are pooled. */
typedef struct {
    const PspLayer *layers;
    int count, shared, radius;
} PspChain;

typedef struct {
    PspChain parameters, scores; /* no layers of scores where it ranks nothing */
    int candidate_count;
    const float (*candidates)[3];
    double gap_min, gap_max, speed_min, speed_max, standstill, headway;
    Constants trained;
} PspNetwork;
"""


def network_header(networks: Mapping[int, NetworkFile]) -> str:
    """psp_network.h: the layers of the networks, their candidates, and what they were trained for.

    Parameters
    ----------
    networks : that go into the FMU, by number of vehicles; one may serve several numbers
    """
    lines = ["#ifndef PSP_NETWORK_H", "#define PSP_NETWORK_H", ""]
    if networks:
        files = {network.name: network for network in networks.values()}
        names = {name: f"NETWORK_{place}" for place, name in enumerate(files)}
        made = [_tables(names[name], network) for name, network in files.items()]
        lines += [_NETWORK_TYPES, f"#define PSP_WIDEST {max(widest for _, widest, _ in made)}"]
        lines += [f"#define PSP_MOST_CANDIDATES {max(1, *(rows for _, _, rows in made))}", ""]
        lines += [line for tables, _, _ in made for line in tables]
        rows = (f"    [{n}] = &{names[network.name]}," for n, network in sorted(networks.items()))
        lines += ["static const PspNetwork *const PSP_NETWORK_OF[] = {", *rows, "};"]
    return "/* Written by fmu_src/native/tables.py. */\n" + "\n".join([*lines, "", "#endif", ""])
