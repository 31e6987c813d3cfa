"""What commands write for other programs: JSON and CSV, files and standard output, and less where asked for."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.main import get_command
from typer.testing import CliRunner

import build_fmu
from psp_cli.main import app
from psp_view.results import read_csv

ROOT = Path(__file__).parents[2]


def psp(*arguments: str) -> Any:
    return CliRunner().invoke(app, arguments)


def process(*arguments: str, **options: Any) -> subprocess.CompletedProcess[str]:
    """A command in a process of its own, where libraries write to file descriptors."""
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "psp_cli", *arguments]
    return subprocess.run(command, capture_output=True, text=True, env=environment, check=False, **options)


def no_constant(text: str) -> None:
    raise AssertionError(f"{text} is not JSON")


def strict(text: str) -> Any:
    """JSON as other languages read it: without NaN and Infinity."""
    return json.loads(text, parse_constant=no_constant)


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build_fmu.make(build_fmu.Options(vehicles=3, output=tmp_path_factory.mktemp("fmu")))[0]


def test_the_version_is_that_of_the_project() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert psp("--version").stdout == f"psp {project['version']}\n"


@pytest.mark.parametrize("command", get_command(app).commands)  # type: ignore[attr-defined]
def test_every_command_can_be_quiet(command: str) -> None:
    assert "-q, --quiet" in psp(command, "--help").stdout


TABLES: list[tuple[str, Callable[[Any], bool]]] = [
    ("compare --duration 0.2", lambda found: found["runs"]["V_old"]["figures"]["r"] == {"value": 0.0, "unit": "m"}),
    ("certify --duration 0.2 --set T='10 ms'", lambda found: found["certified"] and found["start"]["T"] == 0.01),
    ("certify --start-only", lambda found: found["start"]["T_max"] > 0.01 and "tightest" not in found),
    ("simulate {fmu} --duration 0.2", lambda found: found["runs"]["PspPlatoon"]["smallest spacing"]["unit"] == "m"),
    ("simulate {fmu} --list", lambda found: "L" in [one["name"] for one in found["parameters"]]),
    ("doctor {fmu}", lambda found: found["good"] == all(finding["good"] for finding in found["findings"])),
]


@pytest.mark.parametrize(("words", "holds"), TABLES, ids=[words for words, _ in TABLES])
def test_json_of_a_table(fmu: Path, tmp_path: Path, words: str, holds: Callable[[Any], bool]) -> None:
    arguments = words.replace("'", "").format(fmu=fmu).replace("10 ms", "0.01").split()
    plain = psp(*arguments)
    for given in (["--json"], ["-q", "--json", "-"]):
        found = psp(*arguments, *given)
        assert found.exit_code == plain.exit_code and holds(strict(found.stdout)), found.output
        assert ("-q" in given) or plain.stdout in found.stderr
    file = tmp_path / "new" / "table.json"
    assert psp(*arguments, "--json", str(file)).stdout == plain.stdout
    assert holds(strict(file.read_text(encoding="utf-8")))


def test_json_before_an_argument_does_not_take_it_for_its_file(fmu: Path) -> None:
    content = fmu.read_bytes()
    found = psp("doctor", "--json", str(fmu))
    assert strict(found.stdout)["fmu"] == str(fmu) and fmu.read_bytes() == content
    assert psp("doctor", f"--json={fmu}", str(fmu)).exit_code == 2 and fmu.read_bytes() == content


@pytest.mark.parametrize(
    "words", ["simulate {fmu} --duration 0.2 --csv -", "sumo highway --starts 1 --duration 15 --json -"]
)
def test_standard_output_carries_nothing_but_the_data(fmu: Path, tmp_path: Path, words: str) -> None:
    if words.startswith("sumo"):
        pytest.importorskip("libsumo")
    ran = process(*words.format(fmu=fmu).split(), cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    if "--csv" in words:
        (tmp_path / "out.csv").write_text(ran.stdout)
        assert len(read_csv(tmp_path / "out.csv")) == 21 and "smallest spacing" in ran.stderr
    else:
        assert set(strict(ran.stdout)["situations"]["highway"]) == {"V_new", "V_old", "IDM", "ACC", "CACC"}


def test_what_a_library_writes_to_its_descriptor_is_no_data(tmp_path: Path) -> None:
    code = (
        "import os, sys; from psp_cli import output\n"
        "with output.speaking():\n"
        "    output.keep_stdout('-')\n"
        "    os.write(1, b'from C'); print('from Python'); output.say('said'); output.kept_stdout().write('data')\n"
        "print('after')\n"
    )
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=True)
    assert ran.stdout == "dataafter\n" and sorted(ran.stderr.split()) == sorted(["from", "Cfrom", "Python", "said"])


def test_who_has_seen_enough_is_told_nothing(fmu: Path) -> None:
    command = f"{sys.executable} -m psp_cli simulate {fmu} --duration 40 --csv - -q | head -1"
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    ran = subprocess.run(["bash", "-c", command], capture_output=True, text=True, env=environment, check=True)
    assert ran.stdout.startswith('"time"') and ran.stderr == ""


def test_quiet_says_errors_only(fmu: Path) -> None:
    for words in ("compare --set mu=0.6 --duration 0.2", "certify --set mu=0.6 --duration 0.2", f"simulate {fmu}"):
        arguments = words.split()
        assert psp(*arguments, "-q").output == "" == psp("-q", *arguments).output
    assert psp("-q", "simulate", "nowhere.fmu").stderr.startswith("psp: nowhere.fmu does not exist")
    bad = psp("doctor", "-q", __file__)
    assert bad.exit_code == 1 and bad.stdout == "" and bad.stderr.startswith("psp: ")
    assert psp("compare", "--duration", "0.2").stdout != ""  # the next one is not quiet


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("compare --plot a.jpg", "--plot a.jpg ends in none of the formats"),
        ("compare --plot picture", "give it a name with .png, .svg or .pdf"),
        ("simulate none.fmu --plot a.html", "--plot a.html"),
        ("sumo highway --plot a.mp4", "--plot a.mp4"),
        ("report -o a.pdf", "give it a name with .html or .htm"),
        ("report --animate a.avi", "give it a name with .mp4 or .gif"),
        ("compare --json a.txt", "--json a.txt does not end in .json"),
        ("simulate {fmu} --json --csv -", "two options write to standard output"),
        ("simulate {fmu} --csv - --scenario two.toml", "--csv - takes one run, not the 2 of two.toml"),
    ],
)
def test_places_that_are_refused_before_any_work(
    fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: str, sentence: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("two.toml").write_text("vehicles = 3\n[[runs]]\nname = 'a'\n[[runs]]\nname = 'b'\n")
    result = psp(*words.format(fmu=fmu).split())
    assert result.exit_code == 2 and result.stderr.startswith("psp: ") and sentence in result.stderr, result.output
    assert result.stderr.count("\n") == 1 and [path.name for path in tmp_path.iterdir()] == ["two.toml"]


@pytest.mark.parametrize(
    "words",
    [
        "-n 1",
        "-n 10001",
        "--component plant --network any.onnx",
        "--profile speeds.csv",
        "--network none.onnx",
        "-o file/below",
    ],
)
def test_errors_of_build_are_those_of_psp_and_the_script_says_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], words: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("in the way")
    result = psp("build", *words.split())
    assert result.exit_code == 2 and result.stdout == "" and result.stderr.count("\n") == 1
    assert result.stderr.startswith("psp: ") and "build_fmu" not in result.stderr
    long = words.replace("-n ", "--vehicles ").replace("-o ", "--output ")
    assert build_fmu.main(long.split()) == 2
    said = capsys.readouterr().err
    assert said.startswith("build_fmu.py: ") and said.count("\n") == 1
    if "file/below" not in words:
        assert said.removeprefix("build_fmu.py: ") == result.stderr.removeprefix("psp: ")


def test_a_column_that_would_repeat_another_one_is_not_printed_but_the_reason_is() -> None:
    outside = psp("compare", "--set", "mu=0.6", "--duration", "0.5", "--json")
    assert list(strict(outside.stdout)["runs"]) == ["V_old", "V_new, fixed"]
    assert list(strict(outside.stdout)["left_out"]) == ["V_new, network", "V_new, network and rollout"]
    said = [line for line in outside.stderr.splitlines() if line.startswith("psp: ")]
    reason = "is left out: it would repeat V_new, fixed: the initial state has other constants"
    assert len(said) == 2 and all(reason in one for one in said)
    missing = psp("compare", "-n", "33", "--duration", "0.5")
    assert missing.stdout.split("\n")[0].split("  ")[-2:] == ["V_old", "V_new, fixed"]
    assert "there is no network for 33 vehicles" in missing.stderr


def test_runs_of_a_scenario_that_are_the_same_are_shown_once(tmp_path: Path) -> None:
    same, other = "[[runs]]\nname = '{}'\nset = {{ parameter_source = 2, {} }}\n", "alpha_fixed = 0.001"
    runs = {"a": "p_fixed = 5", "b": f"p_fixed = 5.0, {other}", "c": "p_fixed = 4"}
    text = "".join(same.format(name, values) for name, values in runs.items())
    (tmp_path / "scenario.toml").write_text('duration = "0.5 s"\n' + text)
    result = psp("compare", "--scenario", str(tmp_path / "scenario.toml"))
    assert result.stdout.split("\n")[0].split() == ["a", "c"]
    assert "psp: b is left out: it would repeat a: alpha, r, p are the same" in result.stderr


@pytest.mark.parametrize(
    ("words", "origin"),
    [
        ("", r"network platoon_7\.onnx, from the initial state"),
        ("--set parameter_source=2", "alpha_fixed, r_fixed, p_fixed"),
        ("-n 33", "the fixed triple, because there is no network for 33 vehicles"),
        ("--set mu=0.6", "fixed: the fallback, because the network cannot be used here"),
        ("--set potential=1", "V_old: no hill"),
    ],
)
def test_certify_says_what_was_used(words: str, origin: str) -> None:
    result = psp("certify", "--start-only", *words.split())
    assert re.search(rf"\({origin}\)$", result.stdout.splitlines()[0]), result.stdout
