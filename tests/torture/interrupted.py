"""Commands killed at every stage, and disks that are full: nothing half-written is left in place.

Every run is a child of this process.  A kill comes when the child opens, renames or removes a file for the k-th time,
or in the middle of a write (a file size limit with its signal).  Ctrl-C comes at such steps too, and must end the child
with its sentence and nothing left behind.  Afterwards each file in the folder is the one from
before or the one that an undisturbed run writes, and the command, given again, ends well.
"""

from __future__ import annotations

import io
import os
import resource
import shutil
import signal
import sys
import time
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from psp_cli.interrupt import CODE, install

from .trial import Chunk, Outcome

_EVENTS = {"open", "os.rename", "os.remove", "os.mkdir", "os.rmdir"}
_LEFT_OVER = (".partial",)  # in names of what a killed command may leave behind, beside the files
_OLD = b"what was there before"


@dataclass(frozen=True)
class Command:
    """A command under interruption.

    Attributes
    ----------
    name : in sentences
    arguments : of psp, run in a folder of its own
    again : arguments of the run after an interruption
    replaces : whether it writes over files that are there
    """

    name: str
    arguments: str
    again: str = ""
    replaces: bool = True


COMMANDS = (
    Command("build", "build -n 3 -o out"),
    Command("report", "report -n 3 --duration 0.5 -o out/report.html"),
    Command("simulate", "simulate {fmu} --duration 0.2 --csv out/run.csv"),
    Command("figures", "figures -n 3 --duration 0.2 --only runs -o out"),
    Command("dataset", "dataset -n 3 --starts 6 --chunk 2 --effort tiny -o out/data.parquet", "--resume", False),
    Command("train", "train --data {data} -o out/network.onnx --curves out --epochs 2 --hidden 4"),
    Command("build native", "build -n 3 --runtime native -o out"),
)


def _child(arguments: list[str], folder: Path, before: Callable[[], None]) -> tuple[int, str]:
    """Run psp in a fork; the wait status and what it said on stderr."""
    said = folder / "said.txt"
    pid = os.fork()
    if pid == 0:
        with suppress(BaseException):
            os.chdir(folder)
            sys.argv = ["psp", *arguments]
            os.dup2(os.open(said, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), 2)
            signal.signal(signal.SIGINT, signal.default_int_handler)
            install("psp")
            err = io.StringIO()
            code = 0
            try:
                with redirect_stdout(io.StringIO()), redirect_stderr(err):
                    before()
                    _psp(arguments)
            except SystemExit as ended:
                code = int(ended.code or 0)
            except BaseException as error:
                code = 70
                err.write(f"raised {error!r}")
            resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
            os.write(2, err.getvalue().encode())
            os._exit(code)
        os._exit(71)
    _, status = os.waitpid(pid, 0)
    return status, said.read_text() if said.exists() else ""


def _psp(arguments: list[str]) -> None:
    from psp_cli.main import app

    app(arguments, prog_name="psp", standalone_mode=True)


def signal_at(event: int, folder: Path, number: int = signal.SIGKILL) -> Callable[[], None]:
    """Makes a child send itself a signal at its k-th step in a folder."""
    place = str(folder)

    def before() -> None:
        seen = [0]

        def hook(name: str, arguments: tuple[Any, ...]) -> None:
            if name in _EVENTS and isinstance(arguments[0], str | os.PathLike):
                path = os.path.join(os.getcwd(), os.fspath(arguments[0]))
                if path.startswith(place):
                    seen[0] += 1
                    if seen[0] == event:
                        os.kill(os.getpid(), number)

        sys.addaudithook(hook)

    return before


def limit(size: int, kill: bool) -> Callable[[], None]:
    """Makes a child's files end at a size: by an error, as on a full disk, or by its death in the write."""

    def before() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_DFL if kill else signal.SIG_IGN)
        hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))

    return before


def _files(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted((folder / "out").rglob("*")) if p.is_file()}


def _half_written(found: dict[str, bytes], whole: dict[str, bytes]) -> list[str]:
    """Files that are neither what was there before nor what an undisturbed run writes."""
    wrong = []
    for name, content in found.items():
        if any(mark in name.split("/")[-1] for mark in _LEFT_OVER):
            continue
        if ".parts/" in name:  # chunks of a data set: each whole or not there
            with suppress(Exception):
                if name.endswith(".json") or np.load(io.BytesIO(content)).files:
                    continue
        if content not in (_OLD, whole.get(name)):
            wrong.append(name)
    return wrong


