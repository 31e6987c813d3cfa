"""How hard vehicles ahead may brake: the C of the native controller finds what psp_model finds at all its instants."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
import pytest

from fmu_src.native import build
from fmu_src.toolchain.compile import host_platform
from psp_model.vehicles.braking import Braking, brake_margin

N = 100
EXPORTS = b"""
#include "braking.h"
#define EXPORTED __attribute__((visibility("default")))
#include <stddef.h>
EXPORTED double margin(int n, const double *clearance, const double *v, const double *a, double dead_time,
                       const double *lag, const double *a_min, const double *automated)
{
    const Braking vehicles = {.v = v, .a = a, .lag = lag, .a_min = a_min, .dead_time = dead_time};
    return brake_margin(n, clearance, &vehicles, automated);
}
"""


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    sources = build.native_controller(N, {}).sources("{none}") | {"exports.c": EXPORTS}
    path = tmp_path_factory.mktemp("braking") / "braking.so"
    path.write_bytes(build.compile_library(host_platform(), "braking", sources))
    loaded = ctypes.CDLL(str(path))
    loaded.margin.restype = ctypes.c_double
    return loaded


def in_c(library: ctypes.CDLL, clearance: Any, vehicles: Braking, automated: Any) -> float:
    def numbers(values: Any) -> Any:
        return None if values is None else np.array(values, dtype=float).ctypes.data_as(ctypes.c_void_p)

    v, a, dead_time, lag, a_min = vehicles
    dead = ctypes.c_double(float(dead_time))
    parts = numbers(clearance), numbers(v), numbers(a), dead, numbers(lag), numbers(a_min), numbers(automated)
    return float(library.margin(len(v), *parts))


def drawn(rng: np.random.Generator, n: int) -> tuple[Any, Braking, Any]:
    """Vehicles as on a road: nearly alike speeds, or anything; brakes as good, or not; some drive themselves."""
    v = rng.choice([0.0, 30.0 * rng.random(), 30.0]) + rng.choice([0.0, 0.5, 5.0]) * rng.random(n)
    lag = rng.choice([0.0, 0.2, 0.5]) * np.ones(n) if rng.random() < 0.7 else rng.choice([0.0, 0.1, 0.6], n)
    a_min = -rng.choice([8.0, 1000.0]) * np.ones(n) if rng.random() < 0.5 else -rng.uniform(3.0, 9.0, n)
    automated = None if rng.random() < 0.4 else rng.choice([0.0, 1.0, 1.0], n)
    clearance = rng.uniform(*((0.1, 5.0), (2.0, 15.0), (10.0, 60.0))[rng.integers(3)], n - 1)
    return (
        clearance,
        Braking(v, rng.normal(0.0, rng.choice([0.0, 2.0]), n), rng.choice([0.0, 0.3]), lag, a_min),
        automated,
    )


def test_margins_are_those_of_the_model(library: ctypes.CDLL) -> None:
    rng, between = np.random.default_rng(0), 0
    for _ in range(1500):
        case = drawn(rng, int(rng.choice([1, 2, 3, 7])))
        expected = float(brake_margin(*case))
        assert in_c(library, *case) == pytest.approx(expected, rel=0, abs=1e-9), case
        between += 0.0 < expected < 12.0
    assert between > 200


def test_margins_of_many_vehicles_are_those_of_the_model(library: ctypes.CDLL) -> None:
    rng = np.random.default_rng(1)
    for _ in range(40):
        case = drawn(rng, N)
        assert in_c(library, *case) == pytest.approx(float(brake_margin(*case)), rel=0, abs=1e-9)
