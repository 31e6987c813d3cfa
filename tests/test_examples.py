"""Every example runs, and every snippet and command of the README does."""

from __future__ import annotations

import importlib.util
import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from build_fmu import main as build
from psp_model import BEST_FIXED, PlatoonParameters, PlatoonState, simulate

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def workplace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that looks to the examples like the project after `make fmu`."""
    folder = tmp_path_factory.mktemp("workplace")
    assert build(["--output", str(folder / "dist")]) == 0
    return folder


def example(name: str):
    """The module of an example."""
    spec = importlib.util.spec_from_file_location(f"example_{name}", ROOT / "examples" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_scenarios_write_picture_and_csv_and_show_what_the_paper_says(workplace, monkeypatch, capsys):
    monkeypatch.chdir(workplace)
    runs = example("01_paper_scenarios").main()
    assert {path.name for path in Path("out").iterdir()} >= {"V_old.csv", "V_new.csv", "scenarios.png"}
    assert runs["V_old"].s[-1].min() > 20.0
    assert np.abs(runs["V_old"].a).max() > 30 * np.abs(runs["V_new"].a).max()
    assert "peak |acceleration| [m/s2]" in capsys.readouterr().out


def test_ten_lines_of_python(workplace, monkeypatch):
    monkeypatch.chdir(workplace)
    assert example("02_ten_lines_of_python").main()["time"][-1] == 20.0


def test_without_fmi():
    runs = example("03_without_fmi").main()
    assert runs["V_new"].J < runs["V_old"].J


def test_a_potential_of_my_own():
    runs = example("06_a_potential_of_my_own").main()
    own, ours = runs.values()
    assert own.J < ours.J and own.s.min() > 5.0


def test_a_potential_of_my_own_has_the_slope_of_its_value():
    own = example("06_a_potential_of_my_own").Quadratic(0.05, 12.0)
    s, h, constants = np.linspace(5.5, 14.0, 50), 1e-6, PlatoonParameters()
    finite = (own.value(s + h, constants) - own.value(s - h, constants)) / (2 * h)
    np.testing.assert_allclose(own.slope(s, constants), finite, rtol=1e-6, atol=1e-8)


def test_a_plant_of_my_own():
    runs = example("07_a_plant_of_my_own").main()
    none, short, long = (run.s for run in runs.values())
    assert np.abs(short - none).max() < np.abs(long - none).max()


def test_a_plant_of_my_own_with_hardly_any_lag_is_ideal():
    module = example("07_a_plant_of_my_own")
    start = PlatoonState([9.0, 10.5, 11.0], [30.0, 31.0, 29.0, 30.5])
    lagging = simulate(start, BEST_FIXED, plant=module.FirstOrderLag(1e-9))
    np.testing.assert_allclose(lagging.s, simulate(start, BEST_FIXED).s, rtol=0, atol=1e-6)


def test_a_vehicle_merges(workplace, monkeypatch):
    monkeypatch.chdir(workplace)
    result = example("05_a_vehicle_merges").main()
    n = result["n_active"]
    assert n[np.flatnonzero(np.diff(n, prepend=0.0))].tolist() == [3.0, 4.0, 3.0]
    assert result["gap_offered"].max() > 5.35 and result["s[3]"][-1] > 5.0


@pytest.mark.parametrize("snippet", re.findall(r"```python\n(.*?)```", README, re.DOTALL), ids=["fmi", "model"])
def test_a_python_snippet_of_the_readme(snippet, workplace):
    subprocess.run([sys.executable, "-c", snippet], cwd=workplace, check=True, capture_output=True)


COMMANDS = re.findall(r"^    (fmpy .*)$", README, re.MULTILINE)


@pytest.mark.parametrize("command", COMMANDS, ids=["info", "validate", "simulate"])
def test_a_command_of_the_readme(command, workplace):
    words = [word for word in shlex.split(command)[1:] if word != "--show-plot"]
    subprocess.run([sys.executable, "-m", "fmpy", *words], cwd=workplace, check=True, capture_output=True)


def test_examples_are_short_and_ask_a_question():
    for path in (ROOT / "examples").glob("[0-9]*.py"):
        text = path.read_text(encoding="utf-8")
        assert text.count("\n") <= 60 and text.split('"""')[1].rstrip().endswith("?")
