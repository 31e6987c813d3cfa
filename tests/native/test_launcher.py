"""The C library through which hosts drive the Python FMU."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from fmu_src.python.launcher.build import PLATFORMS, launcher, path_of
from harness import DISCARD, ERROR, FATAL, OK, WARNING, Instance, Unpacked
from native.hosting import host_arguments

MODEL_DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Tiny" guid="{tiny}">
<CoSimulation modelIdentifier="Tiny"/>
<ModelVariables>
<ScalarVariable name="y" valueReference="0" causality="output"><Real/></ScalarVariable>
<ScalarVariable name="mode" valueReference="1" causality="parameter" variability="tunable">
<Real start="0"/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="1"/></Outputs></ModelStructure>
</fmiModelDescription>
"""


@pytest.fixture(scope="module")
def tiny(tmp_path_factory) -> Unpacked:
    """An FMU of the smallest slave, in a folder whose name would trip pythonfmu."""
    import pythonfmu

    folder = tmp_path_factory.mktemp("ümlaut # [1] + ")
    libraries = Path(pythonfmu.__file__).parent / "resources" / "binaries" / "linux64"
    shutil.copytree(libraries, folder / "resources" / "binaries" / "linux64")
    shutil.copy(Path(__file__).parent / "tiny_slave.py", folder / "resources")
    (folder / "resources" / "slavemodule.txt").write_text("tiny_slave")
    (folder / "resources" / "guid.txt").write_text("{tiny}")
    (folder / "binaries" / "linux64").mkdir(parents=True)
    shutil.copy(path_of("linux64"), folder / "binaries" / "linux64" / "Tiny.so")
    (folder / "modelDescription.xml").write_text(MODEL_DESCRIPTION)
    archive = shutil.make_archive(str(tmp_path_factory.mktemp("zip") / "tiny"), "zip", folder)
    return Unpacked(Path(archive), folder)


@pytest.fixture
def stepping(tiny):
    """A running instance of the smallest slave."""
    instance = Instance(tiny)
    assert instance.initialise() == OK
    yield instance
    instance.close()


@pytest.mark.parametrize("platform", PLATFORMS)
def test_the_binaries_are_what_the_sources_compile_to(platform):
    assert launcher(platform) == path_of(platform).read_bytes()


def test_what_the_slave_logs_is_text_and_its_status_that_of_the_call(stepping):
    assert stepping.set({"mode": 1}) == OK
    assert stepping.step(0.0, 1.0) == ERROR
    assert stepping.messages == [(ERROR, "100 % wrong: %s %n")]
    assert stepping.call("fmi2Reset") == OK and stepping.initialise() == OK
    assert stepping.step(0.0, 1.0) == OK and stepping.get("y") == [1.0]


def test_a_warning_does_not_end_the_run(stepping):
    assert stepping.set({"mode": 3}) == OK
    assert stepping.step(0.0, 1.0) == OK
    assert stepping.step(1.0, 1.0) == OK
    assert stepping.messages == [(WARNING, "careful")] * 2


def test_a_failed_step_without_a_reason_is_an_error(stepping):
    assert stepping.set({"mode": 4}) == OK
    assert stepping.step(0.0, 1.0) == ERROR != DISCARD


def test_after_an_exception_nothing_is_forwarded_any_more(tiny):
    instance = Instance(tiny)
    assert instance.initialise({"mode": 2}) == OK
    assert instance.step(0.0, 1.0) == FATAL
    assert "a bug" in instance.messages[0][1]
    assert instance.step(1.0, 1.0) == FATAL
    assert instance.call("fmi2Reset") == FATAL
    instance.close()


def _run(c_host, fmu, environment, *names):
    command = [str(c_host), *host_arguments(fmu, 0.01, 50, *names)]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)


@pytest.mark.system("libpython", "cc")
def test_a_c_host_finds_python_by_itself(c_host, python_fmu):
    environment = {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    ran = _run(c_host, python_fmu, environment, "s[4]", "J")
    assert ran.returncode == 0, ran.stderr
    instance = Instance(python_fmu)
    assert instance.initialise() == OK
    assert all(instance.step(k * 0.01, 0.01) == OK for k in range(50))
    assert [float(word) for word in ran.stdout.split()[-2:]] == instance.get("s[4]", "J")
    instance.close()


def test_without_python_one_sentence_names_the_remedy(c_host, python_fmu):
    ran = _run(c_host, python_fmu, {"PATH": "/nowhere"})
    assert ran.returncode == 2
    (sentence,) = ran.stderr.splitlines()
    assert "PATH" in sentence and "PSP_LIBPYTHON" in sentence and "native FMU" in sentence


def test_a_broken_libpython_is_named(c_host, python_fmu):
    ran = _run(c_host, python_fmu, {"PATH": "/nowhere", "PSP_LIBPYTHON": "/nowhere/libpython.so"})
    assert ran.returncode == 2 and "/nowhere/libpython.so" in ran.stderr


def test_a_native_fmu_runs_in_a_c_host_without_python(c_host, each_native_fmu):
    names = [v.name for v in each_native_fmu.description.modelVariables if v.causality == "output"][:12]
    ran = _run(c_host, each_native_fmu, {"PATH": "/nowhere"}, *names)
    assert ran.returncode == 0 and ran.stderr == ""
    instance = Instance(each_native_fmu)
    assert instance.initialise() == OK
    assert all(instance.step(k * 0.01, 0.01) == OK for k in range(50))
    assert [float(word) for word in ran.stdout.split()[-len(names) :]] == instance.get(*names)
    instance.close()
