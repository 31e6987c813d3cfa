"""Hosts in Python, each for a process of its own: python -m native.python_host NAME ARGUMENT...   prints JSON."""

from __future__ import annotations

import json
import os
import random
import signal
import sys
import tempfile
import threading
import time
from ctypes import byref, c_double, c_uint
from pathlib import Path

from fmpy import read_model_description, simulate_fmu

from harness import OK, Instance, Unpacked


def neighbours(*archives: str) -> object:
    """The FMUs side by side, made in that order: what each of them puts out in the end."""
    instances = [Instance(Unpacked(Path(path), Path(tempfile.mkdtemp()))) for path in archives]
    for instance in instances:
        assert instance.initialise() == OK, instance.messages
    for k in range(20):
        for instance in instances:
            assert instance.step(k * 0.01, 0.01) == OK, instance.messages
    found = [instance.outputs() for instance in instances]
    for instance in instances:
        instance.close()
    return found


def loads(archive: str, count: str, step: str) -> object:
    """What the process holds after every so many loads of the archive: mappings, search path, finders, modules."""
    held, description = [], read_model_description(archive)
    for k in range(1, int(count) + 1):
        simulate_fmu(archive, model_description=description, validate=False, stop_time=0.01, step_size=0.01)
        if k % int(step) == 0:
            mappings = len(Path("/proc/self/maps").read_text().splitlines())
            held.append([mappings, len(sys.path), len(sys.path_importer_cache), len(sys.modules)])
    return held


FEWEST = 5  # signals of a run


class Alarm(Exception):
    """What a host of the test raises in the handler of a signal."""


def interrupted(archive: str, folder: str, steps: str, name: str) -> object:
    """Step while a signal comes every other moment ('' for none), going on from where the FMU is.

    There are more steps than asked for until some signals have come: on a busy machine they come late.
    """
    fmu = Unpacked(Path(archive), Path(folder))
    instance = Instance(fmu)
    assert instance.initialise() == OK
    calm, over, shooter = threading.Event(), threading.Event(), None
    if name:
        number = getattr(signal, name)
        if number != signal.SIGINT:
            signal.signal(number, _raise_alarm)
        shooter = threading.Thread(target=_shoot, args=(number, calm, over))
        shooter.start()
    caught, target = 0, int(steps)
    while True:
        try:
            calm.set()  # from here on a signal may come, and no second one before this is set again
            _go_on(instance, target)
            if name and caught <= FEWEST:
                target += int(steps)
                continue
            over.set()
            if shooter:
                shooter.join()
            time.sleep(0.01)
            break
        except (KeyboardInterrupt, Alarm):
            caught += 1
    return {"caught": caught, "steps": target, "outputs": instance.outputs(), "messages": instance.messages}


def _raise_alarm(number: int, frame: object) -> None:
    raise Alarm(number)


def _shoot(number: int, calm: threading.Event, over: threading.Event) -> None:
    moment = random.Random(1)
    while not over.is_set():
        if calm.wait(0.1):
            calm.clear()
            time.sleep(moment.uniform(0.0, 0.002))
            os.kill(os.getpid(), number)


def _go_on(instance: Instance, steps: int) -> None:
    """Step and read from the time that the FMU has reached: the host may have been interrupted before it counted."""
    dll, component, reached = instance.slave.dll, instance.slave.component, c_double()
    fmu = instance.fmu
    references = [fmu.reference[v.name] for v in fmu.description.modelVariables if v.causality == "output"]
    asked, values = (c_uint * len(references))(*references), (c_double * len(references))()
    dll.fmi2GetRealStatus(component, 2, byref(reached))
    for k in range(round(reached.value / 0.01), steps):
        dll.fmi2DoStep(component, k * 0.01, 0.01, 1)  # fmpy raises where a status is not OK
        dll.fmi2GetReal(component, asked, len(references), values)


def ending(archive: str, folder: str) -> object:
    """An instance that nobody frees until Python ends, when modules have lost what was in them."""
    instance = Instance(Unpacked(Path(archive), Path(folder)))
    assert instance.initialise() == OK
    free, component = instance.slave.dll.fmi2FreeInstance, instance.slave.component

    class Late:
        def __del__(self) -> None:
            free(component)

    sys.kept_until_the_end = Late()  # type: ignore[attr-defined]
    return "left to Python's end"


if __name__ == "__main__":
    print(json.dumps(globals()[sys.argv[1]](*sys.argv[2:])), flush=True)
    if sys.argv[1] == "neighbours":
        os._exit(0)  # pythonfmu's library as others pack it frees something twice where a process ends
