"""C functions that FMUs rarely or never call with difficult arguments, called alone: projection, resource paths."""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
import pytest

from fmu_src.native import build
from fmu_src.toolchain.compile import host_platform
from psp_model import ModelError, PlatoonParameters, PotentialParameters, max_slope, project, require_feasible

EXPORTS = b"""
#include "vehicles.h"
#define EXPORTED __attribute__((visibility("default")))
EXPORTED int exported_project(double *t, const double *c)
{
    Front front = {0};
    Shape shape = {t[0], t[1], t[2], 1.0};
    const Constants constants = {c[0], c[1], c[2], c[3], c[4], c[5], c[6]};
    const bool done = project(&front, &shape, &constants);
    t[0] = shape.alpha;
    t[1] = shape.r;
    t[2] = shape.p;
    return done;
}
EXPORTED int exported_require(const double *t, const double *c)
{
    Front front = {0};
    const Shape shape = {t[0], t[1], t[2], 1.0};
    const Constants constants = {c[0], c[1], c[2], c[3], c[4], c[5], c[6]};
    return require_feasible(&front, &shape, &constants);
}
EXPORTED char *exported_path(const char *uri) { return resource_path(uri); }
"""


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """The native platoon's sources with three of their functions made visible."""
    sources = build.native_platoon(3, {}).sources("{none}") | {"exports.c": EXPORTS}
    path = tmp_path_factory.mktemp("functions") / "functions.so"
    path.write_bytes(build.compile_library(host_platform(), "functions", sources))
    loaded = ctypes.CDLL(str(path))
    loaded.exported_path.restype = ctypes.c_char_p
    return loaded


def vector(*values: float) -> Any:
    return (ctypes.c_double * len(values))(*values)


def packed(c: PlatoonParameters) -> Any:
    return vector(c.L, c.lam, c.v_star, c.v_max, c.epsilon, c.mu, c.z)


def projected(library: ctypes.CDLL, shape: PotentialParameters, c: PlatoonParameters) -> PotentialParameters | None:
    triple = vector(shape.alpha, shape.r, shape.p)
    return PotentialParameters(*triple) if library.exported_project(triple, packed(c)) else None


def stage(asked: PotentialParameters, given: PotentialParameters | None) -> str:
    """How far the projection had to go."""
    if given is None:
        return "empty"
    if given.p > 3.0:
        return "p lowered" if given.p < min(asked.p, 9.0) else "bounds"
    if given.alpha == min(max(asked.alpha, 1e-3), 1e-1):
        return "r raised" if given.r > asked.r else "p lowered"
    return "alpha lowered" if given.alpha == 1e-3 else "flattest"


def tight(room: float, rng: np.random.Generator) -> PlatoonParameters:
    """Constants that one alpha alone can still meet, about the one that has the flattest hill."""
    slopes = [
        max_slope(PotentialParameters(float(alpha), 5.0 + room, 3.0), PlatoonParameters(lam=8.0 + room))
        for alpha in np.geomspace(1e-3, 1e-1, 40)
    ]
    return PlatoonParameters(lam=8.0 + room, z=min(slopes) * float(rng.choice([0.97, 1 + 1e-6, 1.001])))


def random_case(rng: np.random.Generator) -> tuple[PotentialParameters, PlatoonParameters]:
    L, room = rng.uniform(1, 9), 10 ** rng.uniform(-2, 1.3)
    constants = PlatoonParameters(L=L, lam=L + 3 + room, z=10 ** rng.uniform(-1.3, 1.3))
    asked = 10 ** rng.uniform(-3.3, -0.7), L + room * rng.uniform(-0.1, 1.1), rng.uniform(2, 10)
    return PotentialParameters(*map(float, asked)), constants


def test_the_projection_is_that_of_the_model_at_every_stage(library: ctypes.CDLL) -> None:
    rng = np.random.default_rng(0)
    cases = [random_case(rng) for _ in range(90)]
    cases += [(PotentialParameters(0.02, 6.0, 5.0), tight(room, rng)) for room in (0.2, 0.5, 0.8, 1.5, 2.0)]
    seen = set()
    for asked, constants in cases:
        ours = projected(library, asked, constants)
        seen.add(stage(asked, ours))
        try:
            theirs = project(asked, constants)
        except ModelError as error:
            assert error.key == "empty" and ours is None, (asked, constants)
            continue
        assert ours is not None, (asked, constants)
        require_feasible(ours, constants)
        assert library.exported_require(vector(theirs.alpha, theirs.r, theirs.p), packed(constants))
        assert [ours.alpha, ours.r, ours.p] == pytest.approx([theirs.alpha, theirs.r, theirs.p], rel=0, abs=4e-9)
    assert seen == {"bounds", "p lowered", "r raised", "alpha lowered", "flattest", "empty"}


@pytest.mark.parametrize(
    ("uri", "path"),
    [
        ("file:///tmp/fmu/resources", "/tmp/fmu/resources"),
        ("file:/tmp/fmu/resources/", "/tmp/fmu/resources"),
        ("file://localhost/tmp/fmu", "/tmp/fmu"),
        ("file:///tmp/a%20b/%C3%BC%23%2b", "/tmp/a b/ü#+"),
        ("file:///tmp/100%", "/tmp/100%"),
        ("file:///tmp/%zz%4", "/tmp/%zz%4"),
        ("file:///tmp/x//\\", "/tmp/x"),
        ("file:///", "/"),
        ("/tmp/100%25/plain", "/tmp/100%25/plain"),
        ("file://server/share", "/server/share"),
        ("", ""),
    ],
)
def test_a_resource_uri_becomes_a_path(library: ctypes.CDLL, uri: str, path: str) -> None:
    if host_platform() != "linux64":
        pytest.skip("these are Linux's paths")
    assert library.exported_path(uri.encode()).decode() == path


def test_every_path_survives_its_uri(library: ctypes.CDLL, tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    alphabet = [chr(code) for code in range(33, 127) if chr(code) not in "/\\"] + list("äß é€")
    for _ in range(200):
        one, other = ("".join(rng.choice(alphabet, rng.integers(1, 20))) for _ in range(2))
        path = f"/{one}/{other}"
        for uri in ((tmp_path.parent / path).as_uri(), "file://" + quote(path)):
            assert library.exported_path(uri.encode()).decode() == path
