"""Starts solved per second by `psp dataset`: on one core, on two, and by a Dask cluster of two workers."""

from __future__ import annotations

import time
from collections.abc import Callable
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory

from psp_model.offline.dataset import make_dataset
from psp_model.offline.plan import Plan
from psp_model.selection.search.engine import Problem

from .registry import Context
from .rounds import Row, interleave, row

STARTS, CHUNK = 48, 8


def measure(context: Context) -> list[Row]:
    """All lines of this measurement."""
    from distributed import LocalCluster

    effort = "grid" if context.quick else "full"
    number = count()
    with (
        TemporaryDirectory() as folder,
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=50) as cluster,
    ):

        def making(threads: int | None, scheduler: str | None) -> Callable[[], float]:
            def rate() -> float:
                seed = next(number)
                plan = Plan(STARTS, seed, Problem(7), effort=effort, tables=True, chunk=CHUNK)
                began = time.perf_counter()
                make_dataset(plan, Path(folder) / f"{seed}.parquet", threads=threads, scheduler=scheduler)
                return STARTS / (time.perf_counter() - began)

            return rate

        measures = {
            "one": making(1, None),
            "two": making(2, None),
            "dask": making(None, cluster.scheduler_address),
        }
        found = interleave(measures, context.rounds(5), 60.0)
    size, unit = f"{STARTS} starts of 7", "starts/s"
    return [
        row("data set, 2 cores", size, "1 core", found["two"], found["one"], unit, rate=True),
        row("data set, Dask cluster of 2 workers", size, "1 core", found["dask"], found["one"], unit, rate=True),
        row("data set, Dask cluster of 2 workers", size, "2 cores", found["dask"], found["two"], unit, rate=True),
    ]
