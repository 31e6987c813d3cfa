"""Random starts over all of Omega under policy 3: no exit, no NaN, no stall at any sampling instant.

All of them run in the native FMU's C code, compiled for up to 50 vehicles and, for some numbers of vehicles, for just
these; a sample runs through `SampledPlatoon` as well and must end in the same place.
"""

from __future__ import annotations

import ctypes
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from fmu_src.native.build import native_platoon
from fmu_src.toolchain.compile import FMI_HEADERS, run_compiler
from psp_model import Lemma1Policy, PlatoonParameters, PlatoonState, PotentialParameters, SampledPlatoon, Sampling

from .starts import Array, Lanes, draw
from .trial import Chunk, Outcome

MOST = 50  # vehicles
EXACT = (2, 3, 4, 7, 10, 30)  # numbers of vehicles that every other chunk has compiled for just these
PERIODS = 50  # nominal sampling periods that each start is followed for
STALL = 100_000  # short periods within one: the default of max_short_periods
SAMPLE = 100  # every so manieth start runs through SampledPlatoon too
_FATES = ("", "leaves Omega", "is not finite any more", "stalls")
_STALLED = 3
_FATE, _PERIOD, _INSTANTS, _MOST, _ROOM, _STATE = range(6)
_GIVEN = ("L", "lam", "v_star", "v_max", "epsilon", "mu", "z", "alpha", "r", "p", "hill", "T")


@cache
def library(capacity: int, folder: Path) -> Any:
    """The native FMU's sources with the loop of omega_runs.c, for up to N vehicles.

    Parameters
    ----------
    capacity : N
    folder : where it is built, unless it is there already
    """
    built = folder / f"omega_{capacity}.so"
    if not built.exists():
        sources = folder / f"omega_{capacity}.sources"
        sources.mkdir(parents=True, exist_ok=True)
        for name, content in native_platoon(capacity, {}).sources("{torture}").items():
            (sources / name).write_bytes(content)
        partial = built.with_suffix(".partial")
        command = [sys.executable, "-m", "ziglang", "cc", "-O3", "-std=c11", "-ffp-contract=off", "-fno-math-errno"]
        command += ["-shared", "-fPIC", "-I", str(FMI_HEADERS), "-I", str(sources), "-o", str(partial)]
        command += [*map(str, sorted(sources.glob("*.c"))), str(Path(__file__).with_suffix(".c")), "-lm"]
        assert run_compiler(command, folder), "the compiler's messages are above"
        partial.replace(built)
    return ctypes.CDLL(str(built))


def follow(lanes: Lanes, capacity: int, folder: Path) -> Array:
    """What becomes of every start.

    Parameters
    ----------
    lanes : the starts
    capacity : N of the code to run them with
    folder : for the compiled loop

    Returns
    -------
    (B, 5 + 2n-1) array: fate, period, sampling instants, most short periods in one, smallest s - L [m], s and v
    """
    n, count = lanes.v.shape
    given = np.stack([getattr(lanes, name) for name in _GIVEN], axis=1)
    rows = np.ascontiguousarray(np.concatenate([given, lanes.s.T, lanes.v.T], axis=1))
    ends = np.empty((count, _STATE + 2 * n - 1))
    pointers = [ctypes.c_void_p(array.ctypes.data) for array in (rows, ends)]
    library(capacity, folder).follow(n, count, PERIODS, STALL, *pointers)
    return ends


def by_the_model(lanes: Lanes, lane: int) -> SampledPlatoon:
    """One start, run by psp_model."""
    constants = PlatoonParameters(*(float(getattr(lanes, name)[lane]) for name in _GIVEN[:7]))
    shape = PotentialParameters(*(float(getattr(lanes, name)[lane]) for name in _GIVEN[7:11]))
    start = PlatoonState(lanes.s[:, lane], lanes.v[:, lane], constants)
    platoon = SampledPlatoon.begin(start, shape, sampling=Sampling(float(lanes.T[lane]), Lemma1Policy.SHORTEN))
    platoon.advance_to(PERIODS, 0.0)
    return platoon


def _compare(lanes: Lanes, ends: Array, lane: int, outcome: Outcome) -> None:
    """One of the starts by the model: it must end where the C code ended."""
    now = by_the_model(lanes, lane).now
    apart = float(np.abs(ends[lane, _STATE:] - np.concatenate([now.s, now.v])).max())
    outcome.tally("also run by SampledPlatoon")
    outcome.note("C against SampledPlatoon", apart)
    if not apart < 1e-6:
        outcome.violate(f"C and SampledPlatoon end {apart:g} apart from {_row(lanes, lane)}")


def _row(lanes: Lanes, lane: int) -> str:
    return ", ".join(f"{name} = {value[..., lane].tolist()}" for name, value in vars(lanes).items())


def run_old(chunk: Chunk) -> Outcome:
    """The same with V_old, which lies outside the feasible set: a run may give up, in the way of a clear error."""
    return run(chunk, old=True)


def run(chunk: Chunk, old: bool = False) -> Outcome:
    """Starts of 2 to 50 vehicles, as many of each."""
    outcome = Outcome()
    for vehicles in range(2, MOST + 1):
        count = (chunk.count + vehicles - 2) // 49
        if not count:
            continue
        lanes = draw(np.random.default_rng([7001, chunk.number, vehicles, old]), vehicles, count, old)
        exact = vehicles in EXACT and chunk.number % 2 == 1
        ends = follow(lanes, vehicles if exact else MOST, chunk.fmus)
        outcome.count += count
        outcome.tally("sampling instants", ends[:, _INSTANTS].sum())
        outcome.note("short periods in one", ends[:, _MOST].max())
        outcome.note_least("smallest s - L [m]", ends[:, _ROOM].min())
        given_up = ends[:, _FATE] == _STALLED if old else np.zeros(count, dtype=bool)
        outcome.tally("given up", given_up.sum())
        for lane in np.flatnonzero((ends[:, _FATE] > 0) & ~given_up):
            fate, period = _FATES[int(ends[lane, _FATE])], ends[lane, _PERIOD]
            outcome.violate(f"a run of {vehicles} vehicles {fate} in period {period:g}: {_row(lanes, lane)}")
        for lane in range((-vehicles) % SAMPLE, count, SAMPLE):
            if ends[lane, _INSTANTS] < 2000:  # Python is slow
                _compare(lanes, ends, lane, outcome)
    return outcome


def tell(outcome: Outcome) -> str:
    """For the summary."""
    found, largest = outcome.tallies, outcome.largest
    given_up = f"{found['given up']:,} given up; " if found["given up"] else ""
    room = outcome.smallest["smallest s - L [m]"]
    checked, apart = found.get("also run by SampledPlatoon", 0), largest.get("C against SampledPlatoon", 0.0)
    return (
        f"{given_up}{found['sampling instants']:,} sampling instants; at most "
        f"{largest['short periods in one']:,.0f} short periods in one (stall: {STALL:,}); smallest s - L {room:.2g} m; "
        f"{checked:,} also by SampledPlatoon, at most "
        f"{apart:.1g} apart"
    )
