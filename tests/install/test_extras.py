"""Every command without its extra: one sentence, nothing written; and with it, nothing else is needed."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest
from typer.main import get_command
from typer.testing import CliRunner

import build_fmu
from psp_cli.extras import NEEDS, Need
from psp_cli.main import app
from psp_model.installed import extras
from psp_model.installed.extras import BRINGS, MissingExtra, explained, require

ROOT = Path(__file__).parents[2]
DISTRIBUTIONS = {"eclipse-sumo": "sumo", "imageio-ffmpeg": "imageio_ffmpeg", "dask[distributed]": "dask distributed"}
ALL = {module for modules in BRINGS.values() for module in modules}
# what each command does here; the last ones are a chain
RUNS = {
    "build": ["build -n 2 -o built", "build -n 2 --runtime native -o built"],
    "simulate": [
        "simulate platoon.fmu --duration 0.1 --csv run.csv --plot run.png",
        "simulate --leader leader.csv -n 2 --duration 0.1 --plot behind.png",
        "simulate --leader leader.csv -n 2 --duration 0.1 --runtime native",
    ],
    "compare": ["compare --duration 0.1", "compare -n 3 --duration 0.1 --plot runs.png"],
    "certify": ["certify --start-only"],
    "figures": ["figures --only potentials --only runs -n 3 --duration 0.1"],
    "report": ["report -n 3 --duration 0.1 -o r.html", "report -n 3 --duration 0.1 -o r.html --animate film.mp4"],
    "doctor": ["doctor platoon.fmu"],
    "sumo": ["sumo highway --starts 1 -o runs.json", "sumo ramp --plot spacings.png", "sumo ramp --runtime native"],
    "explore": ["explore --no-show"],
    "dataset": ["dataset -n 3 --starts 30 --effort tiny -o a.parquet", "dataset --scheduler nowhere"],
    "optimize": ["optimize --starts starts.csv --effort tiny -o optima.csv"],
    "train": ["train --data a.parquet -o network.onnx --epochs 1 --hidden 4 --curves curves"],
    "evaluate": ["evaluate --data a.parquet --network onnx/platoon_any.onnx --starts 2 --rollouts 2 --ipopt 1 --card"],
}
OFFLINE = [command for name in ("dataset", "optimize", "train", "evaluate") for command in RUNS[name]]
ENDS = {
    "doctor platoon.fmu": (0, 1),
    "dataset --scheduler nowhere": (2,),
}  # exit codes, where 0 is not the only good one
NOT_RUN = [*RUNS["explore"], *RUNS["sumo"]]  # it serves for ever; simulations in SUMO take long


def options_of(command: str) -> dict[str, Any]:
    """What the options of a command amount to."""
    name, *arguments = shlex.split(command)
    return dict(get_command(app).commands[name].make_context(name, arguments).params)


def needs_of(command: str) -> list[Need]:
    return [need for need in NEEDS[command.split()[0]] if need.when(options_of(command))]


def pairs() -> list[Any]:
    """Each command with each module that it needs."""
    commands = [command for runs in RUNS.values() for command in runs]
    return [
        pytest.param(command, need, module, id=f"{command.split()[0]} {need.option} {module}".replace("  ", " "))
        for command in commands
        for need in needs_of(command)
        for module in need.modules
    ]


def test_every_command_says_what_it_needs_and_is_asked_for_all_of_it(monkeypatch) -> None:
    monkeypatch.setattr("shutil.which", lambda name: None)  # no ffmpeg: the film needs the one of the extra
    assert set(NEEDS) == set(RUNS) == set(get_command(app).commands)
    for name, needs in NEEDS.items():
        asked = {need.option for command in RUNS[name] for need in needs_of(command)}
        assert asked == {need.option for need in needs}, name
        for need in needs:
            assert set(need.modules) <= set(BRINGS[need.extra]), need


def test_the_extras_bring_what_the_project_says() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    for extra, modules in BRINGS.items():
        lines = project["optional-dependencies"][extra]
        names = [re.split(r"[<>=!~]", line)[0] for line in lines]
        assert set(modules) == {part for name in names for part in DISTRIBUTIONS.get(name, name).split()}, extra


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to stand in, with a file in it."""
    (tmp_path / "platoon.fmu").write_bytes(b"left alone")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def files(folder: Path) -> dict[str, bytes]:
    return {str(path): path.read_bytes() if path.is_file() else b"" for path in sorted(folder.rglob("*"))}


@pytest.mark.parametrize(("command", "need", "module"), pairs())
def test_a_missing_package_is_one_sentence_and_nothing_is_written(
    folder: Path, monkeypatch: pytest.MonkeyPatch, command: str, need: Need, module: str
) -> None:
    before = files(folder)
    monkeypatch.setitem(sys.modules, module, None)
    result = CliRunner().invoke(app, shlex.split(command))
    (line,) = result.stderr.splitlines()
    what = f"psp {command.split()[0]} {need.option}".strip()
    assert result.exit_code == 2 and result.stdout == ""
    assert line.startswith(f"psp: {what} needs {module}, which the extra {need.extra} brings: install it by `pip ")
    assert f"[{need.extra}]" in line and files(folder) == before


