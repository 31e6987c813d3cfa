"""Ten simulated hours at T = 0.01 s: memory flat, no slow-down, no drift against the model in 80-bit arithmetic."""

from __future__ import annotations

import json
import time
from typing import Any

import numpy as np

from psp_model import BEST_FIXED, PlatoonParameters
from psp_model.law.feedback import feedback
from psp_model.sampling.hold import advance, travelled

from .fmus import PLATOONS, Build, unpacked
from .many_instances import resident
from .raw import WARNING, Library, Raw
from .trial import Chunk, Outcome

T = 0.01
HOUR = 360_000  # sampling periods
GROWTH = 1 << 20  # [bytes] that the process may grow by after the first twentieth
WAY = 1e-9  # most difference of the leader's position, of the way driven
_BLOCKS = 20


def reference(vehicles: int, spacings: list[float], speeds: list[float], periods: int) -> tuple[Any, Any, Any]:
    """Spacings, speeds and the leader's position after so many periods, by psp_model in extended precision.

    Parameters
    ----------
    vehicles : n
    spacings, speeds : at the start [m], [m/s]
    periods : how many
    """
    wide, constants = np.longdouble, PlatoonParameters()
    s, v, x, step = np.array(spacings, wide), np.array(speeds, wide), wide(0), wide(T)
    for _ in range(periods):
        a = feedback(s, v, BEST_FIXED, constants)
        x += travelled(v[0], a[0], step)
        s, v = advance(s, v, a, step)
    return s, v, x


def _run_fmu(one: Build, periods: int, chunk: Chunk, outcome: Outcome) -> Raw:
    """The run itself: a communication step for every sampling period, all outputs read in every hundredth."""
    library = Library(unpacked(one, chunk.fmus, chunk.scratch))
    raw = Raw(library)
    references = {v.name: v.valueReference for v in library.fmu.description.modelVariables}
    raw.set_integer(references["parameter_source"], 2)
    if raw.start() > WARNING:
        outcome.violate(f"{one.name} does not start: {raw.messages}")
    speed, before, block = [], 0, max(1, periods // _BLOCKS)
    for number in range(_BLOCKS):
        began = time.process_time()
        for k in range(number * block, (number + 1) * block):
            if raw.call("DoStep", k * T, T, 1) > WARNING:
                outcome.violate(f"{one.name} stops at t = {k * T} s: {raw.messages[-1:]}")
                return raw
            if k % 100 == 0:
                raw.outputs()
        speed.append(time.process_time() - began)
        before = before or resident()
    grown, slower = resident() - before, float(np.median(speed[-5:]) / np.median(speed[:5]))
    outcome.note(f"{one.name}: growth [kB]", grown / 1024)
    outcome.note(f"{one.name}: last quarter against first, time", slower)
    if grown > GROWTH:
        outcome.violate(f"{one.name} grew by {grown} bytes")
    if slower > 1.5 and periods > HOUR:
        outcome.violate(f"{one.name} became {slower:.2f} times as slow")
    outcome.count += block * _BLOCKS
    return raw


def run(chunk: Chunk) -> Outcome:
    """One platoon FMU, a different one for each chunk; `count` is in sampling periods."""
    outcome, one = Outcome(), PLATOONS[chunk.number % len(PLATOONS)]
    raw = _run_fmu(one, chunk.count, chunk, outcome)
    variables = raw.library.fmu.description.modelVariables
    outputs = dict(zip([v.name for v in variables if v.causality == "output"], raw.outputs(), strict=True))
    starts = {v.name: v.start for v in variables}
    n = raw.library.fmu.vehicles
    spacings = [float(starts[f"s_start[{i}]"]) for i in range(2, n + 1)]
    speeds = [float(starts[f"v_start[{i}]"]) for i in range(1, n + 1)]
    s, v, x = reference(n, spacings, speeds, chunk.count // _BLOCKS * _BLOCKS)
    apart = max(abs(float(outputs[f"s[{i}]"] - s[i - 2])) for i in range(2, n + 1))
    apart = max(apart, *(abs(float(outputs[f"v[{i}]"] - v[i - 1])) for i in range(1, n + 1)))
    outcome.note(f"{one.name}: spacings and speeds apart", apart)
    outcome.note(f"{one.name}: leader apart, of the way", abs(float((outputs["x[1]"] - x) / x)))
    # what double precision leaves open: half a unit in the last place of a spacing (below lambda, 20 m) in every period
    drift = 0.5 * float(np.spacing(20.0)) * chunk.count
    if not apart < drift or not abs(float((outputs["x[1]"] - x) / x)) < WAY:
        outcome.violate(f"{one.name} drifted by {apart} from the reference: {json.dumps(outputs)}")
    raw.free()
    return outcome


def tell(outcome: Outcome) -> str:
    """For the summary."""
    hours = f"{outcome.count * T / 3600:.1f} simulated hours; "
    return hours + "; ".join(f"{name} {value:.2g}" for name, value in outcome.largest.items())
