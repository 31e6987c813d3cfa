"""A Python host that measures doStep over one sampling period and getReal of all outputs; protocol as in step_host.c.

python_host.py fmpy|ctypes FOLDER MODEL, then the arguments of step_host
"""

from __future__ import annotations

import sys
import time
from ctypes import CDLL, byref, c_double, c_int, c_size_t, c_uint, c_void_p

from fmpy.fmi2 import FMU2Slave, defaultCallbacks

STEPS, T = 50, 0.01


def bare(library: str, slave: FMU2Slave, references: list[int]):
    """Step and read with as little Python as ctypes allows."""
    loaded = CDLL(library)
    do_step, get_real = loaded.fmi2DoStep, loaded.fmi2GetReal
    do_step.argtypes = [c_void_p, c_double, c_double, c_int]
    get_real.argtypes = [c_void_p, c_void_p, c_size_t, c_void_p]
    numbers, values = (c_uint * len(references))(*references), (c_double * len(references))()
    count, at, into = len(references), byref(numbers), byref(values)

    def run(steps: int) -> None:
        component = slave.component
        for k in range(steps):
            if do_step(component, k * T, T, 1) or get_real(component, at, count, into):
                sys.exit("a call failed")

    return run, lambda: list(values)


def through_fmpy(slave: FMU2Slave, references: list[int]):
    """Step and read as a user of fmpy does."""
    seen: list[list[float]] = [[]]

    def run(steps: int) -> None:
        for k in range(steps):
            slave.doStep(k * T, T)
            seen[0] = slave.getReal(references)

    return run, lambda: seen[0]


def main(which: str, folder: str, model: str, library: str, uri: str, guid: str, *numbers: str) -> None:
    """Answer requests until there are no more."""
    n, outputs, first, s_start, v_start, source = map(int, numbers[:6])
    spacing = float(numbers[6])
    slave = FMU2Slave(guid=guid, unzipDirectory=folder, modelIdentifier=model, instanceName="speed")
    slave.instantiate(callbacks=defaultCallbacks)
    references = list(range(first, first + outputs))
    run, seen = bare(library, slave, references) if which == "ctypes" else through_fmpy(slave, references)
    starts = list(range(s_start, s_start + n - 1)) + list(range(v_start, v_start + n))
    values = [spacing + 0.05 * (i % 5) for i in range(n - 1)] + [30.0 + 0.01 * (i % 7) for i in range(n)]
    print("ready", flush=True)
    for line in sys.stdin:
        segments, seconds = int(line), 0.0
        for _ in range(max(1, segments)):
            slave.reset()
            slave.setupExperiment(startTime=0.0)
            if source >= 0:
                slave.setInteger([source], [2])
                slave.setReal(starts, values)
            slave.enterInitializationMode()
            slave.exitInitializationMode()
            began = time.perf_counter()
            run(STEPS)
            seconds += time.perf_counter() - began
        print(*seen()) if segments == 0 else print(seconds / segments / STEPS, STEPS)
        sys.stdout.flush()


if __name__ == "__main__":
    main(*sys.argv[1:])
