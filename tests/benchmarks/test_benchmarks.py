"""The benchmark program: its arithmetic, its table, and a smoke run."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks import __main__ as program
from benchmarks.page import BEGIN, END, write_page
from benchmarks.rounds import interleave, row, spread
from benchmarks.table import number, table

ROOT = Path(__file__).parents[2]


def test_ratios_are_taken_round_by_round():
    found = row("ours", "", "theirs", [2.0, 20.0, 200.0], [1.0, 5.0, 100.0], "s")
    assert (found.ratio, found.low, found.high) == (2.0, 2.0, 3.0)
    assert (found.ours, found.theirs) == (20.0, 5.0)


def test_twice_the_rate_is_half_the_cost():
    assert row("ours", "", "theirs", [10.0] * 3, [5.0] * 3, "1/s", rate=True).ratio == 0.5


def test_measures_are_called_in_turn_and_the_first_round_does_not_count():
    called = []

    def measure(name: str) -> float:
        called.append(name)
        return float(len(called))

    found = interleave({"a": lambda: measure("a"), "b": lambda: measure("b")}, 2)
    assert called == ["a", "b"] * 3 and found == {"a": [3.0, 5.0], "b": [4.0, 6.0]}


def test_quartiles():
    assert spread([5.0, 1.0, 3.0, 2.0, 4.0]) == (3.0, 2.0, 4.0)


@pytest.mark.parametrize(("value", "shown"), [(None, ""), (1234.6, "1,235"), (0.01234, "0.0123"), (2e-9, "2.0e-09")])
def test_numbers_are_short(value, shown):
    assert number(value) == shown


@pytest.fixture
def two_measurements(monkeypatch, tmp_path):
    """The program with two measurements that only count how often they are asked; the second can be broken."""
    calls: list[str] = []
    broken: set[str] = set()

    def run(measurement, options):
        calls.append(measurement.name)
        if measurement.name in broken:
            raise RuntimeError("interrupted")
        return {"name": measurement.name, "title": "T", "command": "c", "rows": []}

    monkeypatch.setattr(program, "run", run)
    monkeypatch.setattr(program, "MEASUREMENTS", program.MEASUREMENTS[:2])
    return calls, broken, ["--quick", "--output", str(tmp_path)]


def test_an_interrupted_run_goes_on_and_a_finished_one_starts_anew(two_measurements):
    calls, broken, arguments = two_measurements
    broken.add("model")
    assert program.main(arguments) == 1 and calls == ["steps", "model"]
    broken.clear()
    assert program.main(arguments) == 0 and calls == ["steps", "model", "model"]
    assert program.main(arguments) == 0 and calls[3:] == ["steps", "model"]


def test_fresh_forgets_an_interrupted_run(two_measurements):
    calls, broken, arguments = two_measurements
    broken.add("model")
    program.main(arguments)
    broken.clear()
    program.main([*arguments, "--fresh"])
    assert calls == ["steps", "model"] * 2


def test_the_page_keeps_its_words_and_gets_table_and_picture(tmp_path):
    pytest.importorskip("matplotlib")
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs/benchmarks.md").write_text(f"before\n{BEGIN}\nold\n{END}\nafter\n")
    found = row("ours", "n = 7", "theirs", [1.0, 2.0], [4.0, 4.0], "s").as_dict()
    result = {"title": "Title", "command": "the command", "rows": [found], "seconds": 1.0, "date": "2026-01-01"}
    result |= {"machine": {"processor": "P", "cores": 2, "memory_gib": 4, "system": "S", "load_average_before": 0.1}}
    (tmp_path / "steps.json").write_text(json.dumps(result | {"versions": {"numpy": "2"}}))
    write_page(tmp_path, tmp_path)
    page = (tmp_path / "docs/benchmarks.md").read_text()
    assert page.startswith("before\n") and page.endswith("after\n") and "old" not in page
    assert "**Title**" in page and "`the command`" in page and "**0.375**" in page and "numpy 2" in page
    assert (tmp_path / "docs/images/benchmarks.png").stat().st_size > 1000


@pytest.mark.system("libpython")
def test_a_smoke_run(tmp_path):
    """Steps of both FMUs in all hosts, the loop and the empty FMUs, with equal motion checked."""
    pytest.importorskip("ziglang")
    command = [sys.executable, "-m", "benchmarks", "steps", "--quick", "--output", str(tmp_path)]
    ran = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    rows = json.loads((tmp_path / "steps.json").read_text())["rows"]
    assert {row["peer"] for row in rows} >= {"empty pythonfmu slave", "empty FMU in C", "hand-written C loop"}
    assert all(row["ours"] > 0 for row in rows if not row["size"].startswith("slope"))
    assert table([json.loads((tmp_path / "steps.json").read_text())]).count("\n") == len(rows) + 2
