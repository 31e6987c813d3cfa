"""Rollouts of the closed loop by the million: the model's own step, written to C by CasADi, compiled for this machine.

There is no second copy of the dynamics here: `_step` calls psp_model with CasADi symbols.  The C code runs 32 rollouts
side by side in vector instructions, about 20 times faster than the same functions batched by JAX on the same core
(benchmarks/offline_speed.py).
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...law.feedback import feedback
from ...objective import HORIZON, running_cost
from ...offline.errors import OfflineError
from ...parameters import ObjectiveWeights, PlatoonParameters
from ...sampling.hold import advance
from ...sampling.lemma1 import largest_period

Array = NDArray[Any]

_HERE = Path(__file__).parent
_PIECE = 4096  # rollouts that one thread takes at a time
_COMMON = ["-O3", "-march=native", "-fopenmp-simd", "-shared", "-fPIC", "-std=c11", "-x", "c", "-"]
_FLAGS = {"float": ["-ffast-math", "-mprefer-vector-width=512"], "double": ["-ffp-contract=off"]}


@dataclass(frozen=True)
class Problem:
    """What a rollout depends on besides its start and its (alpha, r, p).

    Attributes
    ----------
    vehicles : n
    constants, weights : of the model and of the objective
    T : sampling period [s]
    horizon : [s], a multiple of T
    """

    vehicles: int = 7
    constants: PlatoonParameters = field(default_factory=PlatoonParameters)
    weights: ObjectiveWeights = field(default_factory=ObjectiveWeights)
    T: float = 0.01
    horizon: float = HORIZON


@dataclass(frozen=True)
class _Shape:
    """alpha, r, p as symbols."""

    alpha: Any
    r: Any
    p: Any
    hill: float = 1.0


def _step(problem: Problem, with_period: bool) -> str:
    """C source of one sampling period: (s, v), (alpha, r, p) -> (s, v, added to J, T_max), written from the model."""
    import casadi

    n, constants, T = problem.vehicles, problem.constants, problem.T
    s, v, triple = casadi.SX.sym("s", n - 1), casadi.SX.sym("v", n), casadi.SX.sym("triple", 3)
    a = feedback(s, v, _Shape(triple[0], triple[1], triple[2]), constants)
    of_acceleration, of_gaps = running_cost(s, v, a, T, problem.weights)
    period = largest_period(s, v, a, constants) if with_period else casadi.SX(0.0)
    s1, v1 = advance(s, v, a, T)
    out = casadi.vertcat(s1, v1, of_acceleration + of_gaps, period)
    function = casadi.Function("step", [casadi.vertcat(s, v), triple], [out], {"cse": True})
    options: dict[str, Any] = {"with_header": False, "casadi_real": "REAL", "casadi_int": "int", "include_math": False}
    generator = casadi.CodeGenerator("step", options)
    generator.add(function)
    return str(generator.dump())


def _source(problem: Problem, real: str) -> str:
    """The whole C file for one problem in `float` or `double`."""
    single = real == "float"
    head = ["#include <stdint.h>", f"typedef {real} REAL;", f"enum {{ VEHICLES = {problem.vehicles} }};"]
    head.append((_HERE / "vector_math.h").read_text() if single else "#include <math.h>")
    step = _step(problem, with_period=not single)
    step = step.replace("static int casadi_f0", "static inline __attribute__((always_inline)) int casadi_f0", 1)
    return "\n".join([*head, step, (_HERE / "rollouts.c").read_text()])


def _cache() -> Path:
    """Where compiled engines are kept."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "psp-platoon"


def _library(problem: Problem, real: str) -> ctypes.CDLL:
    """The compiled engine, from the cache where it has been built before."""
    source = _source(problem, real)
    command = [sys.executable, "-m", "ziglang", "cc", *_FLAGS[real], *_COMMON]
    machine = next((line for line in _cpuinfo() if line.startswith("flags")), "")
    name = hashlib.sha256("\0".join([source, *command, machine]).encode()).hexdigest()[:24]
    path = _cache() / f"{name}.so"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path.parent) as folder:
            built = Path(folder) / path.name
            done = subprocess.run([*command, "-o", str(built)], input=source, text=True, capture_output=True)
            if done.returncode:
                reason = done.stderr.strip().splitlines()[0] if done.stderr.strip() else "no message"
                raise OfflineError(
                    f"the rollouts could not be compiled ({reason}): mend what that names, or install ziglang anew"
                )
            built.replace(path)
    return ctypes.CDLL(str(path))


def _cpuinfo() -> list[str]:
    """What Linux says of the processor; the compiled code is for this one only."""
    path = Path("/proc/cpuinfo")
    return path.read_text().splitlines() if path.exists() else []


@dataclass(frozen=True)
class Engine:
    """Rolls out many (start, triple) pairs at once; threads share the work, and the result does not depend on how.

    Attributes
    ----------
    problem : what is rolled out
    real : "float" (vector instructions, J good to about 1e-5 of its size) or "double" (with Lemma 1's bound)
    threads : how many to use; None for one per core
    """

    problem: Problem
    real: str = "float"
    threads: int | None = None

    def __getstate__(self) -> dict[str, Any]:  # the library is loaded again where it is needed
        return {"problem": self.problem, "real": self.real, "threads": self.threads}

    @cached_property
    def _function(self) -> Any:
        return _library(self.problem, self.real).rollouts

    def costs(self, starts: Array, which: Array, triples: Array) -> tuple[Array, Array]:
        """J of every rollout, and the smallest T_max on the way.

        Parameters
        ----------
        starts : (B, 2n-1) array, gaps [m] then speeds [m/s] of each start
        which : (N,) array, the start of each rollout
        triples : (N, 3) array, alpha [1], r [m], p [1] of each rollout

        Returns
        -------
        J : (N,) array
        T_max : (N,) array, smallest bound of Lemma 1 [s]; in "double" only, 0 otherwise
        """
        dtype = np.float32 if self.real == "float" else np.float64
        starts = np.ascontiguousarray(starts, dtype=dtype)
        which = np.ascontiguousarray(which, dtype=np.int32)
        triples = np.ascontiguousarray(triples, dtype=dtype)
        J, T_max = np.empty(which.size, dtype), np.empty(which.size, dtype)
        steps = round(self.problem.horizon / self.problem.T)

        def piece(first: int) -> None:
            part = slice(first, first + _PIECE)
            arrays = (starts, which[part], triples[part], J[part], T_max[part])
            pointers = [ctypes.c_void_p(array.ctypes.data) for array in arrays]
            rollouts(which[part].size, steps, *pointers)

        rollouts = self._function  # compiled before the threads start, so that they do not compile it twice
        firsts = range(0, which.size, _PIECE)
        with ThreadPoolExecutor(self.threads or os.cpu_count()) as pool:
            list(pool.map(piece, firsts))
        return J, T_max
