"""Expressions of CasADi as C: the same numbers bit for bit, choices as selects, nothing that is not needed."""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import Any

import casadi
import numpy as np
import pytest

from fmu_src.errors import BuildError
from fmu_src.native.kernels import kernels_header
from fmu_src.native.scalar_c import c_function
from fmu_src.toolchain.compile import compile_library, host_platform

X, Y, Z = (casadi.SX.sym(name) for name in "xyz")
EXPRESSIONS: dict[str, Any] = {
    "sums": X + Y - Z * X / Y,
    "negated": -X - (-Y) * (-Z),
    "powers": X**3 + casadi.fabs(Y) ** Z + X**-1 + X**2 + 2 * Z,
    "roots": casadi.sqrt(casadi.fabs(X)) + casadi.log(casadi.fabs(Y)) + casadi.exp(Z / 10),
    "bounds": casadi.fmin(X, Y) + 3 * casadi.fmax(Y, Z) - casadi.sign(X),
    "choice": casadi.if_else(X < Y, X * Z, Y / Z),
    "choices": casadi.if_else(casadi.logic_and(X < Y, Y <= Z), 1.0, casadi.if_else(X == 0.5, Y, -casadi.inf)),
    "either": casadi.if_else(casadi.logic_or(X > Y, casadi.logic_not(Z != Y)), 1e-300, 1 / 3),
    "one_side": casadi.if_else(X < Y, Z, 0.0),
    "constants": casadi.if_else(X < Y, -2.5, Z),
}
INPUTS = [
    *np.random.default_rng(0).normal(0, 2, (500, 3)).tolist(),
    [0.5, 0.25, 0.25],
    [0.0, 1.0, 1.0],
    [2.0, 2.0, 2.0],
]


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """The expressions as exported functions, and all of them as one function with several results."""
    text = "#include <math.h>\n" + "".join(c_function(name, [X, Y, Z], [one]) for name, one in EXPRESSIONS.items())
    text += c_function("all", [X, Y, Z], list(EXPRESSIONS.values()))
    exported = '__attribute__((visibility("default")))'
    for name in EXPRESSIONS:
        text += f"{exported} double {name}(double x, double y, double z) {{ return psp_{name}(x, y, z); }}\n"
    pointers = ", ".join(f"out + {place}" for place in range(len(EXPRESSIONS)))
    text += f"{exported} void all(double x, double y, double z, double *out) {{ psp_all(x, y, z, {pointers}); }}\n"
    path: Path = tmp_path_factory.mktemp("kernels") / "kernels.so"
    path.write_bytes(compile_library(host_platform(), "kernels", {"kernels.c": text.encode()}))
    loaded = ctypes.CDLL(str(path))
    for name in EXPRESSIONS:
        getattr(loaded, name).restype = ctypes.c_double
        getattr(loaded, name).argtypes = [ctypes.c_double] * 3
    loaded.all.argtypes = [ctypes.c_double] * 3 + [ctypes.POINTER(ctypes.c_double)]
    return loaded


def test_every_operation_gives_the_numbers_of_casadi(library: ctypes.CDLL) -> None:
    function = casadi.Function("all", [X, Y, Z], list(EXPRESSIONS.values()))
    for values in INPUTS:
        expected = [float(one) for one in function(*values)]
        seen = [getattr(library, name)(*values) for name in EXPRESSIONS]
        together = (ctypes.c_double * len(EXPRESSIONS))()
        library.all(*values, together)
        np.testing.assert_array_equal(seen, list(together))
        np.testing.assert_allclose(seen, expected, rtol=1e-15, atol=0)  # another libm's pow, log and exp


def test_a_choice_is_one_select_and_the_rest_of_it_is_gone() -> None:
    text = c_function("choice", [X, Y, Z], [EXPRESSIONS["choice"]])
    assert text.count("?") == 1 and " : 0.0" not in text and "!" not in text and " + " not in text
    text = c_function("one_side", [X, Y, Z], [EXPRESSIONS["one_side"]])
    assert text.count("?") == 1 and " : 0.0)" in text


def test_an_operation_that_is_not_known_is_refused() -> None:
    with pytest.raises(BuildError, match="is not known here"):
        c_function("sine", [X], [casadi.sin(X)])


def test_the_model_needs_no_other_operations_and_its_kernels_are_inlined() -> None:
    header = kernels_header()
    assert header.count("static inline") == header.count(" psp_") - 1 and "casadi" not in header
