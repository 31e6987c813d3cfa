"""The short form of the torture tests: a small chunk of each trial, in a process of its own as in the long form."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from system_packages import require
from torture.registry import TRIALS
from torture.runner import Piece, run_all
from torture.summary import as_markdown
from torture.trial import Outcome

BY_NAME = {trial.name: trial for trial in TRIALS}
MORE = [("abuse", 1), ("many-instances", 1)]  # the Python platoon besides the native one
CHUNKS = [(trial.name, trial.name == "interrupted") for trial in TRIALS if trial.short] + MORE


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where FMUs are built once, and outcomes kept."""
    folder = tmp_path_factory.mktemp("torture")
    (folder / "chunks").mkdir()
    return folder


@pytest.mark.parametrize(("name", "number"), CHUNKS)
def test_nothing_goes_wrong(folder: Path, name: str, number: int) -> None:
    trial = BY_NAME[name]
    require(*trial.needs)
    outcome = run_all([Piece(trial, int(number), trial.short)], folder, 1, lambda line: None)[name]
    assert outcome.count > 0 and outcome.failures == 0, outcome.violations
    assert name in as_markdown([trial], {name: outcome}, 1.0)


def test_a_finished_chunk_is_not_done_again_and_a_dead_one_is_a_violation(folder: Path) -> None:
    trial = BY_NAME["lemma1-truth"]
    finished, dying = Piece(trial, 900, 7), Piece(replace(trial, limit=0.01), 901, 7)
    finished.kept(folder).write_text(json.dumps(Outcome(count=7, tallies={"kept": 1}).as_dict()))
    assert run_all([finished], folder, 1, lambda line: None)[trial.name].tallies == {"kept": 1}
    found = run_all([dying], folder, 1, lambda line: None)[trial.name]
    assert found.failures == 1 and "chunk 901 ended with status -9" in found.violations[0]
