"""Many instances of one FMU in one process, bare ctypes; protocol as in step_host.c, a step is one of one instance.

many_host.py COUNT FOLDER MODEL LIBRARY RESOURCE_URI GUID OUTPUTS FIRST_OUTPUT
A line 0 is answered with the memory that all instances take [bytes] and the seconds to make and initialise one.
"""

from __future__ import annotations

import sys
import time
from ctypes import c_double, c_uint
from pathlib import Path

from fmpy.fmi2 import FMU2Slave, defaultCallbacks

T = 0.01


def resident() -> int:
    """Bytes of this process in memory that it shares with nobody."""
    lines = Path("/proc/self/smaps_rollup").read_text().splitlines()
    return sum(1024 * int(line.split()[1]) for line in lines if line.startswith(("Private_Clean", "Private_Dirty")))


def main(count: str, folder: str, model: str, library: str, uri: str, guid: str, outputs: str, first: str) -> None:
    """Answer requests until there are no more."""
    before, began, slaves = resident(), time.perf_counter(), []
    for k in range(int(count)):
        slave = FMU2Slave(guid=guid, unzipDirectory=folder, modelIdentifier=model, instanceName=f"i{k}")
        slave.instantiate(callbacks=defaultCallbacks)
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        slaves.append(slave)
    seconds, size = (time.perf_counter() - began) / len(slaves), int(outputs)
    references, values = (c_uint * size)(*range(int(first), int(first) + size)), (c_double * size)()
    components = [slave.component for slave in slaves]
    do_step, get_real, periods = slaves[0].fmi2DoStep, slaves[0].fmi2GetReal, 0

    def step() -> None:
        nonlocal periods
        for component in components:
            do_step(component, periods * T, T, 1)
            get_real(component, references, size, values)
        periods += 1

    step()
    memory = resident() - before
    print("ready", flush=True)
    for line in sys.stdin:
        if int(line) == 0:
            print(memory, seconds, flush=True)
            continue
        start = time.perf_counter()
        for _ in range(int(line)):
            step()
        print((time.perf_counter() - start) / int(line) / len(slaves), len(slaves), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