class Stage:
    """One command in a folder, with what an undisturbed run of it writes.

    Parameters
    ----------
    command : which
    folder : to work in
    given : paths that its arguments name
    """

    def __init__(self, command: Command, folder: Path, given: dict[str, Path]):
        self.command, self.folder = command, folder
        self.arguments = [word.format(**given) for word in command.arguments.split()]
        self.fresh(False)
        began = time.monotonic()
        status, said = _child(self.arguments, folder, lambda: None)
        self.seconds, self.whole = time.monotonic() - began, _files(folder)
        self.works = status == 0 and bool(self.whole)
        self.said = said

    def fresh(self, old: bool) -> None:
        """An empty folder, or one with older files of the same names."""
        shutil.rmtree(self.folder, ignore_errors=True)
        (self.folder / "out").mkdir(parents=True)
        for name in self.whole if old and self.command.replaces else ():
            (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
            (self.folder / name).write_bytes(_OLD)

    def disturb(self, how: str, before: Callable[[], None], old: bool, outcome: Outcome) -> int:
        """Run under a disturbance and judge what is left; the wait status."""
        self.fresh(old)
        status, said = _child(self.arguments, self.folder, before)
        outcome.count += 1
        outcome.tally(f"{self.command.name}: {how.split()[0]}")
        if wrong := _half_written(_files(self.folder), self.whole):
            outcome.violate(f"{self.command.name}, {how}: half-written {wrong}")
        if os.WIFEXITED(status) and os.WEXITSTATUS(status) == CODE:
            sentences = [line for line in said.splitlines() if line.startswith("psp: interrupted")]
            if len(sentences) != 1 or "Traceback" in said:
                outcome.violate(f"{self.command.name}, {how}: said {said[-300:]}")
        elif os.WIFEXITED(status) and os.WEXITSTATUS(status) not in (0, 2):
            outcome.violate(f"{self.command.name}, {how}: ended with {os.WEXITSTATUS(status)}: {said[-300:]}")
        left = [name for name in _files(self.folder) if any(mark in name.split("/")[-1] for mark in _LEFT_OVER)]
        if left and os.WIFEXITED(status):
            outcome.violate(f"{self.command.name}, {how}: left {left} behind")
        return status

    def again(self, how: str, outcome: Outcome) -> None:
        """The same command once more ends as if nothing had happened."""
        more = self.command.again.split() if (self.folder / "out" / "data.parquet.parts").exists() else []
        status, said = _child([*self.arguments, *more], self.folder, lambda: None)
        found = {name: content for name, content in _files(self.folder).items() if name in self.whole}
        if status != 0 or found != self.whole:
            outcome.violate(f"{self.command.name} after {how}: {os.waitstatus_to_exitcode(status)} {said[-300:]}")
        outcome.tally(f"{self.command.name}: finished afterwards")


def _given(chunk: Chunk) -> dict[str, Path]:
    """What the commands are given: an FMU, and a small data set."""
    from psp_model.offline.dataset import make_dataset
    from psp_model.selection.search.search import EFFORTS
    from small_problems import PLAN, TINY

    from . import fmus

    EFFORTS["tiny"] = TINY
    data = chunk.scratch / "given.parquet"
    make_dataset(PLAN, data)
    return {"fmu": fmus.path_of(fmus.PLATOONS[0], chunk.fmus), "data": data}


def run(chunk: Chunk, commands: tuple[Command, ...] = COMMANDS) -> Outcome:
    """One command, a different one for each chunk, disturbed `count` times; 0 for as many stages as it has."""
    outcome, command = Outcome(), commands[chunk.number % len(commands)]
    rng = np.random.default_rng([7008, chunk.number])
    stage = Stage(command, chunk.scratch / "work", _given(chunk))
    if not stage.works:
        outcome.violate(f"{command.name} does not work undisturbed: {stage.said[-300:]}")
        return outcome
    largest = max(map(len, stage.whole.values()))
    for number in range(chunk.count):
        old, kind = bool(number // 4 % 2), number % 4
        if kind in (0, 3):
            event = 1 + number // 4
            how = f"{'interrupted' if kind else 'killed'} at event {event}"
            by = signal.SIGINT if kind else signal.SIGKILL
            status = stage.disturb(how, signal_at(event, stage.folder, by), old, outcome)
        else:
            size = int(largest * rng.random() ** 2)
            how = f"{'killed in a write' if kind == 1 else 'full'} at {size} bytes"
            status = stage.disturb(how, limit(size, kind == 1), old, outcome)
        if status != 0 and (kind == 3 or number % 8 == 0):
            stage.again(how, outcome)
    return outcome


def tell(outcome: Outcome) -> str:
    """For the summary."""
    return ", ".join(f"{name} {count:,}" for name, count in outcome.tallies.items())
