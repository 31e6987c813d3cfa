"""A Python host that measures how an FMU begins, through fmpy; protocol as in init_host.c.

init_host.py FOLDER MODEL LIBRARY RESOURCE_URI GUID SOURCE VALUE
"""

from __future__ import annotations

import sys
import time

from fmpy.fmi2 import FMU2Slave, defaultCallbacks


def main(folder: str, model: str, library: str, uri: str, guid: str, source: str, value: str) -> None:
    """Answer requests until there are no more."""
    began = time.perf_counter()
    slave = FMU2Slave(guid=guid, unzipDirectory=folder, modelIdentifier=model, instanceName="start")
    slave.instantiate(callbacks=defaultCallbacks)

    def initialise() -> float:
        slave.setupExperiment(startTime=0.0)
        if int(source) >= 0:
            slave.setInteger([int(source)], [int(value)])
        start = time.perf_counter()
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        return time.perf_counter() - start

    initialise()
    slave.doStep(0.0, 0.01)
    first = time.perf_counter() - began
    print("ready", flush=True)
    for line in sys.stdin:
        seconds = 0.0
        for _ in range(int(line)):
            slave.reset()
            seconds += initialise()
        print(seconds / int(line) if int(line) else first, 1, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
