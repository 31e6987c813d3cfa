"""The command line: what it prints, what it refuses and with which exit code, and what it does not import."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pytest
from typer.testing import CliRunner

from build_fmu import main as build
from psp_cli.main import app
from psp_cli.quantities import quantity
from psp_cli.scenario import line_of, read_scenario
from psp_model import BEST_FIXED, PlatoonState, simulate
from psp_view.results import read_csv, run_from_result

HEAVY = {"numpy", "matplotlib", "rich", "onnxruntime", "jax", "casadi", "nicegui", "fmpy", "pydantic", "psp_model"}


def psp(*arguments: str):
    return CliRunner().invoke(app, arguments)


@pytest.fixture(scope="module")
def fmu(tmp_path_factory) -> str:
    folder = tmp_path_factory.mktemp("fmu")
    assert build(["--vehicles", "3", "--output", str(folder)]) == 0
    return str(folder / "PspPlatoon.fmu")


def test_help_names_every_command_and_imports_nothing_heavy():
    code = "import sys, psp_cli.main as m; m.app(['--help'], standalone_mode=False); print(*sys.modules)"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    *text, modules = out.strip().split("\n")
    for name in ("build", "simulate", "compare", "certify", "figures", "report", "explore"):
        assert any(line.startswith(f"  {name} ") for line in text)
    assert not HEAVY & set(modules.split())


def test_the_default_install_pulls_nothing_heavy():
    """All that pip installs for psp-platoon without extras, by the metadata of what is installed here."""
    from importlib.metadata import PackageNotFoundError, requires

    from packaging.requirements import Requirement

    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    found: set[str] = set()
    left = [Requirement(line) for line in project["dependencies"]]
    while left:
        one = left.pop()
        wanted = one.extras or {""}
        if one.name.lower() in found or (one.marker and not any(one.marker.evaluate({"extra": e}) for e in wanted)):
            continue
        found.add(one.name.lower())
        try:
            lines = requires(one.name) or []
        except PackageNotFoundError:
            continue
        inner = [Requirement(line) for line in lines]
        left += [r for r in inner if not r.marker or any(r.marker.evaluate({"extra": e}) for e in wanted)]
    assert {"numpy", "onnxruntime", "pythonfmu", "fmpy"} <= found
    banned = {"jax", "jaxlib", "casadi", "ziglang", "eclipse-sumo", "libsumo", "traci", "selenium", "playwright"}
    assert not found & (banned | {"matplotlib", "nicegui", "mkdocs"})


def test_build_makes_every_component(tmp_path):
    for component in ("platoon", "controller", "plant", "leader"):
        assert psp("build", "--vehicles", "2", "--component", component, "--output", str(tmp_path)).exit_code == 0
    for component in ("plant", "leader"):
        options = ("--vehicles", "2", "--component", component, "--runtime", "native", "--output", str(tmp_path))
        assert psp("build", *options).exit_code == 0
    assert len(list(tmp_path.glob("*.fmu"))) == 6
    profile = tmp_path / "profile.csv"
    profile.write_text("0,20\n10,50\n")
    refused = psp("build", "--component", "leader", "--profile", str(profile), "--output", str(tmp_path))
    assert refused.exit_code == 2 and "50 m/s in row 2" in refused.stderr


@pytest.mark.parametrize("command", ["build", "simulate", "compare", "certify", "figures", "report", "explore"])
def test_every_option_says_what_it_is(command):
    result = psp(command, "--help")
    assert result.exit_code == 0 and "--help" in result.stdout


def test_completion_is_there_for_bash():
    environment = {"_PSP_COMPLETE": "complete_bash", "COMP_WORDS": "psp comp", "COMP_CWORD": "1"}
    result = CliRunner().invoke(app, [], prog_name="psp", env=environment)
    assert "compare" in result.stdout


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["compare", "--set", "lamda=21"], "did you mean lambda"),
        (["compare", "--set", "T"], "has no '='"),
        (["compare", "--set", "T=10 m"], "has the unit 'm', which does not fit: use one of: s, ms, min"),
        (["compare", "--set", "T=soon"], "is not a number"),
        (["compare", "--set", "lambda=7"], "must exceed L + 3 m = 8 m"),
        (["compare", "--set", "s_start[3]=4.9"], "spacing s[3] = 4.9 m must exceed L = 5 m"),
        (["compare", "--set", "potential=3"], "a whole number from 1 to 2"),
        (["compare", "-n", "1"], "a platoon has at least 2"),
        (["compare", "--duration", "-1 s"], "must be positive"),
        (["certify", "--network", "nowhere.onnx"], "nowhere.onnx"),
        (["simulate", "nowhere.fmu"], "build it with `psp build`"),
        (["simulate", __file__], "cannot be read as an FMU"),
        (["figures", "--only", "pie"], "is not a figure"),
        (["compare", "--scenario", "nowhere.toml"], "cannot be read as a scenario"),
        (["explore", "-n", "99"], "choose 2 to 30"),
    ],
)
def test_bad_input_is_one_sentence_and_exit_code_2(arguments, sentence):
    result = psp(*arguments)
    assert result.exit_code == 2, result.output
    lines = result.stderr.strip().split("\n")
    assert len(lines) == 1 and lines[0].startswith("psp: ") and sentence in lines[0]


@pytest.mark.parametrize(
    ("given", "unit", "value"),
    [("10 ms", "s", 0.01), ("108 km/h", "m/s", 30.0), ("2e1", "m", 20.0), (".5 km", "m", 500.0), (3, "1", 3.0)],
)
def test_quantities(given, unit, value):
    assert quantity(given, unit, "x") == pytest.approx(value, rel=1e-15)


SCENARIO = """\
vehicles = 3
duration = "2 s"

