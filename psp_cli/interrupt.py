"""Ctrl-C: one sentence and exit code 130 at once, with nothing half-written left behind.

Nothing is unwound: libraries swallow a KeyboardInterrupt, turn it into errors of their own, or die of it while they are
loaded, and whoever waits for threads waits for long.  The process removes what is half written, ends its children, says
its sentence and leaves.  A thread that the signal wakes through a pipe does this where the main thread is in a long
call of a C library.  Nothing is imported here but what Python has loaded at its start, so that this is there before any
slow import.
"""

from __future__ import annotations

import _thread
import gc  # here: where a thread holds a lock of the import system, another one cannot import any more
import os
import signal
import sys
import time

TYPE_CHECKING = False  # typing takes a while to import
if TYPE_CHECKING:
    from collections.abc import Callable
    from tempfile import TemporaryDirectory
    from types import FrameType
    from typing import NoReturn

CODE = 130  # 128 + SIGINT, as shells have it
_PATIENCE = 0.4  # [s] with children that are asked to end, and with those that are killed


class _Interruption:
    """What is known of the one Ctrl-C of this process.

    Attributes
    ----------
    program : whose sentence it is
    go_on : gives the command that goes on where this one stopped, None where there is none
    all_groups : whether children in process groups of their own end too
    others : temporary folders from before, which are somebody else's
    threads : the one that ends the process, under "ends"
    stderr : descriptor of stderr, once descriptor 2 has been silenced
    process : the number of the program's process
    """

    def __init__(self) -> None:
        self.program = "psp"
        self.go_on: Callable[[], str | None] = lambda: None
        self.all_groups = False
        self.others: list[TemporaryDirectory[str]] = []
        self.threads: dict[str, int] = {}
        self.stderr: int | None = None
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


def install(program: str, all_groups: bool = False) -> None:
    """Watch for Ctrl-C from now on; nothing is done where the process was started to ignore it.

    Parameters
    ----------
    program : whose name the sentence begins with
    all_groups : end children in process groups of their own too
    """
    _NOW.program, _NOW.process, _NOW.all_groups = program, os.getpid(), all_groups
    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        return
    signal.signal(signal.SIGINT, _handle)
    _NOW.others = _temporary_folders()
    read, write = os.pipe()
    os.set_blocking(write, False)
    signal.set_wakeup_fd(write, warn_on_full_buffer=False)
    _thread.start_new_thread(_watch, (read,))


def run(program: str, main: Callable[[], object], all_groups: bool = False) -> NoReturn:
    """Run a program to its end, or to Ctrl-C.

    Parameters
    ----------
    program, all_groups : as for `install`
    main : returns the exit code, or raises SystemExit
    """
    install(program, all_groups)
    try:
        sys.exit(main())  # type: ignore[arg-type]
    finally:
        if signal.getsignal(signal.SIGINT) is _handle:
            signal.signal(signal.SIGINT, signal.SIG_IGN)  # what there was to do is done: Python ends


def _handle(_signal: int, _frame: FrameType | None) -> None:
    if _NOW.threads.get("ends") != _thread.get_ident():  # pressed once more, while this thread is at it
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
    own = _NOW.threads.setdefault("ends", _thread.get_ident()) == _thread.get_ident()
    try:
        if not own:  # the other thread is at it, and has this long
            time.sleep(2 * _PATIENCE + 0.7)
        stderr = _silence()
        for step in (_end_children, _remove_files) if own else ():
            _try(step)
        terminal = os.isatty(stderr)  # a progress bar has hidden the cursor, and the line holds ^C
        os.write(stderr, (("\033[?25h\n" if terminal else "") + sentence() + "\n").encode())
    finally:
        os._exit(CODE)


def _try(action: Callable[..., object], *arguments: object) -> None:
    """Do something that may fail: the rest is to be done all the same."""
    try:
        action(*arguments)
    except Exception:
        return


def _silence() -> int:
    """Let neither threads nor children say anything more on stderr; a descriptor for what is left to say."""
    if _NOW.stderr is not None:
        return _NOW.stderr
    try:
        kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 2)
    except OSError:  # stderr is closed
        kept = 2
    _NOW.stderr = kept
    return kept


def _end_children() -> None:
    """End the processes that were started here, with theirs, and see them dead: they write to files and to stderr."""
    begun = time.monotonic()
    while (alive := _children()) and (passed := time.monotonic() - begun) < 2 * _PATIENCE:
        for process in alive:
            _try(os.kill, process, signal.SIGINT if passed < _PATIENCE else signal.SIGKILL)
        time.sleep(0.02)


def _children() -> set[int]:
    """Processes below this one, where /proc tells; a browser is in a group of its own, and stays."""
    if not os.path.isdir("/proc/self"):
        return set()
    parents: dict[int, int] = {}
    ended = set()
    for name in filter(str.isdecimal, os.listdir("/proc")):
        try:
            with open(f"/proc/{name}/stat", encoding="utf-8", errors="replace") as file:
                state, parent, group = file.read().rpartition(")")[2].split()[:3]
        except (OSError, ValueError):  # it has ended
            continue
        if _NOW.all_groups or int(group) == os.getpgrp():
            parents[int(name)] = int(parent)
            ended |= {int(name)} if state in "ZX" else set()
    ours = {os.getpid()}
    while more := {child for child, parent in parents.items() if parent in ours} - ours:
        ours |= more
    return ours - {os.getpid()} - ended


def _remove_files() -> None:
    """Remove files that are half written, and temporary folders."""
    unfinished = sys.modules.get("psp_model.whole_file")
    for path in list(getattr(unfinished, "UNFINISHED", ())):
        _try(os.unlink, path)
    for folder in _temporary_folders():
        if not any(folder is other for other in _NOW.others):
            _try(folder.cleanup)


def _temporary_folders() -> list[TemporaryDirectory[str]]:
    """All that there are in this process."""
    kind = getattr(sys.modules.get("tempfile"), "TemporaryDirectory", None)
    return [thing for thing in gc.get_objects() if type(thing) is kind] if kind else []
