"""Making a data set of global optima: chunk by chunk, so that an interruption costs at most one chunk."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

import numpy as np

from ..whole_file import read_arrays, write_whole
from .errors import OfflineError
from .parquet import write_dataset
from .plan import Plan, solve_chunk


def make_dataset(
    plan: Plan,
    path: Path,
    *,
    resume: bool = False,
    scheduler: str | None = None,
    threads: int | None = None,
    watch: Callable[[int, int], None] = lambda done, chunks: None,
) -> None:
    """Solve a plan and write its Parquet file; the file does not depend on which worker solves which chunk, or when.

    Solved chunks are kept in `<path>.parts/` until the file is complete.

    Parameters
    ----------
    plan : what to solve
    path : the Parquet file
    resume : go on where an interrupted run of the same plan stopped
    scheduler : address of a Dask scheduler whose workers solve the chunks; this machine does where it is None
    threads : for the rollouts on this machine; None for one per core
    watch : called with how many chunks of how many are done

    Raises
    ------
    OfflineError : where files are in the way, belong to another plan, or cannot be written
    """
    parts = parts_of(path)
    try:
        _prepare(parts, path, plan, resume)
        missing = [number for number in range(plan.chunks) if not _part(parts, number).exists()]
        watch(plan.chunks - len(missing), plan.chunks)
        solved = _on_cluster(plan, missing, scheduler) if scheduler else _here(plan, missing, threads)
        for done, (number, content) in enumerate(solved, start=plan.chunks - len(missing) + 1):
            write_whole(_part(parts, number), content)
            watch(done, plan.chunks)
        write_dataset(plan, _assembled(parts, plan.chunks), path)
        shutil.rmtree(parts)
    except OSError as error:
        problem = f"{path} could not be written ({error.strerror or error})"
        raise OfflineError(problem, "make room there and make it again with resume=True", "no_room") from None
    finally:
        if parts.is_dir() and not _solved(parts):
            shutil.rmtree(parts, ignore_errors=True)


def _solved(parts: Path) -> bool:
    """Whether a run left a chunk there to go on from."""
    return any(parts.glob("[0-9]*.npz"))


def parts_of(path: Path) -> Path:
    """The folder with what is solved already of a data set that is not complete.

    Parameters
    ----------
    path : the Parquet file
    """
    return path.with_name(path.name + ".parts")


def _prepare(parts: Path, path: Path, plan: Plan, resume: bool) -> None:
    """Make the folder of the parts, or check that it belongs to this plan."""
    if path.exists() and not (parts.exists() if resume else _solved(parts)):
        raise OfflineError(f"{path} exists already", "remove it or choose another path", "exists")
    note = parts / "plan.json"
    if parts.exists() and not parts.is_dir():
        raise OfflineError(f"{parts} is no folder", "remove it or choose another path", "exists")
    if not _solved(parts):
        note.unlink(missing_ok=True)  # so that a run that solved nothing does not block the next one
    if note.exists() and not resume:
        remedy = "go on with resume=True, or remove that folder"
        raise OfflineError(f"{parts} holds an unfinished run", remedy, "unfinished")
    if note.exists() and note.read_bytes() != plan.as_json().encode():
        remedy = "go on with that plan, or remove that folder"
        raise OfflineError(f"{parts} was begun with another plan", remedy, "another_plan")
    parts.mkdir(parents=True, exist_ok=True)
    write_whole(note, plan.as_json().encode())


def _part(parts: Path, number: int) -> Path:
    return parts / f"{number:06d}.npz"


def _assembled(parts: Path, count: int) -> dict[str, Any]:
    """The columns of all parts, in order."""
    loaded = [_read_part(_part(parts, number)) for number in range(count)]
    return {name: np.concatenate([part[name] for part in loaded]) for name in loaded[0]}


def _read_part(path: Path) -> dict[str, Any]:
    try:
        return read_arrays(path)
    except ValueError:
        raise OfflineError(f"{path} is damaged", "remove it and go on with resume=True", "part_damaged") from None


def _here(plan: Plan, missing: list[int], threads: int | None) -> Iterator[tuple[int, bytes]]:
    """Chunks side by side, a thread each: what Python does for one overlaps with the rollouts of another."""
    with ThreadPoolExecutor(threads or os.cpu_count()) as pool:
        numbers = {pool.submit(solve_chunk, plan, number, 1): number for number in missing}
        try:
            for future in as_completed(list(numbers)):
                yield numbers.pop(future), future.result()
        finally:
            pool.shutdown(cancel_futures=True)


def _on_cluster(plan: Plan, missing: list[int], scheduler: str) -> Iterator[tuple[int, bytes]]:
    """Solved chunks as the cluster hands them in; a chunk whose worker died is solved again by another."""
    from distributed import Client
    from distributed import as_completed as cluster_completed

    try:
        client = Client(scheduler, timeout="10s")  # type: ignore[no-untyped-call]
    except (OSError, ValueError, TimeoutError):
        problem = f"no Dask scheduler answers at {scheduler!r}"
        raise OfflineError(problem, "start one, or name none to use this machine", "no_scheduler") from None
    with client:
        numbers = {client.submit(solve_chunk, plan, number, 1, pure=False, retries=10): number for number in missing}
        for future in cluster_completed(list(numbers)):  # type: ignore[no-untyped-call]
            yield numbers[future], future.result()
            future.release()