[start]
spacings = [9.5, "1100 cm"]
speeds = ["108 km/h", 31.0, 29]

[set]
potential = 2
parameter_source = 2

[[runs]]
name = "gentle"
set = { z = 2.0, r_fixed = "12 m", p_fixed = 4 }

[[runs]]
name = "coarse"
[runs.set]
T = "20 ms"
"""


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "scenario.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_scenario_is_read_in_si_units(tmp_path):
    found = read_scenario(written(tmp_path, SCENARIO))
    assert found.values["s_start[3]"] == pytest.approx(11.0) and found.values["v_start[1]"] == pytest.approx(30.0)
    assert found.runs == {"gentle": {"z": 2.0, "r_fixed": 12.0, "p_fixed": 4.0}, "coarse": {"T": 0.02}}
    assert found.duration == 2.0


@pytest.mark.parametrize(
    ("old", "new", "line", "sentence"),
    [
        ("vehicles = 3", "vehicles = 1", 1, "vehicles"),
        ("vehicles = 3", "vehicles = ", 1, "not TOML"),
        ('"2 s"', '"2 m"', 2, "does not fit"),
        ('"2 s"', "true", 2, "duration"),
        ("spacings = [9.5,", "spacings = [9.5, 9.5,", 4, "3 spacings do not fit 3 vehicles"),
        ("spacings = ", "spacing = ", 5, "no such key"),
        ("potential = 2", "potentail = 2", 9, "did you mean potential"),
        ('name = "gentle"', 'nam = "gentle"', 12, "runs.0.name"),
        ('T = "20 ms"', 'T = "20 kg"', 19, "does not fit"),
        ('T = "20 ms"', "Tee = 1", 19, "not a parameter"),
    ],
)
def test_a_wrong_scenario_names_file_and_line(tmp_path, old, new, line, sentence):
    path = written(tmp_path, SCENARIO.replace(old, new))
    result = psp("compare", "--scenario", str(path))
    assert result.exit_code == 2
    assert result.stderr.startswith(f"psp: {path}:{line}: ") and sentence in result.stderr, result.stderr


def test_the_line_of_a_quoted_key():
    assert line_of('a = 1\n[set]\n"s_start[2]" = 3\n', ("set", "s_start[2]")) == 3


def test_compare_runs_what_the_scenario_names(tmp_path):
    result = psp("compare", "--scenario", str(written(tmp_path, SCENARIO)))
    assert result.exit_code == 0, result.output
    assert result.stdout.split("\n")[0].split() == ["gentle", "coarse"]


def test_simulate_gives_what_the_model_gives(fmu, tmp_path):
    csv = tmp_path / "out.csv"
    result = psp(
        "simulate",
        fmu,
        "--duration",
        "2 s",
        "--set",
        "s_start[2]=9.5",
        "--set",
        "parameter_source=2",
        "--csv",
        str(csv),
    )
    assert result.exit_code == 0, result.output
    run = run_from_result(read_csv(csv))
    same = simulate(PlatoonState(run.s[0], run.v[0]), BEST_FIXED, duration=2.0)
    assert run.s[0, 0] == 9.5
    for field in ("time", "x", "s", "v", "a", "T_max", "cost"):
        np.testing.assert_allclose(getattr(run, field), getattr(same, field), atol=1e-9)
    assert f"{same.J:.6g}" in result.stdout


def test_simulate_lists_parameters_with_units(fmu):
    lines = psp("simulate", fmu, "--list").stdout.split("\n")
    assert any(line.split()[:3] == ["v_max", "35.0", "m/s"] for line in lines)


def test_simulate_says_what_the_fmu_says(fmu):
    result = psp("simulate", fmu, "--set", "v_start[2]=36")
    assert result.exit_code == 2 and "speed v[2] = 36 m/s must lie in [0, 35] m/s" in result.stderr


SPOILED = [
    (rb'(name="T".*?)( start="[^"]*")', start) for start in (b"", b' start="nan"', b' start="-1"', b' start="1e-300"')
]


@pytest.mark.parametrize(("what", "instead"), [*SPOILED, (rb'(name=")(s\[3\]")', b'other"')])
def test_simulate_refuses_an_fmu_with_an_impossible_period_or_without_an_output(fmu, tmp_path, what, instead):
    spoiled = tmp_path / "spoiled.fmu"
    with ZipFile(fmu) as good, ZipFile(spoiled, "w") as bad:
        for name in good.namelist():
            content = good.read(name)
            if name == "modelDescription.xml":
                content = re.sub(what, rb"\1" + instead, content, count=1, flags=re.DOTALL)
            bad.writestr(name, content)
    result = psp("simulate", str(spoiled), "--duration", "1")
    assert result.exit_code == 2 and result.stderr.count("\n") == 1, result.stderr


def test_simulate_refuses_a_scenario_for_other_vehicles(fmu, tmp_path):
    path = written(tmp_path, "vehicles = 4\n")
    result = psp("simulate", fmu, "--scenario", str(path))
    assert result.exit_code == 2 and "contradicts" in result.stderr


def test_certify_says_who_when_and_how_much():
    fixed = ["--set", "parameter_source=2", "--duration", "2 s"]
    good = psp("certify", *fixed)
    assert good.exit_code == 0 and "certified (T_max/T = " in good.stdout and "vehicle" in good.stdout
    bad = psp("certify", "--set", "potential=1", "--set", "T=60 ms", "--duration", "2 s", "--seed", "1")
    assert bad.exit_code == 1 and "not certified from t = 0 s" in bad.stdout
    start = psp("certify", "--start-only", "--set", "potential=1", "--set", "T=60 ms", "--seed", "1")
    assert start.exit_code == 1 and "largest" not in start.stdout


def test_certify_goes_by_the_certificate_and_takes_the_extended_law():
    words = ["--set", "T=0.1", "--duration", "2 s", "--seed", "1", "--set", "parameter_source=2"]
    lemma1 = psp("certify", *words)
    assert lemma1.exit_code == 1 and "T_max = " in lemma1.stdout
    exact = psp("certify", *words, "--set", "certificate=2", "--set", "kappa=0.5", "--set", "length[2]=5.5 m")
    assert exact.exit_code == 0 and "T_exact = " in exact.stdout and "T_max" not in exact.stdout
    long = psp("certify", *words, "--set", "length[2]=50 m")
    assert long.exit_code == 2 and "must exceed the length of vehicle 2, 50 m" in long.stderr


def test_compare_takes_the_extended_law():
    words = ["compare", "--duration", "1 s", "--json", "-"]
    plain, viscous, told = (
        json.loads(psp(*words, *more).stdout)["runs"] for more in ([], ["--set", "kappa=1"], ["--set", "length[1]=5 m"])
    )
    assert plain != viscous and plain == told


def test_figures_of_choice_are_drawn(tmp_path):
    result = psp("figures", "--only", "potentials", "-o", str(tmp_path), "--pdf")
    assert result.exit_code == 0
    assert {path.name for path in tmp_path.iterdir()} == {"potentials.png", "potentials.pdf"}


@pytest.mark.parametrize(
    ("option", "name"),
    [
        ("report -o", "out.html"),
        ("simulate {fmu} --csv", "out.csv"),
        ("compare --plot", "out.png"),
        ("compare --json", "out.json"),
        ("figures --only runs -o", "out"),
    ],
)
def test_what_cannot_be_written_is_one_sentence_and_leaves_nothing(fmu, tmp_path, option, name):
    (tmp_path / "file").write_text("in the way")
    words = option.format(fmu=fmu).split()
    result = psp(*words, str(tmp_path / "file" / name), "--duration", "0.1")
    assert result.exit_code == 2, result.output
    (sentence,) = result.stderr.splitlines()
    assert "file" in sentence and "choose another place" in sentence
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["certify", "--set", "max_short_periods=inf"], "max_short_periods = inf is not one of its choices"),
        (["compare", "--duration", "1e300"], "1e+300 s are more than 10,000,000 instants"),
        (["certify", "--set", "T=1e-300"], "instants 1e-300 s apart"),
        (["certify", "--set", "rollout_horizon=1e9"], "1e+09 s are more than"),
        (["certify", "--vehicles", "1000000000"], "too many: choose at most 10000"),
        (["sumo", "highway", "--fmu", "pyproject.toml"], "cannot be read as an FMU"),
    ],
)
def test_what_would_never_end_or_fit_is_one_sentence(arguments, words):
    result = psp(*arguments)
    assert result.exit_code == 2
    (sentence,) = result.stderr.splitlines()
    assert words in sentence


@pytest.mark.parametrize(
    "text", ["vehicles = " + "1" * 5000, "a = " + "[" * 3000, "duration = 1" + "0" * 400, '"' + "x" * 9000 + '" = 1']
)
def test_hostile_scenarios_are_one_short_sentence(tmp_path, text):
    (tmp_path / "scenario.toml").write_text(text)
    result = psp("compare", "--scenario", str(tmp_path / "scenario.toml"))
    assert result.exit_code == 2, result.output
    (sentence,) = result.stderr.splitlines()
    assert "scenario.toml" in sentence and len(sentence) < 1100
