"""Runs the long form: every chunk in a process of its own, finished chunks are kept, an interrupted run goes on.

python -m torture [--jobs 2] [--only NAME,NAME] [--share 0.1] [--fresh] [--output DIR]   (with tests/ on the path)
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import shlex
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path

from psp_cli.interrupt import can_go_on
from system_packages import NEEDS, found

from . import fmus
from .registry import TRIALS
from .summary import write_summary
from .trial import Chunk, Outcome, Trial

ROOT = Path(__file__).parents[2]
_SOURCES = ("psp_model", "psp_cli", "psp_view", "fmu_src", "onnx", "tests/torture", "tests/native/fuzz")
_KINDS = {".py", ".c", ".h", ".onnx"}


@dataclass(frozen=True)
class Piece:
    """A chunk to be done: of which trial, which one, how many cases."""

    trial: Trial
    number: int
    count: int

    def kept(self, folder: Path) -> Path:
        """Where its outcome is kept."""
        return folder / "chunks" / f"{self.trial.name}-{self.number:03d}-{self.count}.json"


def digest() -> str:
    """Hash of everything that the outcome of a chunk depends on."""
    found = hashlib.sha256()
    for folder in _SOURCES:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in _KINDS:
                found.update(f"{path.relative_to(ROOT)}\0".encode() + path.read_bytes())
    return found.hexdigest()


def run_chunk(trial: Trial, number: int, count: int, fmu_folder: Path) -> Outcome:
    """One chunk, in this process.

    Parameters
    ----------
    trial, number, count : which
    fmu_folder : where FMUs are kept
    """
    with tempfile.TemporaryDirectory(prefix="psp_torture_") as scratch:
        before = time.process_time()
        outcome = trial.run(Chunk(number, count, Path(scratch), fmu_folder))
        children = os.times()
        outcome.seconds = time.process_time() - before + children.children_user + children.children_system
    return outcome


def _in_a_process(piece: Piece, folder: Path) -> Outcome:
    """One chunk in a process of its own; if that dies or hangs, that is a violation."""
    command = [sys.executable, "-m", "torture", "--chunk", piece.trial.name, str(piece.number), str(piece.count)]
    environment = os.environ | {"PYTHONPATH": f"{ROOT}{os.pathsep}{ROOT / 'tests'}", "OPENBLAS_NUM_THREADS": "1"}
    with tempfile.TemporaryFile("w+") as said:
        process = subprocess.Popen(
            [*command, "--output", str(folder)],
            env=environment,
            cwd=ROOT,
            stdout=said,
            stderr=said,
            start_new_session=True,
        )
        try:
            process.wait(timeout=piece.trial.limit)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        said.seek(0)
        last = said.read()[-600:].strip()
    if process.returncode == 0 and piece.kept(folder).exists():
        return Outcome.from_dict(json.loads(piece.kept(folder).read_text()))
    outcome = Outcome()
    outcome.violate(f"chunk {piece.number} ended with status {process.returncode}: {last}")
    return outcome


def _pieces(options: argparse.Namespace) -> list[Piece]:
    """All chunks, the trials' taken in turn so that each shows early whether it holds."""
    wanted = options.only.split(",") if options.only else [trial.name for trial in TRIALS]
    unknown = set(wanted) - {trial.name for trial in TRIALS}
    if unknown:
        raise SystemExit(f"no trial is called {', '.join(unknown)}: choose from {', '.join(t.name for t in TRIALS)}")
    chosen = [trial for trial in TRIALS if trial.name in wanted]
    for trial in chosen:
        if missing := [need for need in trial.needs if not found(need)]:
            packages = " ".join(package for need in missing for package in NEEDS[need].packages)
            print(f"{trial.name} is left out, as packages are missing: install {packages}", flush=True)
            chosen = [other for other in chosen if other is not trial]
    share = options.share
    rows = [
        [
            Piece(t, k, max(1, round(t.count * min(1.0, share * t.chunks))))
            for k in range(max(1, round(t.chunks * share)))
        ]
        for t in chosen
    ]
    return [piece for row in zip_longest(*rows) for piece in row if piece]


