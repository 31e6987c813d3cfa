"""The native FMUs under ThreadSanitizer, AddressSanitizer, LeakSanitizer and UBSan."""

from __future__ import annotations

import subprocess
from functools import cache
from pathlib import Path

from fmu_src.native.components import NATIVE, native_fmu
from fmu_src.networks import networks_up_to
from fmu_src.toolchain.compile import FMI_HEADERS, run_compiler
from native.fuzz import run as fuzzing

from .trial import Chunk, Outcome

SANITIZERS = {"thread": "-fsanitize=thread", "address": "-fsanitize=address,undefined,float-cast-overflow"}
VEHICLES = 7
FEW = 100  # lives, below which compiling all of them is not worth it


def _sources(component: str) -> dict[str, bytes]:
    return native_fmu(component, VEHICLES, networks_up_to(VEHICLES)).sources("{torture}")


@cache
def program(component: str, sanitizer: str, folder: Path) -> Path:
    """threads.c with a native FMU and a sanitizer, compiled.

    Parameters
    ----------
    component : of NATIVE
    sanitizer : of SANITIZERS
    folder : where it is built, unless it is there already
    """
    built = folder / f"threads_{component}_{sanitizer}"
    if not built.exists():
        sources = folder / f"threads_{component}.sources"
        sources.mkdir(parents=True, exist_ok=True)
        for name, content in _sources(component).items():
            (sources / name).write_bytes(content)
        files = [Path(__file__).parent / "threads.c", *sorted(sources.glob("*.c"))]
        command = [str(fuzzing.compiler()), "-std=gnu11", "-O1", "-g", SANITIZERS[sanitizer]]
        command += ["-fno-sanitize-recover=all", "-I", str(FMI_HEADERS), "-I", str(sources), "-o", str(built)]
        command += [*map(str, files), "-lm", "-lpthread"]
        assert run_compiler(command, folder), "the compiler's messages are above"
    return built


def run(chunk: Chunk) -> Outcome:
    """The native FMUs under both sanitizers; `count` lives in each thread."""
    outcome = Outcome()
    pairs = [(component, sanitizer) for component in NATIVE for sanitizer in SANITIZERS]
    for component, sanitizer in pairs if chunk.count >= FEW else pairs[:1]:
        command = [str(program(component, sanitizer, chunk.fmus)), str(chunk.count)]
        ran = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
        outcome.count += 2 * chunk.count
        outcome.tally(f"{component}, {sanitizer}", 2 * chunk.count)
        if ran.returncode or ran.stderr:
            outcome.violate(f"{component} under {sanitizer}: {ran.returncode} {ran.stderr[:500]}")
    return outcome


def fuzz(chunk: Chunk) -> Outcome:
    """libFuzzer with AddressSanitizer and UBSan on one of the native FMUs; `count` is in seconds."""
    outcome, component = Outcome(), NATIVE[chunk.number % len(NATIVE)]
    ran = fuzzing.fuzz(chunk.count, component=component)
    found = [line.split()[-1] for line in ran.stderr.splitlines() if "number_of_executed_units" in line]
    outcome.count += int(found[-1]) if found else 0
    outcome.tally(f"{component}, inputs", outcome.count)
    if ran.returncode or not found:
        outcome.violate(f"the fuzzer of the {component} ended with {ran.returncode}: {ran.stderr[-500:]}")
    return outcome


def tell(outcome: Outcome) -> str:
    """For the summary."""
    return ", ".join(f"{name} {count:,}" for name, count in outcome.tallies.items())
