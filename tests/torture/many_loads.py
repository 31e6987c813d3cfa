"""An archive extracted, loaded, run and unloaded by the thousand in one process."""

from __future__ import annotations

import sys
from pathlib import Path

from fmpy import read_model_description, simulate_fmu

from .fmus import PLATOONS, path_of
from .many_instances import resident
from .trial import Chunk, Outcome

_WARM_UP = 10  # loads, in which Python imports what is imported once
_MAPPINGS = 16  # more than after the warm-up: the heap's own, which come and go


def held() -> tuple[int, ...]:
    """Mappings of the process, entries of the search path, finders, modules."""
    mappings = len(Path("/proc/self/maps").read_text().splitlines())
    return mappings, len(sys.path), len(sys.path_importer_cache), len(sys.modules)


def run(chunk: Chunk) -> Outcome:
    """The Python and the native platoon in turn, from one chunk to the next."""
    one, outcome = PLATOONS[(chunk.number + 1) % len(PLATOONS)], Outcome()
    archive = str(path_of(one, chunk.fmus))
    description = read_model_description(archive)
    before: tuple[int, ...] = ()
    memory = 0
    for k in range(chunk.count):
        if k == min(_WARM_UP, chunk.count // 2):
            before, memory = held(), resident()
        simulate_fmu(archive, model_description=description, validate=False, stop_time=0.01, step_size=0.01)
        outcome.count += 1
    after = held()
    outcome.tally(f"{one.name} loaded", chunk.count)
    outcome.note(f"{one.name}: more mappings at the end", after[0] - before[0])
    outcome.note(f"{one.name}: growth [bytes per load]", (resident() - memory) / chunk.count)
    if after[0] > before[0] + _MAPPINGS or after[1:] != before[1:]:
        outcome.violate(
            f"{one.name}: after {chunk.count} loads {after} mappings, paths, finders, modules, not {before}"
        )
    return outcome


def tell(outcome: Outcome) -> str:
    """For the summary."""
    counts = [f"{name} {count:,}" for name, count in outcome.tallies.items()]
    return "; ".join([*counts, *(f"{name} {value:.0f}" for name, value in outcome.largest.items())])