def _prepare(folder: Path, fresh: bool) -> None:
    """Keep finished chunks only if they belong to these sources; build the FMUs once for all."""
    note, now = folder / "sources.txt", digest()
    if fresh or not note.exists() or note.read_text() != now:
        for path in [*folder.glob("chunks/*.json"), *(folder / "fmus").rglob("*.fmu"), *folder.glob("fmus/*.so")]:
            path.unlink()
    (folder / "chunks").mkdir(parents=True, exist_ok=True)
    note.write_text(now)
    for one in fmus.BUILDS:
        fmus.path_of(one, folder / "fmus")


def run_all(pieces: Sequence[Piece], folder: Path, jobs: int, say: Callable[[str], None]) -> dict[str, Outcome]:
    """All chunks, with what was finished before; the outcome of each trial by name.

    Parameters
    ----------
    pieces : the chunks
    folder : where finished chunks are kept
    jobs : processes at a time
    say : is told about every chunk
    """
    totals: dict[str, Outcome] = {piece.trial.name: Outcome() for piece in pieces}
    begun = time.monotonic()
    with ThreadPoolExecutor(jobs) as pool:
        waiting = {pool.submit(_one, piece, folder): piece for piece in pieces}
        for done, future in enumerate(as_completed(waiting), start=1):
            piece, outcome = waiting[future], future.result()
            totals[piece.trial.name].add(outcome)
            wrong = f", {outcome.failures} WRONG: {outcome.violations[:1]}" if outcome.failures else ""
            passed = time.monotonic() - begun
            at = f"{done}/{len(pieces)}, {passed:.0f} s"
            say(f"[{at}] {piece.trial.name} {piece.number}: {outcome.count:,}{wrong}")
    return totals


def _one(piece: Piece, folder: Path) -> Outcome:
    if piece.kept(folder).exists():
        return Outcome.from_dict(json.loads(piece.kept(folder).read_text()))
    return _in_a_process(piece, folder)


def _child(name: str, number: int, count: int, folder: Path) -> int:
    """What the process of a chunk does; the outcome is kept unless something went wrong, which is to be seen again."""
    trial = next(trial for trial in TRIALS if trial.name == name)
    try:
        outcome = run_chunk(trial, number, count, folder / "fmus")
    except Exception:
        traceback.print_exc()
        return 1
    place = Piece(trial, number, count).kept(folder)
    partial = place.with_suffix(".partial")
    partial.write_text(json.dumps(outcome.as_dict()))
    partial.replace(place)
    return 0


def main(arguments: list[str] | None = None) -> int:
    """Run what the command line asks for; exit code 1 where anything went wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=2, help="processes at a time (2)")
    parser.add_argument("--only", default="", help="names of trials, with commas")
    parser.add_argument("--share", type=float, default=1.0, help="share of the long form (1)")
    parser.add_argument("--fresh", action="store_true", help="forget finished chunks")
    parser.add_argument("--output", type=Path, default=ROOT / "out" / "torture", help="folder (out/torture)")
    parser.add_argument("--chunk", nargs=3, metavar=("NAME", "NUMBER", "COUNT"), help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    if options.chunk:
        name, number, count = options.chunk
        return _child(name, int(number), int(count), options.output)
    words = [word for word in (sys.argv[1:] if arguments is None else arguments) if word != "--fresh"]
    again = shlex.join(["python", "-m", "torture", *words])
    can_go_on(lambda: again if any((options.output / "chunks").glob("*.json")) else None)
    _prepare(options.output, options.fresh)
    pieces = _pieces(options)
    begun = time.monotonic()
    totals = run_all(pieces, options.output, options.jobs, lambda line: print(line, flush=True))
    chosen = [trial for trial in TRIALS if trial.name in totals]
    places = [options.output / "summary"]
    if len(chosen) == len(TRIALS) and options.share == 1.0:  # the whole of it: what the documentation shows
        places.append(ROOT / "benchmarks" / "results" / "torture")
    print(write_summary(chosen, totals, places, time.monotonic() - begun))
    return 1 if any(outcome.failures for outcome in totals.values()) else 0