@pytest.mark.parametrize("command", [runs[0] for name, runs in RUNS.items() if any(not n.option for n in NEEDS[name])])
def test_without_any_extra_it_is_one_sentence_that_names_all_that_is_missing(folder: Path, command: str) -> None:
    before = files(folder)
    ran = run(command, folder, ALL)
    (line,) = ran.stderr.splitlines()
    need = NEEDS[command.split()[0]][0]
    assert ran.returncode == 2 and ran.stdout == "" and files(folder) == before
    assert all(module in line for module in need.modules) and f"the extra {need.extra} brings" in line


@pytest.mark.parametrize("module", BRINGS["native"])
def test_build_fmu_says_it_in_one_sentence_too(folder: Path, monkeypatch, capsys, module: str) -> None:
    before = files(folder)
    monkeypatch.setitem(sys.modules, module, None)
    assert build_fmu.main(["--runtime", "native", "--output", str(folder / "dist")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"build_fmu.py: a native FMU needs {module}, which the extra native brings: install it by")
    assert files(folder) == before


def run(command: str, folder: Path, hidden: set[str]) -> subprocess.CompletedProcess[str]:
    """A command of psp in a process, and in all that it starts, that find none of the hidden modules."""
    path = os.pathsep.join(map(str, (Path(__file__).parent / "hiding", ROOT, ROOT / "tests")))
    environment = os.environ | {"PYTHONPATH": path, "PSP_HIDDEN": " ".join(hidden)}
    code = "import sys; from psp_cli.main import app"
    code += "; from small_problems import teach_tiny; teach_tiny()" if command in OFFLINE else ""
    arguments = [sys.executable, "-c", f"{code}; app(sys.argv[1:], prog_name='psp')", *shlex.split(command)]
    return subprocess.run(arguments, cwd=folder, env=environment, capture_output=True, text=True, check=False)


def run_with_what_it_needs(command: str, folder: Path) -> None:
    """Run a command that finds of all extras only what it says it needs."""
    needed = {module for need in needs_of(command) for module in need.modules}
    needed |= {"dask"} if "distributed" in needed else set()  # each is half of the other
    ran = run(command, folder, ALL - needed)
    assert ran.returncode in ENDS.get(command, (0,)) and "which the extra" not in ran.stderr, ran.stdout + ran.stderr


@pytest.fixture(scope="module")
def workplace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with an FMU."""
    folder = tmp_path_factory.mktemp("workplace")
    assert build_fmu.main(["--vehicles", "2", "--output", str(folder)]) == 0
    (folder / "PspPlatoon.fmu").rename(folder / "platoon.fmu")
    (folder / "leader.csv").write_text("time,speed\n0,30\n1,29\n")
    return folder


@pytest.mark.parametrize("command", [c for runs in RUNS.values() for c in runs if c not in NOT_RUN + OFFLINE])
def test_a_command_needs_nothing_but_what_it_says(workplace: Path, command: str) -> None:
    run_with_what_it_needs(command, workplace)


def test_the_offline_half_needs_nothing_but_what_it_says(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "onnx", tmp_path / "onnx")
    (tmp_path / "starts.csv").write_text("s_2,s_3,v_1,v_2,v_3\n9.0,10.5,30,31,29\n")
    for command in OFFLINE:
        run_with_what_it_needs(command, tmp_path)


def test_a_package_that_cannot_be_loaded_is_not_called_missing(tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "broken_package.py").write_text("raise ImportError('libX11.so.6: cannot open shared object file')\n")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(MissingExtra) as caught:
        require("psp sumo", "sumo", ["broken_package"])
    assert str(caught.value) == (
        "psp sumo needs broken_package, which is installed but cannot be loaded (libX11.so.6: cannot open shared "
        "object file): install what that names, or broken_package anew"
    )


def test_imports_that_no_check_asked_for_are_explained_where_an_extra_brings_them() -> None:
    assert "the extra offline brings" in str(explained(ModuleNotFoundError(name="jax.numpy"), "this"))
    assert "cannot be loaded (x)" in str(explained(ImportError("x", name="matplotlib.ft2font"), "this"))
    assert explained(ModuleNotFoundError(name="psp_model.gone"), "this") is None


@pytest.mark.parametrize(
    ("origin", "command"),
    [
        ('{"url": "file:///there", "dir_info": {}}', "`pip install 'psp-platoon[film] @ file:///there'`"),
        ('{"url": "https://x.org/p.git", "vcs_info": {"vcs": "git"}}', "[film] @ git+https://x.org/p.git'`"),
        (None, "`pip install '.[film]'` in a checkout of the project"),
        ("no JSON", "`pip install '.[film]'` in a checkout of the project"),
    ],
)
def test_an_extra_comes_from_where_the_project_came_from(monkeypatch, origin: str | None, command: str) -> None:
    class Installed:
        def read_text(self, name: str) -> str | None:
            return origin

    monkeypatch.setattr(extras, "checkout", lambda: None)
    monkeypatch.setattr(extras, "distribution", lambda name: Installed())
    assert extras.install_command("film").endswith(command)
