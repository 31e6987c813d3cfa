"""Ctrl-C: one sentence and exit code 130 at once, with nothing half-written left behind.

Nothing is unwound: libraries swallow a KeyboardInterrupt, turn it into errors of their own, or die of it while they are
loaded, and whoever waits for threads waits for long.  The process removes what is half written, ends its children, says
its sentence and leaves.  A thread that the signal wakes through a pipe does this where the main thread is in a long
call of a C library.  Nothing is imported here but what Python has loaded at its start, so that this is there before any
slow import.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from types import FrameType
from typing import NoReturn

CODE = 130  # 128 + SIGINT, as shells have it


class _Interruption:
    """What is known of the one Ctrl-C of this process.

    Attributes
    ----------
    program : whose sentence it is
    go_on : gives the command that goes on where this one stopped, None where there is none
    clean_ups : to be called before the end
    ending : taken by the thread that ends the process
    process : the number of the program's process
    """

    def __init__(self) -> None:
        self.program = "psp"
        self.go_on: Callable[[], str | None] = lambda: None
        self.clean_ups: list[Callable[[], object]] = []
        self.ending = threading.Lock()
        self.process = 0


_NOW = _Interruption()


def can_go_on(command: Callable[[], str | None]) -> None:
    """Say what goes on where an interrupted command stopped.

    Parameters
    ----------
    command : called when Ctrl-C is pressed; the command, or None where there is nothing yet to go on with
    """
    _NOW.go_on = command


def sentence() -> str:
    """What an interrupted command says."""
    try:
        command = _NOW.go_on()
    except Exception:  # a hint is not worth a traceback
        command = None
    return f"{_NOW.program}: interrupted" + (f": `{command}` goes on from here" if command else "")


def install(program: str) -> None:
    """Watch for Ctrl-C from now on; nothing is done where the process was started to ignore it.

    Parameters
    ----------
    program : whose name the sentence begins with
    """
    _NOW.program, _NOW.process = program, os.getpid()
    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        return
    signal.signal(signal.SIGINT, _handle)
    read, write = os.pipe()
    os.set_blocking(write, False)
    signal.set_wakeup_fd(write, warn_on_full_buffer=False)
    threading.Thread(target=_watch, args=(read,), daemon=True, name="interrupt").start()


def before_the_end(clean_up: Callable[[], object]) -> None:
    """Have something done when Ctrl-C is pressed, besides what is done for every program.

    Parameters
    ----------
    clean_up : quick, and free of locks and imports
    """
    _NOW.clean_ups.append(clean_up)


def run(program: str, main: Callable[[], object]) -> NoReturn:
    """Run a program to its end, or to Ctrl-C.

    Parameters
    ----------
    program : its name, for the sentence
    main : returns the exit code, or raises SystemExit
    """
    install(program)
    try:
        sys.exit(main())  # type: ignore[arg-type]
    finally:
        if signal.getsignal(signal.SIGINT) is _handle:
            signal.signal(signal.SIGINT, signal.SIG_IGN)  # what there was to do is done: Python ends


def _handle(_signal: int, _frame: FrameType | None) -> None:
    _end()


def _watch(pipe: int) -> None:
    """The signal has come, wherever the main thread is."""
    while signal.SIGINT not in os.read(pipe, 64):
        pass
    _end()


def _end() -> NoReturn:
    """Clean up, say so, and leave without waiting for anybody."""
    if os.getpid() != _NOW.process:  # a fork of the program, which says it
        os._exit(CODE)
    if not _NOW.ending.acquire(blocking=False):
        while True:  # the other thread is at it
            time.sleep(1.0)
    try:
        stderr = _silence()
        for step in (*_NOW.clean_ups, _end_children, _remove_files):
            with suppress(Exception):
                step()
        terminal = os.isatty(stderr)  # a progress bar has hidden the cursor, and the line holds ^C
        os.write(stderr, (("\033[?25h\n" if terminal else "") + sentence() + "\n").encode())
    finally:
        os._exit(CODE)


def _silence() -> int:
    """Let neither threads nor children say anything more on stderr; a descriptor for what is left to say."""
    try:
        kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 2)
    except OSError:  # stderr is closed
        return 2
    return kept


def _end_children() -> None:
    """Kill the processes that were started here and are in the terminal's group, with theirs (where /proc tells)."""
    parents: dict[int, int] = {}
    group = os.getpgrp() if hasattr(os, "getpgrp") else 0
    for name in os.listdir("/proc") if os.path.isdir("/proc/self") else []:
        try:
            with open(f"/proc/{name}/stat") as file:
                parent, of_group = map(int, file.read().rpartition(")")[2].split()[1:3])
        except (OSError, ValueError):  # not a process, or gone
            continue
        if of_group == group:
            parents[int(name)] = parent
    ours = {os.getpid()}
    while more := {child for child, parent in parents.items() if parent in ours} - ours:
        ours |= more
    for process in ours - {os.getpid()}:
        with suppress(OSError):
            os.kill(process, signal.SIGKILL)


def _remove_files() -> None:
    """Remove files that are half written, and temporary folders."""
    import gc

    unfinished = sys.modules.get("psp_model.whole_file")
    for path in list(getattr(unfinished, "UNFINISHED", ())):
        with suppress(OSError):
            os.unlink(path)
    tempfile = sys.modules.get("tempfile")
    kind = getattr(tempfile, "TemporaryDirectory", None)
    for thing in gc.get_objects() if kind else []:
        if type(thing) is kind:
            with suppress(Exception):
                thing.cleanup()
