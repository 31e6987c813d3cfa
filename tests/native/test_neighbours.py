"""The Python FMU in its hosts: beside other people's FMUs, loaded over and over, interrupted, outliving Python."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fmu_src.toolchain.compile import FMI_HEADERS
from native.hosting import host_arguments

HERE = Path(__file__).parent


def _host(*arguments: object) -> Any:
    """What a host of `python_host.py` puts out."""
    command = [sys.executable, "-m", "native.python_host", *map(str, arguments)]
    environment = os.environ | {"PYTHONPATH": f"{HERE.parent}{os.pathsep}{HERE.parents[1]}"}
    ran = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=300)
    assert ran.returncode == 0, ran.stderr[-2000:]
    return json.loads(ran.stdout.splitlines()[-1])


def _without_signals(archive: Path, folder: Path, steps: int) -> list[float]:
    return _host("interrupted", archive, folder, steps, "")["outputs"]


@pytest.fixture(scope="module")
def foreign(tmp_path_factory) -> Path:
    """An FMU of somebody else's, packed by pythonfmu."""
    folder = tmp_path_factory.mktemp("foreign")
    command = [sys.executable, "-m", "pythonfmu", "build", "-f", str(HERE / "foreign_slave.py"), "-d", str(folder)]
    subprocess.run(command, check=True, capture_output=True)
    return folder / "ForeignSlave.fmu"


@pytest.fixture(scope="module")
def of_another_version(foreign) -> Path:
    """The same one with a pythonfmu whose slaves log in another way and whose enumerations are elsewhere."""
    path = foreign.parent / "another.fmu"
    with zipfile.ZipFile(foreign) as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            text = old.read(name)
            if name == "resources/pythonfmu/_version.py":
                text = b'__version__ = "9.9.9"\n'
            if name == "resources/pythonfmu/fmi2slave.py":
                text = text.replace(b"    def log(", b"    def log_text(").replace(
                    b".enums import Fmi2Type, ", b".enums import "
                )
                text = text.replace(b"Fmi2Status.ok", b"0")
            if name == "resources/pythonfmu/enums.py":
                text = text.replace(b"class Fmi2Status(IntEnum)", b"class Status(IntEnum)") + b"Fmi2Status = None\n"
            new.writestr(name, text)
    return path


@pytest.mark.parametrize("version", ["foreign", "of_another_version"])
@pytest.mark.parametrize("ours_first", [True, False])
def test_ours_lives_beside_other_pythonfmu_fmus(python_fmu, tmp_path, request, version, ours_first):
    theirs = request.getfixturevalue(version)
    order = [python_fmu.path, theirs] if ours_first else [theirs, python_fmu.path]
    found = dict(zip(order, _host("neighbours", *order), strict=True))
    y, pythonfmu = found[theirs]
    assert y == pytest.approx(0.2) and pythonfmu == (999.0 if version == "of_another_version" else 70.0)
    assert found[python_fmu.path] == _without_signals(python_fmu.path, tmp_path, 20)


def test_hundreds_of_loads_hold_no_more_than_a_few(python_fmu):
    held = _host("loads", python_fmu.path, 200, 20)
    mappings = [each[0] for each in held]
    assert held[-1][1:] == held[1][1:]
    assert max(mappings) - min(mappings) <= 8, mappings  # the heap's own; it were 12 for each load


@pytest.mark.parametrize("signal", ["SIGINT", "SIGTERM", "SIGALRM"])
def test_a_signal_reaches_the_host_with_every_step_whole(python_fmu, tmp_path, signal):
    """Also where the host's handler raises something else than KeyboardInterrupt."""
    found = _host("interrupted", python_fmu.path, tmp_path / "a", 2000, signal)
    assert found["messages"] == [] and found["caught"] > 5
    assert found["outputs"] == _without_signals(python_fmu.path, tmp_path / "b", found["steps"])


def test_an_instance_may_be_freed_while_python_ends(python_fmu, tmp_path):
    assert _host("ending", python_fmu.path, tmp_path) == "left to Python's end"


@pytest.mark.parametrize("again", [[], ["again"]], ids=["ended", "started-anew"])
def test_an_instance_may_be_freed_after_python_has_ended(python_fmu, tmp_path, again):
    compiler, name = shutil.which("cc"), sysconfig.get_config_var("INSTSONAME")
    if compiler is None:
        pytest.skip("no C compiler on this machine")
    if not sysconfig.get_config_var("Py_ENABLE_SHARED"):
        pytest.skip("this Python has no shared library")
    host = tmp_path / "host"
    flags = ["-std=gnu11", "-Wall", "-Wextra", "-Werror", "-I", str(FMI_HEADERS)]
    subprocess.run([compiler, *flags, "-o", str(host), str(HERE / "ending_host.c"), "-ldl"], check=True)
    libpython = Path(sysconfig.get_config_var("LIBDIR")) / name
    command = [str(host), str(libpython), *host_arguments(python_fmu, 0.0, 0)[:3], *again]
    environment = {"PYTHONPATH": str(Path(np.__file__).parents[1]), "PYTHONHOME": sys.base_prefix}
    ran = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
