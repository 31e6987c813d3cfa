"""Programs that measure on request: a process per thing measured, kept alive from round to round.

A worker prints `ready`, then answers every line of its input, a whole number that says how much to do, with one line:
the seconds per step.  What it says of anything else goes to stderr.
"""

from __future__ import annotations

import os
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType

TARGET = 0.04  # [s] one measurement should last, about


class WorkerError(RuntimeError):
    """A worker that ended or answered nonsense; its last words."""


class Worker:
    """A measuring process.

    Parameters
    ----------
    command : to run
    environment : added to this process's
    errors : file for what it says on stderr
    """

    def __init__(self, command: Sequence[str], errors: Path, environment: Mapping[str, str] | None = None):
        self.errors, self.amount = errors, 0
        with errors.open("wb") as stream:
            self.process = subprocess.Popen(
                list(command),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=stream,
                text=True,
                env=os.environ | dict(environment or {}),
            )
        self._expect("ready")

    def _read(self) -> str:
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        if not line:
            self.process.wait()
            words = self.errors.read_text(errors="replace").strip().splitlines() or ["it said nothing"]
            raise WorkerError(f"{Path(self.process.args[0]).name} ended with {self.process.returncode}: {words[-1]}")
        return line.strip()

    def _expect(self, word: str) -> None:
        while self._read() != word:  # libraries greet on stdout
            pass

    def ask(self, amount: int) -> list[str]:
        """The words of the answer to one request."""
        assert self.process.stdin is not None
        self.process.stdin.write(f"{amount}\n")
        self.process.stdin.flush()
        return self._read().split()

    def seconds(self) -> float:
        """Seconds per step, over as many steps as last about TARGET."""
        if not self.amount:
            self.ask(1)  # the first is slower than all others
            seconds, steps = map(float, self.ask(1))
            self.amount = max(1, min(10_000, round(TARGET / max(seconds * steps, 1e-9))))
        return float(self.ask(self.amount)[0])

    def close(self) -> None:
        """End the process."""
        assert self.process.stdin is not None and self.process.stdout is not None
        self.process.stdin.close()
        try:
            self.process.wait(20)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.process.stdout.close()

    def __enter__(self) -> Worker:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()
