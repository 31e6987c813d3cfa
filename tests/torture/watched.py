"""A command run under watch: what it writes, runs and unpickles, how long it takes, and what it says."""

from __future__ import annotations

import os
import re
import signal
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from typer.testing import CliRunner

from psp_cli.main import app

PATIENCE = 30.0  # [s] for one command
_WRITES = {"os.mkdir", "os.remove", "os.rmdir", "os.symlink", "os.link", "os.chmod", "os.rename", "os.truncate"}
_RUNS = {"subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.spawn"}
_PROGRESS = re.compile(r"^\s*$|[━╸╺]|^psp: warning: ")


class Watch:
    """What Python's audit events tell of while it is on.

    Parameters
    ----------
    allowed : the only folders that may be written to
    programs : names of the only programs that may be run
    """

    def __init__(self, allowed: Sequence[Path], programs: Sequence[str] = ()):
        self.allowed, self.programs = [str(path.resolve()) for path in allowed], programs
        self.on, self.seen = False, list[str]()
        sys.addaudithook(self._hook)

    def _hook(self, event: str, arguments: tuple[Any, ...]) -> None:
        if not self.on:
            return
        if event == "open":
            path, mode, flags = arguments
            writes = any(letter in (mode or "") for letter in "wax+") or (flags or 0) & (os.O_WRONLY | os.O_RDWR)
            if writes and not isinstance(path, int):
                self._written(event, path)
        elif event in _WRITES:
            for path in arguments[: 2 if event in ("os.rename", "os.link", "os.symlink") else 1]:
                within = (
                    arguments[-1] if event in ("os.remove", "os.rmdir", "os.mkdir") else -1
                )  # a folder's descriptor
                if isinstance(path, str | bytes | os.PathLike):
                    self._written(event, path if within == -1 else f"/proc/self/fd/{within}/{os.fsdecode(path)}")
        elif event in _RUNS:
            program = Path(os.fsdecode(arguments[0] or arguments[1][0])).name
            if program not in self.programs:
                self.seen.append(f"{event} {arguments[:2]}")
        elif event == "pickle.find_class":
            self.seen.append(f"{event} {arguments}")

    def _written(self, event: str, path: Any) -> None:
        self.on = False  # resolving a path is no event of the command
        place = os.path.realpath(os.fsdecode(path))
        self.on = True
        inside = any(place == folder or place.startswith(folder + os.sep) for folder in self.allowed)
        if not inside and place != os.devnull:
            self.seen.append(f"{event} {place}")


class TooSlow(BaseException):
    """A command takes longer than anybody waits."""


@contextmanager
def patience(seconds: float) -> Iterator[None]:
    """Raise TooSlow when the block takes longer."""

    def stop(*_: Any) -> None:
        raise TooSlow

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def complaint(arguments: Sequence[str], watch: Watch) -> tuple[int, str]:
    """Run `psp`; its exit code, and what is wrong with the way it took its input, "" if nothing is.

    Parameters
    ----------
    arguments : of psp
    watch : tells what it did
    """
    watch.seen.clear()
    try:
        with patience(PATIENCE):
            watch.on = True
            try:
                result = CliRunner().invoke(app, list(arguments))
            finally:
                watch.on = False
    except TooSlow:
        return -1, f"took longer than {PATIENCE:g} s"
    if watch.seen:
        return result.exit_code, f"did {watch.seen[:3]}"
    if isinstance(result.exception, TooSlow):
        return -1, f"took longer than {PATIENCE:g} s"
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        return -1, f"raised {type(result.exception).__name__}: {str(result.exception)[:200]} {_where(result)}"
    said = [line for line in result.stderr.splitlines() if not _PROGRESS.search(line)]
    if result.exit_code == 2 and (len(said) != 1 or not said[0].startswith("psp: ") or len(said[0]) > 1500):
        return 2, f"said {said[:4]}"
    if result.exit_code not in (0, 1, 2):
        return result.exit_code, f"ended with exit code {result.exit_code}"
    return result.exit_code, ""


def _where(result: Any) -> str:
    trace = result.exc_info[2]
    places = []
    while trace is not None:
        code = trace.tb_frame.f_code
        if "/site-packages/" not in code.co_filename:
            places.append(f"{Path(code.co_filename).name}:{trace.tb_lineno}")
        trace = trace.tb_next
    return " < ".join(reversed(places[-3:]))


def settle_in(folder: Path) -> list[Path]:
    """Send temporary files and caches into a folder; the folders that may be written to.

    What Python compiles is not kept: a command that is the first to import a module after an installation would seem to
    write beside that module.
    """
    sys.dont_write_bytecode = True
    for name in ("tmp", "cache", "out"):
        (folder / name).mkdir(exist_ok=True)
    tempfile.tempdir = str(folder / "tmp")
    os.environ |= {"TMPDIR": str(folder / "tmp"), "XDG_CACHE_HOME": str(folder / "cache")}
    os.environ["MPLCONFIGDIR"] = str(folder / "cache")
    return [folder / name for name in ("tmp", "cache", "out")]
