"""The networks in C against onnxruntime, number by number: the same floats."""

from __future__ import annotations

import ctypes
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import onnx
from build_fmu import main as build
from fmu_src.native.build import native_platoon
from fmu_src.networks import networks_up_to
from fmu_src.toolchain.compile import compile_library, host_platform
from psp_model import StartDomain

CAPACITY, COUNT = 13, 40


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """network.c with all networks of this project up to 13 vehicles, its functions to be seen."""
    fmu = replace(native_platoon(CAPACITY, {}), networks=networks_up_to(CAPACITY))
    sources = {n: c for n, c in fmu.sources("").items() if n.endswith(".h") or n == "network.c"}
    path = tmp_path_factory.mktemp("network") / "network.so"
    path.write_bytes(compile_library(host_platform(), "network", sources, ["-fvisibility=default"]))
    return ctypes.CDLL(str(path))


def candidates(library: ctypes.CDLL, s: np.ndarray, v: np.ndarray) -> np.ndarray:
    """(K, 3) what the C code gives, the answer first."""
    found = np.zeros((COUNT, 4))
    arguments = [array.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for array in (s, v, found)]
    count = library.PspPlatoonNative_network_candidates(v.size, arguments[0], arguments[1], COUNT, arguments[2])
    return found[:count, :3]


@pytest.mark.parametrize("vehicles", range(2, CAPACITY))
def test_answer_and_ranking_are_those_of_onnxruntime(library: ctypes.CDLL, vehicles: int) -> None:
    assert library.PspPlatoonNative_network_for(vehicles)
    network = networks_up_to(CAPACITY)[vehicles].reader
    s, v = StartDomain().draw(np.random.default_rng(vehicles), vehicles, 20)
    for k in range(20):
        start = np.ascontiguousarray(s[:, k]), np.ascontiguousarray(v[:, k])
        expected = [(shape.alpha, shape.r, shape.p) for shape in network.candidates(*start, COUNT)]
        np.testing.assert_array_equal(candidates(library, *start), expected)


def another_operator(model: onnx.ModelProto) -> None:
    next(node for node in model.graph.node if node.op_type == "Relu").op_type = "Sigmoid"


def swapped_speeds(model: onnx.ModelProto) -> None:
    (node,) = (node for node in model.graph.node if node.output[0] == "channels")
    node.input[1], node.input[2] = node.input[2], node.input[1]


@pytest.mark.parametrize("change", [another_operator, swapped_speeds])
def test_what_the_c_code_would_compute_otherwise_is_refused(tmp_path: Path, capsys: Any, change: Any) -> None:
    model = onnx.load(str(Path(__file__).parents[2] / "onnx" / "platoon_any.onnx"))
    change(model)
    onnx.save(model, str(tmp_path / "other.onnx"))
    command = ["--runtime", "native", "--vehicles", "3", "--network", str(tmp_path / "other.onnx")]
    assert build([*command, "--output", str(tmp_path)]) == 2
    sentence = capsys.readouterr().err
    assert "other.onnx cannot go into C" in sentence and sentence.count("\n") == 1
    assert not list(tmp_path.glob("*.fmu"))


@pytest.mark.parametrize("vehicles", [-1, 0, 1, CAPACITY, 2**31 - 1])
def test_there_is_none_for_other_numbers(library: ctypes.CDLL, vehicles: int) -> None:
    assert not library.PspPlatoonNative_network_for(vehicles)
    assert CAPACITY not in networks_up_to(CAPACITY)


def test_the_network_for_any_number_goes_in_once(library: ctypes.CDLL) -> None:
    networks = networks_up_to(CAPACITY)
    header = replace(native_platoon(CAPACITY, {}), networks=networks).sources("")["psp_network.h"].decode()
    assert header.count("static const PspNetwork NETWORK_") == len({network.name for network in networks.values()})
    assert len(set(networks)) > len({network.name for network in networks.values()})
    assert Path(networks[3].name).stem == "platoon_any"
