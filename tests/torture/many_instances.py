"""Thousands of instances, two threads with one each, and instances freed in the middle of a step."""

from __future__ import annotations

import os
import threading
import time
from ctypes import byref, c_void_p
from pathlib import Path

import numpy as np

from .fmus import BUILDS, Build, unpacked
from .raw import OK, WARNING, Library, Raw
from .saved_states import drive
from .trial import Chunk, Outcome

LEAK = 2 << 20  # [bytes] that the process may grow by while all these instances come and go
_WARM_UP = 0.2  # of the cycles, in which allocators and caches fill


def resident() -> int:
    """Memory that this process holds [bytes]."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE")


def _life(library: Library, rng: np.random.Generator) -> None:
    """An instance that is freed in any state, saved states and all."""
    raw = Raw(library)
    if rng.random() < 0.7:
        raw.start()
        for k in range(int(rng.integers(0, 3))):
            raw.call("DoStep", 0.01 * k, 0.01, 1)
        raw.outputs()
        for _ in range(int(rng.integers(0, 3))):
            raw.call("GetFMUstate", byref(c_void_p()))  # freed with the instance
    if rng.random() < 0.2:
        raw.call("Terminate")
    if rng.random() < 0.2:
        raw.call("DoStep", -1.0, -1.0, 1)  # ends in the state error
    raw.free()


def lives(one: Build, library: Library, chunk: Chunk, outcome: Outcome) -> None:
    """Instances one after the other, ten alive at a time now and then; memory stays flat.

    Parameters
    ----------
    one, library : the FMU
    chunk : how many, and which
    outcome : that counts and violations go into
    """
    rng = np.random.default_rng([7006, chunk.number])
    before = 0
    for k in range(chunk.count):
        if k == int(_WARM_UP * chunk.count):
            before = resident()
        if k % 100 == 0:
            together = [Raw(library, f"{i}") for i in range(10)]
            for raw in together:
                raw.free()
        _life(library, rng)
    grown = resident() - before
    outcome.count += chunk.count
    outcome.tally(f"{one.name} freed", chunk.count)
    outcome.note(f"{one.name}: growth [bytes per instance]", grown / max(1, (1 - _WARM_UP) * chunk.count))
    if grown > LEAK:
        outcome.violate(f"{one.name}: {chunk.count} instances came and went, and {grown} bytes stayed")


def _guarded(work: threading.Thread, wrong: list[str], what: str) -> None:
    work.join(60)
    if work.is_alive():
        wrong.append(f"{what} hangs")


def two_threads(one: Build, library: Library, chunk: Chunk, outcome: Outcome) -> None:
    """Two threads with an instance each, made and freed there: both get what a single thread gets.

    Parameters
    ----------
    one, library, chunk, outcome : as for `lives`
    """
    steps = (0.01, 0.005, 0.02) * 5

    def whole(name: str) -> object:
        raw = Raw(library, name)
        seen = drive(raw, 0.0, steps) if raw.start() <= WARNING else None
        raw.free()
        return seen

    expected, wrong = whole("alone"), list[str]()

    def work(name: str) -> None:
        for _ in range(max(1, chunk.count // 20)):
            if whole(name) != expected:
                wrong.append(f"thread {name} got something else")

    threads = [threading.Thread(target=work, args=(f"{k}",), daemon=True) for k in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        _guarded(thread, wrong, "a thread")
    outcome.count += 2 * max(1, chunk.count // 20)
    outcome.tally(f"{one.name} in two threads", 2 * max(1, chunk.count // 20))
    for what in wrong:
        outcome.violate(f"{one.name}: {what}")


def freed_while_stepping(one: Build, library: Library, chunk: Chunk, outcome: Outcome) -> None:
    """One thread steps, the other frees the instance: that is refused while the step runs, and the step ends well.

    Parameters
    ----------
    one, library, chunk, outcome : as for `lives`
    """
    rng, long = np.random.default_rng([7007, chunk.number]), 30_000.0 if one.native else 60.0
    for _ in range(max(1, chunk.count // 100)):
        raw, status = Raw(library), [-1]
        reference = {v.name: v.valueReference for v in library.fmu.description.modelVariables}
        if "bad_input" in reference:  # measured once only: go on with the safe action
            raw.set_integer(reference["bad_input"], 2)
        if raw.start() > WARNING:
            outcome.violate(f"{one.name} does not start: {raw.messages}")
        raw.messages.clear()

        begun = threading.Event()

        def step(raw: Raw = raw, status: list[int] = status, begun: threading.Event = begun) -> None:
            begun.set()
            status[0] = raw.call("DoStep", 0.0, long, 1)

        thread = threading.Thread(target=step, daemon=True)
        thread.start()
        begun.wait()
        time.sleep(float(rng.uniform(0.03, 0.06)))  # an instance freed before the step begins is gone for good
        stepping = status[0] == -1
        library.functions.fmi2FreeInstance(raw.component)
        refused = any("fmi2FreeInstance was called while another call" in said for said in raw.messages)
        thread.join(60)
        outcome.count += 1
        outcome.tally(f"{one.name}: freed in a step, refused", refused)
        if not stepping and not refused:
            continue  # the step had ended: freed for good
        if thread.is_alive() or (refused and not OK <= status[0] <= WARNING):
            outcome.violate(f"{one.name}: the step came to {status[0]} when the instance was freed: {raw.messages}")
        if refused:
            raw.free()


def run(chunk: Chunk) -> Outcome:
    """One FMU after the other, a different one for each chunk; those that run in Python get a tenth of the cases."""
    outcome, one = Outcome(), BUILDS[chunk.number % len(BUILDS)]
    count = chunk.count if one.native else max(10, chunk.count // 10)
    part = Chunk(chunk.number, count, chunk.scratch, chunk.fmus)
    library = Library(unpacked(one, chunk.fmus, chunk.scratch))  # once: a loaded library must not be written over
    for trial in (lives, two_threads, freed_while_stepping):
        trial(one, library, part, outcome)
    return outcome


def tell(outcome: Outcome) -> str:
    """For the summary."""
    counts = [f"{name} {count:,}" for name, count in outcome.tallies.items()]
    return "; ".join([*counts, *(f"{name} {value:.0f}" for name, value in outcome.largest.items())])
