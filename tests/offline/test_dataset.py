"""Data sets survive what happens to them: kill -9, dead workers, full disks, strangers' files."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import distributed
import numpy as np
import pyarrow.parquet as pq
import pytest

import small_problems
from psp_model import StartDomain
from psp_model.offline import dataset as module
from psp_model.offline.dataset import make_dataset
from psp_model.offline.errors import OfflineError
from psp_model.offline.parquet import read_dataset
from psp_model.offline.plan import Plan, solve_or_record
from psp_model.selection.search.search import Search
from small_problems import TINY, teach_tiny

RUN = """
import sys, time
from pathlib import Path
from psp_model.offline.dataset import make_dataset
from small_problems import PLAN, teach_tiny
teach_tiny()
make_dataset(PLAN, Path(sys.argv[1]), watch=lambda done, chunks: time.sleep(0.5))
"""


def make(plan: Plan, path: Path, **options: object) -> bytes:
    make_dataset(plan, path, **options)  # type: ignore[arg-type]
    return path.read_bytes()


def test_same_plan_gives_the_same_bytes_and_reads_back(tiny_plan: Plan, tmp_path: Path) -> None:
    assert make(tiny_plan, tmp_path / "a.parquet", threads=1) == make(tiny_plan, tmp_path / "b.parquet", threads=2)
    data = read_dataset(tmp_path / "a.parquet")
    assert (data.starts == tiny_plan.draw()).all()
    assert StartDomain().contains(data.starts[:, :2].T, data.starts[:, 2:].T).all()
    assert np.isfinite(data.J).all() and data.failures == 0
    assert data.tables is not None and data.tables.shape[1:] == (data.grid.r.size, data.grid.level.size)
    field = pq.read_schema(tmp_path / "a.parquet").field("r")
    assert field.metadata == {b"unit": b"m"}


def test_kill_9_costs_one_chunk_at_most_and_ends_in_the_same_file(tiny_plan: Plan, tmp_path: Path) -> None:
    whole = make(tiny_plan, tmp_path / "whole.parquet")
    path = tmp_path / "killed.parquet"
    parts = tmp_path / "killed.parquet.parts"
    tests = Path(small_problems.__file__).parent
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(tests.parent), str(tests)])}
    process = subprocess.Popen([sys.executable, "-c", RUN, str(path)], env=environment)
    while len(list(parts.glob("*.npz"))) < 2:
        assert process.poll() is None
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert not path.exists()
    kept = {part: part.stat().st_mtime_ns for part in parts.glob("*.npz")}
    with pytest.raises(OfflineError, match="go on with resume"):
        make(tiny_plan, path)
    solved = []
    make(tiny_plan, path, resume=True, watch=lambda done, chunks: solved.append(done))
    assert solved[0] == len(kept) >= 2
    assert path.read_bytes() == whole
    assert not parts.exists()


def test_a_run_that_fails_before_its_first_chunk_leaves_nothing(
    tiny_plan: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*arguments: object) -> bytes:
        raise OfflineError("no compiler")

    path = tmp_path / "a.parquet"
    with monkeypatch.context() as patch:
        patch.setattr(module, "solve_chunk", broken)
        with pytest.raises(OfflineError, match="no compiler"):
            make(tiny_plan, path)
    assert not list(tmp_path.iterdir())
    make(tiny_plan, path)


@pytest.mark.parametrize("resume", [False, True])
def test_a_leftover_folder_without_a_solved_chunk_stands_in_nobodys_way(
    tiny_plan: Plan, tmp_path: Path, resume: bool
) -> None:
    path, parts = tmp_path / "a.parquet", tmp_path / "a.parquet.parts"
    parts.mkdir()
    (parts / "plan.json").write_text("other options")
    (parts / ".000000.123.partial.npz").write_bytes(b"half")
    make(tiny_plan, path, resume=resume)
    assert [left.name for left in tmp_path.iterdir()] == ["a.parquet"]
    parts.mkdir()
    (parts / "plan.json").write_text("other options")
    with pytest.raises(OfflineError, match="exists already"):
        make(tiny_plan, path)


def test_a_file_in_the_place_of_the_parts_is_named(tiny_plan: Plan, tmp_path: Path) -> None:
    (tmp_path / "a.parquet.parts").write_text("a file")
    with pytest.raises(OfflineError, match=r"a.parquet.parts is no folder: remove it"):
        make(tiny_plan, tmp_path / "a.parquet")


def test_a_killed_dask_worker_does_not_change_the_file(tiny_plan: Plan, tmp_path: Path) -> None:
    class Teacher(distributed.WorkerPlugin):
        """Makes every worker know the effort, the one that replaces the killed one, too."""

        def setup(self, worker: object) -> None:
            teach_tiny()

    whole = make(tiny_plan, tmp_path / "whole.parquet")
    path = tmp_path / "cluster.parquet"
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, local_directory=str(tmp_path)
    ) as cluster:
        with distributed.Client(cluster) as client:
            client.register_plugin(Teacher(), name="tiny effort")
            victims = list(client.run(os.getpid).values())

        def kill_one(done: int, chunks: int) -> None:
            if done == 1 and victims:
                os.kill(victims.pop(), signal.SIGKILL)

        make_dataset(tiny_plan, path, scheduler=cluster.scheduler_address, watch=kill_one)
    assert len(victims) == 1
    assert path.read_bytes() == whole


def test_a_start_that_fails_is_recorded_and_the_others_solved(
    tiny_plan: Plan, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    solve = Search.solve
    bad = tiny_plan.draw()[3]

    def fails_once(self: Search, starts: np.ndarray) -> object:
        if (starts == bad).all(axis=1).any():
            raise ArithmeticError("the fourth start is cursed")
        return solve(self, starts)

    monkeypatch.setattr(Search, "solve", fails_once)
    make(tiny_plan, tmp_path / "a.parquet")
    table = pq.read_table(tmp_path / "a.parquet")
    errors = table.column("error").to_pylist()
    assert errors[3] == "the fourth start is cursed" and errors[:3] + errors[4:] == [None] * 10
    data = read_dataset(tmp_path / "a.parquet")
    assert data.failures == 1 and len(data.J) == 10 and not (data.starts == bad).all(axis=1).any()


def test_solving_again_alone_gives_the_same_answers(tiny_plan: Plan) -> None:
    search = Search(tiny_plan.problem, TINY)
    starts = tiny_plan.draw()
    together = solve_or_record(search, starts, tables=True)
    alone = solve_or_record(search, starts[4:5], tables=True)
    for name, values in alone.items():
        assert (together[name][4:5] == values).all()


def test_full_disk_is_one_sentence_and_leaves_nothing_half_written(
    tiny_plan: Plan, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    whole = make(tiny_plan, tmp_path / "whole.parquet")
    with monkeypatch.context() as patch:
        patch.setattr(module.os, "fsync", full)
        with pytest.raises(OfflineError, match=r"No space left on device.*resume"):
            make(tiny_plan, tmp_path / "a.parquet")
    assert not list(tmp_path.rglob("*.partial")) and not (tmp_path / "a.parquet").exists()
    assert make(tiny_plan, tmp_path / "a.parquet", resume=True) == whole


def test_foreign_and_changed_files_are_refused(tiny_plan: Plan, tmp_path: Path) -> None:
    path = tmp_path / "a.parquet"
    make(tiny_plan, path)
    table = pq.read_table(path)
    changed = table.set_column(
        table.column_names.index("J"), table.schema.field("J"), [table.column("J").to_numpy() + 1]
    )
    for name, content, sentence in [
        ("changed", changed, "was changed after it was made"),
        ("foreign", table.replace_schema_metadata({}), "has not the schema"),
        ("lacking", table.drop_columns(["r"]), "not those of its plan"),
    ]:
        pq.write_table(content, tmp_path / name)
        with pytest.raises(OfflineError, match=sentence):
            read_dataset(tmp_path / name)
    (tmp_path / "cut").write_bytes(path.read_bytes()[:500])
    for name, sentence in [("cut", "cannot be read|can be read"), ("missing", "there is no data set")]:
        with pytest.raises(OfflineError, match=sentence):
            read_dataset(tmp_path / name)


def test_resuming_another_plan_is_refused(tiny_plan: Plan, tmp_path: Path) -> None:
    from dataclasses import replace

    path = tmp_path / "a.parquet"

    def stop(done: int, chunks: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make(tiny_plan, path, watch=stop)
    with pytest.raises(OfflineError, match="begun with another plan"):
        make(replace(tiny_plan, seed=6), path, resume=True)


@pytest.mark.parametrize("plan", [b"", b"\xff", b"[1]", b'{"problem": {"vehicles": 1000000000}}', b"[" * 100_000])
def test_a_hostile_plan_is_refused(tiny_plan: Plan, tmp_path: Path, plan: bytes) -> None:
    path = tmp_path / "a.parquet"
    make(tiny_plan, path)
    table = pq.read_table(path)
    pq.write_table(table.replace_schema_metadata(table.schema.metadata | {b"plan": plan}), path)
    with pytest.raises(OfflineError, match="not those of its plan"):
        read_dataset(path)
