"""Rollouts of the closed loop by the million: the model's own step, written to C by CasADi, compiled for this machine.

There is no second copy of the dynamics here: `_step` calls the model's own period with CasADi symbols.  The C code
runs 32 rollouts side by side in vector instructions, about 20 times faster than the same functions batched by JAX on
the same core (benchmarks/offline_speed.py).
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

from ...errors import EngineError
from ...law.controller import PaperLaw
from ...law.potential import PotentialParameters
from ...objective import HORIZON
from ...parameters import ObjectiveWeights, PlatoonParameters, generic
from ...sampling.hold import IDEAL
from ...sampling.period import decide, hold

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
class _Form:
    """What a compiled engine works in and what it gives.

    Attributes
    ----------
    real : "float" or "double"
    sums, lows, highs : how many numbers of a period are added up, and of how many the smallest or largest counts
    kept : whether the final state is given, too
    """

    real: str
    sums: int
    lows: int
    highs: int = 0
    kept: bool = False


_COSTS = {"float": _Form("float", sums=1, lows=0), "double": _Form("double", sums=1, lows=1)}
_SUMMARY = _Form("double", sums=2, lows=2, highs=1, kept=True)


def _step(problem: Problem, form: _Form) -> str:
    """C source of one sampling period: (s, v), (alpha, r, p, hill) -> (s, v, numbers of `form`), from the model."""
    import casadi

    n, T = problem.vehicles, problem.T
    s: Any = casadi.SX.sym("s", n - 1)
    v: Any = casadi.SX.sym("v", n)
    origin: Any = casadi.SX(0.0)
    symbols = casadi.SX.sym("shape", 4 if form.kept else 3)  # the search knows potentials with a hill only
    names = ("alpha", "r", "p", "hill")[: symbols.numel()]
    shape = generic(PotentialParameters, **{name: symbols[place] for place, name in enumerate(names)})
    law, vehicles = PaperLaw(shape, problem.constants), IDEAL.begin(origin, s, v)
    _, a, T_max = decide(law, None, vehicles)
    after, added = hold(IDEAL, vehicles, a, T, problem.weights)
    if form.kept:
        numbers: list[Any] = [*added, T_max, casadi.mmin(after.s), casadi.mmax(casadi.fabs(a))]
    else:
        numbers = [sum(added), *([T_max] if form.lows else [])]
    out = casadi.vertcat(after.s, after.v, *numbers)
    function = casadi.Function("step", [casadi.vertcat(s, v), symbols], [out], {"cse": True})
    options: dict[str, Any] = {"with_header": False, "casadi_real": "REAL", "casadi_int": "int", "include_math": False}
    generator = casadi.CodeGenerator("step", options)
    generator.add(function)
    return str(generator.dump())


def _source(problem: Problem, form: _Form) -> str:
    """The whole C file for one problem."""
    single = form.real == "float"
    sizes = {"VEHICLES": problem.vehicles, "SHAPE": 4 if form.kept else 3, "KEPT": int(form.kept)}
    sizes |= {"SUMS": form.sums, "LOWS": form.lows, "HIGHS": form.highs}
    constants = ", ".join(f"{name} = {size}" for name, size in sizes.items())
    head = ["#include <stddef.h>", "#include <stdint.h>", f"typedef {form.real} REAL;", f"enum {{ {constants} }};"]
    head.append((_HERE / "vector_math.h").read_text() if single else "#include <math.h>")
    # CasADi defines it as `static int`: what was declared before holds on, and the lanes need it inlined
    head.append("static inline __attribute__((always_inline)) int step_f0(const REAL **, REAL **, int *, REAL *, int);")
    return "\n".join([*head, _step(problem, form), (_HERE / "rollouts.c").read_text()])


def _cache() -> Path:
    """Where compiled engines are kept."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "psp-platoon"


