"""Saved states: the same future here, in another instance and in another process; refused where they do not belong.

States are promised for the very build that saved them (fmu_src/c/front_state.c), so a state of one FMU or runtime must
be refused by all others, and so must any that was cut or had a bit flipped.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from ctypes import byref, c_char, c_size_t, c_void_p
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .fmus import BUILDS, Build, unpacked
from .raw import ERROR, OK, WARNING, Library, Raw
from .trial import Chunk, Outcome

_STEPS = (0.01, 0.005, 0.0033, 0.02, 0.0, 0.013)
DAMAGED = 20  # spoiled copies of each state


@dataclass(frozen=True)
class Kept:
    """A state, when it was saved, and what came after it.

    Attributes
    ----------
    data : serialised
    time : [s]
    steps : communication steps taken after it [s]
    future : outputs after each of them
    """

    data: bytes
    time: float
    steps: tuple[float, ...]
    future: tuple[tuple[float, ...], ...]


def drive(raw: Raw, time: float, steps: tuple[float, ...]) -> tuple[tuple[float, ...], ...] | None:
    """Outputs after each step, inputs set anew before each; None where a step fails.

    Parameters
    ----------
    raw : the instance
    time, steps : where it is, and the communication steps [s]
    """
    seen = []
    inputs = [v for v in raw.library.fmu.description.modelVariables if v.causality == "input"]
    for size in steps:
        raw.set_reals([v.valueReference for v in inputs], [float(v.start) for v in inputs])
        if raw.call("DoStep", time, size, 1) > WARNING:
            return None
        time += size
        seen.append(raw.outputs())
    return tuple(seen)


def serialised(raw: Raw, handle: c_void_p) -> bytes:
    """A saved state as bytes."""
    size = c_size_t()
    assert raw.call("SerializedFMUstateSize", handle, byref(size)) == OK
    buffer = (c_char * size.value)()
    assert raw.call("SerializeFMUstate", handle, buffer, size.value) == OK
    return bytes(buffer)


def restored(raw: Raw, data: bytes) -> int:
    """Give an instance a serialised state; the worst status."""
    handle = c_void_p()
    status = raw.call("DeSerializeFMUstate", (c_char * len(data)).from_buffer_copy(data), len(data), byref(handle))
    if status <= WARNING:
        status = max(status, raw.call("SetFMUstate", handle))
        raw.call("FreeFMUstate", byref(handle))
    return status


def _case(raw: Raw, rng: np.random.Generator, outcome: Outcome) -> Kept | None:
    """Save somewhere in a run, go on, come back, go on again: both futures are the same."""
    raw.call("Reset")
    reference = {v.name: v.valueReference for v in raw.library.fmu.description.modelVariables}
    parameters = {"mu": rng.uniform(0.3, 0.9), "parameter_source": 2, "potential": rng.integers(1, 3)}
    for name, value in parameters.items():
        whole = reference[name] in raw.library.integers
        _ = raw.set_integer(reference[name], int(value)) if whole else raw.set_reals([reference[name]], [float(value)])
    before, after = (tuple(rng.choice(_STEPS, int(rng.integers(0, 12))).tolist()) for _ in range(2))
    if raw.start() > WARNING or drive(raw, 0.0, before) is None:
        outcome.violate(f"{raw.library.fmu.path.name} does not run: {raw.messages[-1:]}")
        return None
    time, handle, here = sum(before), c_void_p(), raw.outputs()
    assert raw.call("GetFMUstate", byref(handle)) == OK
    data = serialised(raw, handle)
    future = drive(raw, time, after)
    if raw.call("SetFMUstate", handle) != OK or raw.outputs() != here or drive(raw, time, after) != future:
        outcome.violate(f"{raw.library.fmu.path.name}: a restored state has another future, saved at t = {time} s")
    raw.call("FreeFMUstate", byref(handle))
    return Kept(data, time, after, future or ())


def same_future(raw: Raw, kept: Kept) -> bool:
    """Whether a state has the same future in this instance."""
    return restored(raw, kept.data) == OK and drive(raw, kept.time, kept.steps) == kept.future


def _damaged(raw: Raw, kept: Kept, rng: np.random.Generator, outcome: Outcome) -> None:
    for _ in range(DAMAGED):
        spoiled = bytearray(kept.data)
        if rng.random() < 0.3:
            del spoiled[int(rng.integers(1, len(spoiled))) :]
        else:
            spoiled[int(rng.integers(len(spoiled)))] ^= 1 << int(rng.integers(8))
        raw.messages.clear()
        status = restored(raw, bytes(spoiled))
        outcome.tally("damaged states refused", status == ERROR)
        if status != ERROR or not raw.messages or "state" not in raw.messages[-1]:
            outcome.violate(f"{raw.library.fmu.path.name}: a damaged state gave {status}: {raw.messages}")
        raw.call("Reset")


def _elsewhere(one: Build, kept: list[Kept], chunk: Chunk, outcome: Outcome) -> None:
    """The same states in another process."""
    for number, state in enumerate(kept):
        (chunk.scratch / f"{number}.state").write_bytes(state.data)
    about = [(state.time, state.steps, state.future) for state in kept]
    (chunk.scratch / "states.json").write_text(json.dumps(about))
    command = [sys.executable, "-m", "torture.saved_states", one.name, str(chunk.scratch), str(chunk.fmus)]
    ran = subprocess.run(command, capture_output=True, text=True, env=os.environ, check=False)
    same = ran.stdout.split()[-1:] if ran.returncode == 0 else []
    outcome.tally("in another process", len(kept))
    if same != [str(len(kept))]:
        outcome.violate(f"{one.name}: of {len(kept)} states {same} went on alike elsewhere: {ran.stderr[-300:]}")


def run_on(one: Build, chunk: Chunk, outcome: Outcome) -> None:
    """States of one FMU.

    Parameters
    ----------
    one : the FMU
    chunk : how many cases, and which
    outcome : that counts and violations go into
    """
    rng = np.random.default_rng([7005, chunk.number, sum(map(ord, one.name))])
    library = Library(unpacked(one, chunk.fmus, chunk.scratch))
    raw, other, kept = Raw(library), Raw(library, "other"), []
    for _ in range(chunk.count):
        outcome.count += 1
        outcome.tally(one.name)
        state = _case(raw, rng, outcome)
        if state is None:
            continue
        kept.append(state)
        if not same_future(other, state):
            outcome.violate(f"{one.name}: another instance goes on differently from t = {state.time} s")
        _damaged(other, state, rng, outcome)
    for foreign in (b for b in BUILDS if b is not one):
        stranger = Raw(Library(unpacked(foreign, chunk.fmus, chunk.scratch)))
        if kept and restored(stranger, kept[-1].data) != ERROR:
            outcome.violate(f"{foreign.name} took a state of {one.name}")
        outcome.tally("refused by another FMU or runtime")
        stranger.free()
    raw.free()
    other.free()
    _elsewhere(one, kept, chunk, outcome)


def run(chunk: Chunk) -> Outcome:
    """One FMU after the other, a different one for each chunk."""
    outcome = Outcome()
    run_on(BUILDS[chunk.number % len(BUILDS)], chunk, outcome)
    return outcome


def tell(outcome: Outcome) -> str:
    """For the summary."""
    return ", ".join(f"{name} {count:,}" for name, count in outcome.tallies.items())


def main(name: str, folder: str, fmus: str) -> None:
    """What the other process does: prints how many of the states go on as they did."""
    one = next(b for b in BUILDS if b.name == name)
    raw = Raw(Library(unpacked(one, Path(fmus), Path(folder) / "again")))
    same = 0
    for number, (time, steps, future) in enumerate(json.loads((Path(folder) / "states.json").read_text())):
        data = (Path(folder) / f"{number}.state").read_bytes()
        same += same_future(raw, Kept(data, time, tuple(steps), tuple(map(tuple, future))))
    raw.free()
    print(same)


if __name__ == "__main__":
    main(*sys.argv[1:])
