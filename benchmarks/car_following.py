"""Vehicle-steps per second of car-following on one lane: ours beside four simulators, for 10, 100 and 1000 vehicles.

A vehicle-step moves one vehicle by one step of its own simulator.  The simulators live in virtual environments of
their own; those that are missing are made, except in a smoke run.
"""

from __future__ import annotations

import subprocess
import sys
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from .fmus import CACHE, ON_HILL, fmu, host
from .registry import Context
from .rounds import Row, interleave, row
from .worker import Worker, WorkerError

SIZES = (10, 100, 1000)
PROGRAMS = Path(__file__).parent / "peers"


@dataclass(frozen=True)
class Peer:
    """A simulator.

    Attributes
    ----------
    title : with its model
    step : its step [s]
    program : in `peers`, with its first arguments
    installs : arguments of pip, one call after another; none: this project's extra `sumo`
    note : on the version
    optimised : whether Python's -O is recommended
    """

    title: str
    step: str
    program: tuple[str, ...]
    installs: tuple[tuple[str, ...], ...] = ()
    note: str = ""
    optimised: bool = False


PEERS = (
    Peer("SUMO, IDM, libsumo", "0.1 s", ("sumo_peer.py", "IDM")),
    Peer("SUMO, CACC, libsumo", "0.1 s", ("sumo_peer.py", "CACC")),
    Peer("cavsandbox 0.11.2, CACC", "0.01 s", ("cavsandbox_peer.py",), (("cavsandbox==0.11.2",),)),
    Peer("highway-env 1.12.1, IDM", "1/15 s", ("highway_env_peer.py",), (("highway-env==1.12.1",),)),
    Peer(
        "plafosim 0.15.1, CACC",
        "1 s",
        ("plafosim_peer.py",),
        (("--no-deps", "plafosim==0.15.1"), ("numpy<2", "pandas<2", "tqdm")),
        "without ortools, which only its formation of platoons uses",
        True,
    ),
)


def python_of(peer: Peer, context: Context) -> str:
    """The Python that has this simulator.

    Raises
    ------
    WorkerError : where it is not installed and cannot be
    """
    if not peer.installs:
        return sys.executable
    folder = context.peers / peer.program[0].removesuffix("_peer.py")
    python = folder / "bin" / "python"
    done = folder / "installed"
    if done.exists():
        return str(python)
    if context.quick:
        raise WorkerError("not installed, and a smoke run installs nothing")
    context.say(f"installing {peer.title}")
    calls = [[sys.executable, "-m", "venv", "--clear", str(folder)]]
    calls += [[str(python), "-m", "pip", "install", "--quiet", *install] for install in peer.installs]
    for call in calls:
        ran = subprocess.run(call, capture_output=True, text=True, check=False)
        if ran.returncode:
            errors = [line for line in ran.stderr.splitlines() if "ERROR" in line] or ["pip gave no reason"]
            raise WorkerError(f"pip could not install it: {errors[0]}")
    done.touch()
    return str(python)


def worker_of(peer: Peer, n: int, context: Context) -> Worker:
    """A worker that runs the simulator with n vehicles."""
    program, *arguments = peer.program
    optimise = {"PYTHONOPTIMIZE": "1"} if peer.optimised else {}
    command = [python_of(peer, context), str(PROGRAMS / program), *arguments, str(n)]
    return Worker(command, CACHE / f"{program}_{n}.log", {"PYTHONPATH": "", **optimise})


def measure(context: Context) -> list[Row]:
    """All lines of this measurement."""
    rows, missing = [], {}
    for n in (10,) if context.quick else SIZES:
        context.say(f"{n} vehicles")
        with ExitStack() as stack:
            running = {
                title: stack.enter_context(host(kind, fmu(kind, n), which, ON_HILL))
                for title, kind, which in (
                    ("native FMU, C host", "native", "C host"),
                    ("native FMU, ctypes", "native", "ctypes"),
                    ("Python FMU, ctypes", "python", "ctypes"),
                )
            }
            ours = list(running)
            for peer in PEERS:
                try:
                    running[peer.title] = stack.enter_context(worker_of(peer, n, context))
                except WorkerError as error:
                    missing[peer.title] = str(error)
            costs = interleave({title: one.seconds for title, one in running.items()}, context.rounds(7), 45.0)
        rates = {title: [1e-3 * n / seconds for seconds in samples] for title, samples in costs.items()}
        rows += [_row(mine, peer, n, rates) for peer in PEERS if peer.title in rates for mine in ours]
    for title, why in missing.items():
        rows.append(Row(ours[1], "", title, None, None, "", None, None, None, 0, f"{title} was not measured: {why}"))
    return rows


def _row(mine: str, peer: Peer, n: int, rates: dict[str, list[float]]) -> Row:
    title = f"{peer.title}, step {peer.step}" + (f", {peer.note}" if peer.note else "")
    unit = "thousand vehicle-steps/s"
    return row(f"{mine}, step 0.01 s", f"{n} vehicles", title, rates[mine], rates[peer.title], unit, rate=True)
