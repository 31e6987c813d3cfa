"""The wheel, in an environment that sees this one's dependencies but not the checkout: commands find their files."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from zipfile import ZipFile

import pytest

from build_fmu import main as build

ROOT = Path(__file__).parents[2]
PROJECT = ("build_fmu.py", "setup.py", "pyproject.toml", "MANIFEST.in", "README.md", "CHANGELOG.md", "LICENSE", "onnx")
PACKAGES = ("fmu_src", "psp_cli", "psp_model", "psp_traffic", "psp_view")


def environment() -> dict[str, str]:
    """This process's, without the path on which it finds the checkout."""
    return {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}


def built(kind: str, folder: Path, output: Path) -> Path:
    """What setuptools makes of the sources in a folder: `wheel` or `sdist`."""
    code = f"import sys; from setuptools.build_meta import build_{kind} as build; print(build(sys.argv[1]))"
    command = [sys.executable, "-c", code, str(output)]
    ran = subprocess.run(command, cwd=folder, env=environment(), capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    return output / ran.stdout.splitlines()[-1]


@pytest.fixture(scope="module")
def wheels(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """The wheel of the sources, in whose folder an older build has left something, and that of the sdist."""
    pytest.importorskip("setuptools", minversion="77")
    folder = tmp_path_factory.mktemp("sources")
    for name in (*PROJECT, *PACKAGES):
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, folder / name)
    (folder / "build/lib/psp_model").mkdir(parents=True)
    (folder / "build/lib/psp_model/stale.py").write_text("")
    output = tmp_path_factory.mktemp("built")
    shutil.unpack_archive(built("sdist", folder, output), output)
    (unpacked,) = (path for path in output.iterdir() if path.is_dir())
    return [built("wheel", folder, tmp_path_factory.mktemp("wheel")), built("wheel", unpacked, output)]


@pytest.fixture(scope="module")
def installed(wheels: list[Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of an environment's programs, `psp` among them."""
    folder = tmp_path_factory.mktemp("environment")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(folder)], check=True)
    python = folder / "bin" / "python"
    install = [sys.executable, "-m", "pip", "--python", str(python), "install", "--quiet", "--no-deps", "--no-index"]
    subprocess.run([*install, str(wheels[0])], check=True, env=environment())
    (packages,) = folder.glob("lib/*/site-packages")
    # found there without that folder's own .pth files, of which one leads an editable installation to the checkout
    seen = [path for path in sys.path if path.endswith("-packages")]
    (packages / "dependencies.pth").write_text("\n".join(seen) + "\n")
    return python.parent


@pytest.fixture
def empty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder to stand in."""
    folder = tmp_path / "empty"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


def psp(installed: Path, *arguments: str, code: int = 0) -> subprocess.CompletedProcess[str]:
    command = [str(installed / "psp"), *arguments]
    ran = subprocess.run(command, env=environment(), capture_output=True, text=True, check=False)
    assert ran.returncode == code, ran.stdout + ran.stderr
    return ran


def test_the_wheel_holds_what_the_checkout_has_at_its_root_and_nothing_stale(wheels: list[Path]) -> None:
    for path in wheels:
        with ZipFile(path) as wheel:
            packed = {name: wheel.read(name) for name in wheel.namelist() if "/packed/" in name}
            names = set(wheel.namelist())
        expected = [*(ROOT / "onnx").iterdir(), ROOT / "LICENSE"]
        assert packed == {f"psp_model/installed/packed/{p.relative_to(ROOT)}": p.read_bytes() for p in expected}
        assert "psp_model/stale.py" not in names and "psp_model/py.typed" in names
        assert not any(name.startswith(("onnx/", "tests/", "benchmarks/", "setup")) for name in names)


def test_the_sdist_makes_the_same_wheel(wheels: list[Path]) -> None:
    one, other = (ZipFile(path) for path in wheels)
    with one, other:
        assert one.namelist() == other.namelist()
        assert all(one.read(name) == other.read(name) for name in one.namelist())


def test_it_runs_from_the_wheel(installed: Path, empty: Path) -> None:
    code = "import psp_model, fmu_src, build_fmu; print(psp_model.__file__, fmu_src.__file__, build_fmu.__file__)"
    command = [str(installed / "python"), "-c", code]
    places = subprocess.run(command, env=environment(), capture_output=True, text=True, check=True).stdout.split()
    assert all(Path(place).is_relative_to(installed.parent) for place in places)


@pytest.mark.parametrize("options", [["-n", "3"], ["-n", "2", "--component", "controller", "--runtime", "native"]])
def test_an_fmu_is_the_same_as_from_the_checkout(installed: Path, empty: Path, options: list[str]) -> None:
    psp(installed, "build", *options, "-o", "wheel")
    assert build([*" ".join(options).replace("-n", "--vehicles").split(), "--output", "checkout"]) == 0
    (ours,), (theirs,) = empty.glob("wheel/*.fmu"), empty.glob("checkout/*.fmu")
    assert ours.name == theirs.name and ours.read_bytes() == theirs.read_bytes()


def test_build_and_simulate_in_an_empty_folder(installed: Path, empty: Path) -> None:
    psp(installed, "build")
    assert "smallest T_max" in psp(installed, "simulate", "--duration", "1").stdout
    assert [path.name for path in empty.iterdir()] == ["dist"]


def test_compare_certify_and_report_have_the_networks(installed: Path, empty: Path) -> None:
    heading = psp(installed, "compare", "--duration", "0.5").stdout.splitlines()[0]
    assert "V_new, network" in heading and "rollout" in heading
    assert "(network platoon_7.onnx" in psp(installed, "certify", "--start-only").stdout
    psp(installed, "report", "-n", "4", "--duration", "0.5")
    page = (empty / "out/report.html").read_text(encoding="utf-8")
    assert "network platoon_any.onnx, SHA-256" in page and "not a git checkout" in page


@pytest.mark.parametrize("command", ["compare", "certify", "report"])
def test_a_platoon_without_a_network_is_said_to_be_one(installed: Path, empty: Path, command: str) -> None:
    ran = psp(installed, command, "-n", "13", "--duration", "0.2")
    assert ran.stderr.startswith("psp: there is no network for 13 vehicles: ") and ran.stderr.count("\n") == 1


@pytest.mark.parametrize("command", ["build", "compare", "certify", "report"])
def test_lost_networks_are_not_taken_for_a_platoon_without_one(installed: Path, empty: Path, command: str) -> None:
    (folder,) = installed.parent.glob("lib/*/site-packages/psp_model/installed/packed/onnx")
    folder.rename(folder.with_name("lost"))
    try:
        said = psp(installed, command, code=2).stderr
    finally:
        folder.with_name("lost").rename(folder)
    assert "onnx holds no networks, although this project brings some" in said and said.count("\n") == 1
    assert not list(empty.iterdir())
