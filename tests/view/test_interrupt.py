"""Ctrl-C: every command ends at once with exit code 130 and one sentence, and leaves nothing half-written behind."""

from __future__ import annotations

import ast
import os
import random
import re
import shlex
import signal
import subprocess
import sys
import time
import tomllib
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

from build_fmu import main as build
from psp_model.offline.dataset import make_dataset
from psp_model.offline.plan import Plan
from psp_model.selection.search.engine import Problem

if not Path("/proc/self/task").is_dir():
    pytest.skip("when the handler is there is seen in /proc", allow_module_level=True)

ROOT = Path(__file__).parents[2]
PSP = "-m psp_cli"
COMMANDS = {
    "build": f"{PSP} build -n 30 -o out",
    "build native": f"{PSP} build --runtime native --platforms all -o out",
    "simulate": f"{PSP} simulate {{given}}/PspPlatoon.fmu --duration 2000 --csv out/run.csv",
    "compare": f"{PSP} compare -n 300 --plot out/runs.png",
    "certify": f"{PSP} certify -n 400 --duration 100",
    "figures": f"{PSP} figures -o out",
    "report": f"{PSP} report --duration 60 -o out/report.html --animate out/film.gif",
    "explore": f"{PSP} explore --no-show --port 8137",
    "dataset": f"{PSP} dataset --starts 500 --chunk 5 -o out/data.parquet",
    "optimize": f"{PSP} optimize --starts {{given}}/starts.csv -o out/optima.csv",
    "train": f"{PSP} train --data {{given}}/data.parquet -o out/network.onnx --curves out --epochs 4000",
    "evaluate": f"{PSP} evaluate --data {{given}}/data.parquet --network {ROOT}/onnx/platoon_any.onnx -o out --ipopt 9",
    "doctor": f"{PSP} doctor {{given}}/PspPlatoon.fmu",
    "sumo": f"{PSP} sumo highway --output out/runs.json",
    "sweep": f"{PSP} sumo --sweep --output out/sweep.json",
    "build_fmu.py": f"{ROOT}/build_fmu.py --vehicles 30 --output out",
    "benchmarks": "-m benchmarks --quick --output out",
    "torture": "-m torture --share 0.01 --output out",
    "a benchmark's script": f"{ROOT}/benchmarks/offline_speed.py",
    "an example": f"{ROOT}/examples/04_in_sumo.py",
}
NEEDS = {"sumo": "libsumo", "sweep": "libsumo", "an example": "libsumo", "explore": "nicegui"}
PROGRAMS = ["psp_cli", "psp_model", "psp_traffic", "psp_view", "fmu_src", "benchmarks", "tests/torture", "examples"]
STARTS = {f"subprocess.{name}" for name in ("run", "Popen", "check_call", "check_output", "call")} | {"os.system"}
SENTENCE = re.compile(r"[\w.]+: interrupted(: `.+` goes on from here)?")


@pytest.fixture(autouse=True)
def listens() -> Iterator[None]:
    """What is started does not ignore Ctrl-C, as it would from tests in the background of a shell."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(scope="module")
def given(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the commands work on."""
    folder = tmp_path_factory.mktemp("given")
    assert build(["--output", str(folder)]) == 0
    make_dataset(Plan(8, 1, Problem(3), effort="quick"), folder / "data.parquet")
    rows = "9,10,11,30,31,29,30\n" * 2000
    (folder / "starts.csv").write_text("s_2,s_3,s_4,v_1,v_2,v_3,v_4\n" + rows)
    return folder