def _library(problem: Problem, form: _Form) -> ctypes.CDLL:
    """The compiled engine, from the cache where it has been built before."""
    source = _source(problem, form)
    command = [sys.executable, "-m", "ziglang", "cc", *_FLAGS[form.real], *_COMMON]
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
                raise EngineError(
                    f"the rollouts could not be compiled ({reason}): mend what that names, or install ziglang anew"
                )
            built.replace(path)
    return ctypes.CDLL(str(path))


def _cpuinfo() -> list[str]:
    """What Linux says of the processor; the compiled code is for this one only."""
    path = Path("/proc/cpuinfo")
    return path.read_text().splitlines() if path.exists() else []


@dataclass(frozen=True, eq=False)
class Summaries:
    """What N rollouts came to.

    Attributes
    ----------
    cost : (N, 2) terms of J, of acceleration and of spacings
    T_max : (N,) smallest bound of Lemma 1 on the way [s]
    s_min : (N,) smallest spacing at any sampling instant after the first [m]
    a_peak : (N,) largest |acceleration| [m/s2]
    s, v : (N, n-1) spacings [m] and (N, n) speeds [m/s] at the end
    """

    cost: Array
    T_max: Array
    s_min: Array
    a_peak: Array
    s: Array
    v: Array


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
    def _of_costs(self) -> Any:
        return _library(self.problem, _COSTS[self.real]).rollouts

    @cached_property
    def _of_summaries(self) -> Any:
        return _library(self.problem, _SUMMARY).rollouts

    def costs(self, starts: Array, which: Array, triples: Array) -> tuple[Array, Array]:
        """J of every rollout, and the smallest T_max on the way.

        Parameters
        ----------
        starts : (B, 2n-1) array, spacings [m] then speeds [m/s] of each start
        which : (N,) array, the start of each rollout
        triples : (N, 3) array, alpha [1], r [m], p [1] of each rollout

        Returns
        -------
        J : (N,) array
        T_max : (N,) array, smallest bound of Lemma 1 [s]; in "double" only, 0 otherwise
        """
        form = _COSTS[self.real]
        found = self._run(self._of_costs, form, starts, which, triples)
        J = np.ascontiguousarray(found[:, 0])
        return J, np.ascontiguousarray(found[:, 1]) if form.lows else np.zeros_like(J)

    def summaries(self, starts: Array, which: Array, shapes: Array) -> Summaries:
        """What every rollout came to, always in double precision.

        Parameters
        ----------
        starts, which : as for `costs`
        shapes : (N, 4) array, alpha [1], r [m], p [1] and hill [1] of each rollout
        """
        found, n = self._run(self._of_summaries, _SUMMARY, starts, which, shapes), self.problem.vehicles
        ends = found[:, 5:]
        return Summaries(found[:, :2], found[:, 2], found[:, 3], found[:, 4], ends[:, : n - 1], ends[:, n - 1 :])

    def _run(self, rollouts: Any, form: _Form, starts: Array, which: Array, shapes: Array) -> Array:
        """The (N, results) numbers that the compiled engine gives, piece by piece."""
        dtype = np.float32 if form.real == "float" else np.float64
        starts = np.ascontiguousarray(starts, dtype=dtype)
        which = np.ascontiguousarray(which, dtype=np.int32)
        shapes = np.ascontiguousarray(shapes, dtype=dtype)
        state = 2 * self.problem.vehicles - 1 if form.kept else 0
        results = np.empty((which.size, form.sums + form.lows + form.highs + state), dtype)
        steps = round(self.problem.horizon / self.problem.T)

        def piece(first: int) -> None:
            part = slice(first, first + _PIECE)
            arrays = (starts, which[part], shapes[part], results[part])
            pointers = [ctypes.c_void_p(array.ctypes.data) for array in arrays]
            rollouts(which[part].size, steps, *pointers)

        firsts = range(0, which.size, _PIECE)
        with ThreadPoolExecutor(self.threads or os.cpu_count()) as pool:
            list(pool.map(piece, firsts))
        return results
