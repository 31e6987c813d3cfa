"""Progress bars with the time left."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from .output import is_quiet


@contextmanager
def chunks_done(title: str, size: int = 1) -> Iterator[Callable[[int, int], None]]:
    """A bar on stderr for work that reports (chunks done, chunks in all).

    Parameters
    ----------
    title : what is being done
    size : items in a chunk, for the count that is shown
    """
    if is_quiet():
        yield lambda done, total: None
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = TextColumn(title), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn()
    with Progress(*columns, console=Console(stderr=True)) as progress:
        task = progress.add_task(title, total=None)
        yield lambda done, total: progress.update(task, completed=done * size, total=total * size)


@contextmanager
def steps_done(title: str, total: int) -> Iterator[Callable[[], None]]:
    """A bar on stderr for work that reports each step by a call.

    Parameters
    ----------
    title : what is being done
    total : how many steps
    """
    done = 0
    with chunks_done(title) as report:
        report(done, total)

        def step() -> None:
            nonlocal done
            done += 1
            report(done, total)

        yield step