def begin(arguments: str, folder: Path) -> subprocess.Popen[str]:
    """Start a program in a group of its own, and wait until it looks after Ctrl-C."""
    (folder / "tmp").mkdir(exist_ok=True)
    (folder / "out").mkdir(exist_ok=True)
    path = os.pathsep.join(map(str, [ROOT, ROOT / "tests"]))
    process = subprocess.Popen(
        [sys.executable, *arguments.split()],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": path, "TMPDIR": str(folder / "tmp"), "ORT_DISABLE_TELEMETRY": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    while process.poll() is None and len(os.listdir(f"/proc/{process.pid}/task")) < 2:
        time.sleep(0.002)
    return process


def end(process: subprocess.Popen[str], group: bool, times: int = 1) -> tuple[int, str, str]:
    """Press Ctrl-C; exit code and what was said."""
    for _ in range(times):
        (os.killpg if group else os.kill)(process.pid, signal.SIGINT)
    stdout, stderr = process.communicate(timeout=60)
    return process.returncode, stdout, stderr


def left_over(folder: Path) -> list[str]:
    """Files that an interrupted command should have removed."""
    temporary = [path.name for path in (folder / "tmp").iterdir() if path.name != ".ses"]
    return temporary + [str(path) for path in folder.rglob(".*.partial*")]


EARLY = ["build", "explore", "train", "sumo", "build_fmu.py", "torture"]
CASES = [(name, True) for name in COMMANDS] + [(name, False) for name in EARLY]


@pytest.mark.parametrize(("name", "late"), CASES, ids=[f"{n} {'at work' if late else 'early'}" for n, late in CASES])
def test_one_sentence_and_nothing_half_written(given: Path, tmp_path: Path, name: str, late: bool) -> None:
    if name in NEEDS and find_spec(NEEDS[name]) is None:
        pytest.skip(f"{name} needs {NEEDS[name]}")
    delay = random.uniform(0.3, 0.9) if late else random.uniform(0.0, 0.3)
    process = begin(COMMANDS[name].format(given=given), tmp_path)
    time.sleep(delay)
    code, _, stderr = end(process, group=late)
    if code == 0 or (code == 1 and name == "doctor" and not stderr):  # 1: something has to be mended on this machine
        pytest.skip(f"was done before {delay:.2f} s had passed")
    said = [line for line in stderr.splitlines() if "interrupted" in line]
    assert code == 130 and len(said) == 1 and SENTENCE.fullmatch(said[0]), f"after {delay} s: {code} {stderr}"
    assert "Traceback" not in stderr and "KeyboardInterrupt" not in stderr and stderr.endswith(said[0] + "\n")
    assert left_over(tmp_path) == []


def test_the_installed_command_starts_where_ctrl_c_is_looked_after() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["scripts"] == {"psp": "psp_cli.entry:main"}


def test_a_data_set_says_how_to_go_on_and_goes_on(tmp_path: Path) -> None:
    process = begin(f"{PSP} dataset -n 3 --starts 3 --effort quick --chunk 1 -o out/data.parquet", tmp_path)
    while process.poll() is None and len(list((tmp_path / "out").rglob("*.npz"))) < 1:
        time.sleep(0.01)
    code, _, stderr = end(process, group=True, times=3)
    assert code == 130
    command = re.search(r"`psp (.*)` goes on from here", stderr)
    assert command is not None and "--resume" in command[1]
    again = begin(f"{PSP} {command[1]}", tmp_path)
    _, stderr = again.communicate(timeout=120)
    assert again.returncode == 0 and (tmp_path / "out" / "data.parquet").exists(), stderr


def test_ctrl_c_in_a_long_call_of_a_c_library(tmp_path: Path) -> None:
    """The main thread, which the signal does not reach, comes back to Python later than the test would wait."""
    script = tmp_path / "long_call.py"
    script.write_text(
        "from psp_cli.interrupt import run\n"
        "def main():\n"
        "    import ctypes, signal, tempfile\n"
        "    signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])\n"
        "    folder = tempfile.TemporaryDirectory()\n"
        "    print('waiting', flush=True)\n"
        "    ctypes.CDLL(None).sleep(600)\n"
        "run('long_call', main)\n"
    )
    process = begin(str(script), tmp_path)
    assert process.stdout is not None and process.stdout.readline() == "waiting\n"
    assert end(process, group=False)[::2] == (130, "long_call: interrupted\n")
    assert left_over(tmp_path) == []


def test_a_compiler_that_is_just_starting_says_nothing(tmp_path: Path) -> None:
    """Ctrl-C reaches it too; Python prints a traceback, as does `python -m ziglang` before zig has begun."""
    script = tmp_path / "compiles.py"
    script.write_text(
        "from psp_cli.interrupt import run\n"
        "def main():\n"
        "    import pathlib, sys\n"
        "    from fmu_src.toolchain.compile import run_compiler\n"
        "    child = 'import time; print(\"begun\", flush=True); time.sleep(600)'\n"
        "    run_compiler([sys.executable, '-c', child], pathlib.Path())\n"
        "run('compiles', main)\n"
    )
    process = begin(str(script), tmp_path)
    assert process.stdout is not None and process.stdout.readline() == "begun\n"
    assert end(process, group=True)[::2] == (130, "compiles: interrupted\n")


def test_no_child_of_a_program_writes_to_its_stderr() -> None:
    """What it says of a Ctrl-C would stand beside the one sentence."""
    found = 0
    for path in (path for part in PROGRAMS for path in sorted((ROOT / part).rglob("*.py"))):
        for call in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(call, ast.Call) and ast.unparse(call.func) in STARTS:
                taken = {keyword.arg for keyword in call.keywords} & {"capture_output", "stderr"}
                assert taken, f"{path.relative_to(ROOT)}:{call.lineno} leaves stderr to what it starts"
                found += 1
    assert found > 10


def test_pressing_again_while_it_cleans_up_changes_nothing(given: Path, tmp_path: Path) -> None:
    for times in range(2, 6):
        process = begin(COMMANDS["report"].format(given=given), tmp_path)
        time.sleep(random.uniform(0, 0.6))
        assert end(process, group=True, times=times)[::2] == (130, "psp: interrupted\n")


def test_children_end_with_the_command(tmp_path: Path) -> None:
    """Also those that care for no Ctrl-C, and theirs."""
    script = tmp_path / "children.py"
    child = "trap '' INT; sh -c 'while :; do sleep 1; done' & while :; do echo noise >&2; sleep 0.05; done"
    script.write_text(
        "import subprocess\nfrom psp_cli.interrupt import run\n"
        f"run('children', lambda: subprocess.run(['sh', '-c', {child!r}, {str(tmp_path)!r}], check=True))\n"
    )
    process = begin(str(script), tmp_path)
    time.sleep(0.4)
    code, _, stderr = end(process, group=False)
    assert code == 130 and stderr.endswith("children: interrupted\n") and stderr.count("interrupted") == 1
    alive = subprocess.run(["ps", "-o", "args", "-g", str(process.pid)], capture_output=True, text=True, check=False)
    assert shlex.quote(str(tmp_path)) not in alive.stdout


def test_inside_another_program_it_is_one_sentence_too(monkeypatch: pytest.MonkeyPatch) -> None:
    from typer.testing import CliRunner

    from psp_cli.main import app

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("fmu_src.doctor.examine", interrupted)
    result = CliRunner().invoke(app, ["doctor", "any.fmu"])
    assert (result.exit_code, result.stderr) == (130, "psp: interrupted\n")
