"""Wrong surroundings: the FMU in a C host, and `psp doctor`, name them for what they are."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from pathlib import Path
from zipfile import ZipFile

import pytest

from fmu_src import doctor
from native.hosting import host_arguments

BIN = Path(sys.executable).parent
BLOCK = """
import sys
class Without:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] == {package!r}:
            raise ModuleNotFoundError("No module named " + repr(name), name=name)
sys.meta_path.insert(0, Without())
"""
HIDE = """
import sys, importlib.machinery
class Hiding:
    def find_spec(self, name, path=None, target=None):
        if name == "onnxruntime":
            spec = importlib.machinery.ModuleSpec(name, None)
            spec.submodule_search_locations = [{folder!r}]
            return spec
sys.meta_path.insert(0, Hiding())
"""
# A file on PYTHONPATH, its content, and the words that FMU and doctor must say of it; none: all is well.
ON_PYTHONPATH = {
    "sitecustomize prints": ("sitecustomize.py", "import sys; print('hello'); sys.stdout.write('psp')", ()),
    "sitecustomize fails": ("sitecustomize.py", "raise RuntimeError('spoiled')", ()),
    "sitecustomize replaces print": ("sitecustomize.py", "import builtins; builtins.print = None", ()),
    "sitecustomize exits": ("sitecustomize.py", "raise SystemExit(3)", ("PYTHONPATH", "unset")),
    "encodings broken": ("encodings.py", "raise ImportError('spoiled')", ("PYTHONPATH", "spoiled", "unset")),
    "numpy missing": ("sitecustomize.py", BLOCK.format(package="numpy"), ("no numpy", "2.0", "pip install")),
    "numpy old": ("numpy.py", "__version__ = '1.26.4'", ("numpy 1.26.4", "2.0", "pip install")),
    "numpy broken": ("numpy.py", "raise ImportError('libblas.so.3: no such file')", ("libblas.so.3", "pip install")),
    "onnxruntime missing": ("sitecustomize.py", BLOCK.format(package="onnxruntime"), ("onnxruntime", "pip install")),
    "onnxruntime broken": ("onnxruntime.py", "raise OSError('libcudart.so: spoiled')", ("libcudart.so", "pip install")),
    "onnxruntime a leftover": ("onnxruntime/note.txt", "", ("onnxruntime", "pip install")),
}
# Environment variables, and the words.
VARIABLES = {
    "all is well": ({}, ()),
    "PYTHONHOME": ({"PYTHONHOME": "/nowhere"}, ("PYTHONHOME = /nowhere", "unset")),
    "PYTHONPATH": ({"PYTHONPATH": "/nowhere::garbage:/etc/passwd"}, ()),
    "PYTHONINSPECT": ({"PYTHONINSPECT": "1"}, ()),
    "PYTHONHASHSEED": ({"PYTHONHASHSEED": "none"}, ("does not start", "PYTHONHASHSEED")),
    "no HOME": ({"HOME": ""}, ()),
    "HOME a file": ({"HOME": "/etc/passwd"}, ()),
    "HOME missing": ({"HOME": "/nowhere"}, ()),
    "no PATH": ({"PATH": ""}, ("Python on PATH|python3 on PATH",)),
}
OTHER_PYTHONS = {
    "old": ("3.9.2", "64", "/lib/libpython.so", ("3.9.2", "3.11")),
    "32 bits": ("3.12.1", "32", "/lib/libpython.so", ("32 bits", "64")),
    "no library": ("3.12.1", "64", "", ("shared library", "libpython3.12")),
}


@pytest.fixture(autouse=True)
def needs_libpython() -> None:
    if not sysconfig.get_config_var("Py_ENABLE_SHARED"):
        pytest.skip("this Python has no shared library (Debian: libpython3.x)")


def _hosted(c_host: Path, fmu, environment: dict[str, str]) -> str:
    """What the FMU says in the C host; empty if it runs."""
    command = [str(c_host), *host_arguments(fmu, 0.01, 2, "J")]
    ran = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=120)
    assert ran.returncode in (0, 2, 3), ran.stderr
    assert len(ran.stdout.splitlines()) == (3 if ran.returncode == 0 else 0)
    said = [line for line in ran.stderr.splitlines() if line.startswith("host ")]  # Python itself may add some
    assert len(said) == (0 if ran.returncode == 0 else 1), ran.stderr
    return "".join(said)


def _examined(fmu, environment: dict[str, str], monkeypatch) -> str:
    """What `psp doctor` says is to be mended; empty if nothing is."""
    for name in ("PYTHONPATH", "PYTHONHOME", "PYTHONINSPECT", "HOME"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    return "\n".join(f"{one.text}: {one.remedy}" for one in doctor.examine(fmu.path) if not one.good)


def _must_say(said: str, words: tuple[str, ...]) -> None:
    assert "internal error" not in said and "report it" not in said
    assert bool(said) == bool(words), said
    for word in words:
        assert any(one in said for one in word.split("|")), (word, said)


@pytest.mark.parametrize("case", ON_PYTHONPATH)
def test_what_lies_on_pythonpath(c_host, python_fmu, tmp_path, monkeypatch, case):
    name, text, words = ON_PYTHONPATH[case]
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).write_text(text)
    environment = {"PATH": f"{BIN}:/usr/bin:/bin", "PYTHONPATH": str(tmp_path)}
    if case == "onnxruntime a leftover":  # a folder without code is found behind all packages only
        environment["PYTHONPATH"] += f":{_without_onnxruntime(tmp_path)}"
    _must_say(_hosted(c_host, python_fmu, environment), words)
    _must_say(_examined(python_fmu, environment, monkeypatch), words)


def _without_onnxruntime(folder: Path) -> Path:
    """A finder that hides the true onnxruntime, but not a folder of that name."""
    other = folder / "hiding"
    other.mkdir()
    (other / "sitecustomize.py").write_text(HIDE.format(folder=str(folder / "onnxruntime")))
    return other


@pytest.mark.parametrize("case", VARIABLES)
def test_environment_variables(c_host, python_fmu, monkeypatch, case):
    variables, words = VARIABLES[case]
    environment = {"PATH": f"{BIN}:/usr/bin:/bin"} | variables
    _must_say(_hosted(c_host, python_fmu, environment), words)
    _must_say(_examined(python_fmu, environment, monkeypatch), words)


@pytest.mark.parametrize("case", OTHER_PYTHONS)
def test_another_python_first_on_path(c_host, python_fmu, tmp_path, case):
    version, bits, library, words = OTHER_PYTHONS[case]
    answer = f"psp-executable:/usr/bin/python3\\npsp-version:{version}\\npsp-bits:{bits}\\npsp-library:{library}\\n"
    (tmp_path / "python3").write_text(f"#!/bin/sh\nprintf '{answer}'\n")
    (tmp_path / "python3").chmod(0o755)
    _must_say(_hosted(c_host, python_fmu, {"PATH": f"{tmp_path}:/bin"}), words)


def test_a_python_that_is_none(c_host, python_fmu, tmp_path, monkeypatch):
    (tmp_path / "python3").write_text("#!/bin/sh\necho 'version 3.99 is not installed' >&2\nexit 1\n")
    (tmp_path / "python3").chmod(0o755)
    environment = {"PATH": f"{tmp_path}:/usr/bin:/bin"}
    _must_say(_hosted(c_host, python_fmu, environment), ("does not start", "3.99"))
    _must_say(_examined(python_fmu, environment, monkeypatch), ("does not start", "3.99"))


def test_a_library_that_cannot_start_does_not_end_the_host(c_host, python_fmu):
    """Python would end the process where it cannot find its own modules."""
    library = Path(sysconfig.get_config_var("LIBDIR")) / sysconfig.get_config_var("INSTSONAME")
    environment = {"PATH": "/nowhere", "PSP_LIBPYTHON": str(library), "PYTHONHOME": "/nowhere"}
    command = [str(c_host), *host_arguments(python_fmu, 0.01, 2, "J")]
    said = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert said.returncode == 2 and "PYTHONHOME = /nowhere" in said.stderr.splitlines()[-1]


@pytest.mark.parametrize("cause", ["platoon.json", "onnx"])
def test_a_damaged_extraction_is_named(c_host, python_fmu, tmp_path, cause):
    with ZipFile(python_fmu.path) as archive:
        archive.extractall(tmp_path)
    for path in (tmp_path / "resources").glob(f"*{cause}"):
        path.write_bytes(b"{")
    said = subprocess.run(
        [str(c_host), str(tmp_path / "binaries/linux64/PspPlatoon.so"), (tmp_path / "resources").as_uri(),
         python_fmu.description.guid, "0.01", "2"],
        env={"PATH": f"{BIN}:/usr/bin:/bin"}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert said.returncode in (2, 3)
    _must_say(said.stderr, (cause,))


@pytest.fixture
def noexec(tmp_path) -> Iterator[Path]:
    """A folder on a file system mounted noexec."""
    folder = tmp_path / "noexec"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "noexec", "tmpfs", str(folder)]
    try:
        subprocess.run(mount, capture_output=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("this user may not mount a file system noexec")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


def test_a_temporary_folder_mounted_noexec(c_host, python_fmu, noexec, monkeypatch):
    """The launcher may lie elsewhere than the resources; the doctor says it before a host extracts anything."""
    shutil.copytree(python_fmu.folder / "resources", noexec / "resources")
    library, _, *rest = host_arguments(python_fmu, 0.01, 2)
    command = [str(c_host), library, (noexec / "resources").as_uri(), *rest]
    environment = {"PATH": f"{BIN}:/usr/bin:/bin"}
    ran = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert ran.returncode == 2
    _must_say(ran.stderr, ("noexec", "TMPDIR"))
    monkeypatch.setattr(doctor.tempfile, "gettempdir", lambda: str(noexec))
    _must_say(_examined(python_fmu, environment, monkeypatch), ("noexec", "TMPDIR"))
    command = [sys.executable, "-m", "psp_cli", "simulate", str(python_fmu.path), "--duration", "0.1"]
    environment = os.environ | {"TMPDIR": str(noexec), "PYTHONPATH": str(Path(doctor.__file__).parents[1])}
    ran = subprocess.run(command, env=environment, cwd=noexec, capture_output=True, text=True, check=False)
    assert ran.returncode == 2 and "noexec" in ran.stderr and "TMPDIR" in ran.stderr, ran.stderr


def test_nothing_is_written_into_home_and_nobody_is_asked(c_host, python_fmu, tmp_path):
    """onnxruntime's telemetry would do both; CI hides it, so it is unset here."""
    home = tmp_path / "home"
    home.mkdir()
    environment = {"PATH": f"{BIN}:/usr/bin:/bin", "HOME": str(home)}
    assert _hosted(c_host, python_fmu, environment) == ""
    assert list(home.rglob("*")) == []
    script = "import os; from psp_model.selection.network import import_onnxruntime as start; start(); "
    script += "print(os.environ['ORT_DISABLE_TELEMETRY'])"
    told = environment | {"PYTHONPATH": str(Path(doctor.__file__).parents[1])}
    for variables, expected in (({}, "1"), ({"ORT_DISABLE_TELEMETRY": "0"}, "0")):
        command = [sys.executable, "-c", script]
        ran = subprocess.run(command, env=told | variables, capture_output=True, text=True, check=True)
        assert ran.stdout.strip() == expected  # whoever has set it decides
