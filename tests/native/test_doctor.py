"""`psp doctor`: what it finds on machines that lack something."""

from __future__ import annotations

import os
import sys
import zipfile
from pathlib import Path

import pytest

from fmu_src import doctor


def _bad(fmu: Path) -> list[doctor.Finding]:
    return [finding for finding in doctor.examine(fmu) if not finding.good]


@pytest.fixture(autouse=True)
def own_python_first(monkeypatch):
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.delenv("PSP_LIBPYTHON", raising=False)


def test_nothing_to_mend_for_the_native_fmu_here(native_fmu):
    assert _bad(native_fmu.path) == []


def test_the_python_fmu_needs_python(python_fmu, monkeypatch):
    monkeypatch.setenv("PATH", "/nowhere")
    (finding,) = _bad(python_fmu.path)
    assert "no Python on PATH" in finding.text and "native FMU" in finding.remedy


def test_a_missing_package_is_named_with_the_command_that_installs_it(python_fmu, tmp_path):
    changed = tmp_path / "changed.fmu"
    with zipfile.ZipFile(python_fmu.path) as old, zipfile.ZipFile(changed, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            new.writestr(name, b"a_package_that_is_not_there>=1.0\n" if name.endswith("requirements.txt") else content)
    missing = [finding for finding in _bad(changed) if "a_package_that_is_not_there" in finding.text]
    assert missing and "pip install 'a_package_that_is_not_there>=1.0'" in missing[0].remedy


def test_a_wrong_libpython_is_named(python_fmu, monkeypatch):
    monkeypatch.setenv("PSP_LIBPYTHON", "/nowhere/libpython.so")
    assert any("/nowhere/libpython.so" in finding.text for finding in _bad(python_fmu.path))


def test_awkward_characters_in_the_temporary_path_are_named(native_fmu, monkeypatch):
    monkeypatch.setattr(doctor.tempfile, "gettempdir", lambda: "/tmp/größe #1")
    (finding,) = _bad(native_fmu.path)
    assert "'ö'" in finding.text and "'#'" in finding.text and "TMPDIR" in finding.remedy


def test_another_platform_can_compile_the_sources(native_fmu, monkeypatch):
    monkeypatch.setattr(doctor, "machine", lambda: "riscv64")
    (finding,) = _bad(native_fmu.path)
    assert "none for linux64 on riscv64" in finding.text and "fmpy compile" in finding.remedy


def test_what_is_no_fmu_is_said_to_be_none(tmp_path):
    (tmp_path / "x.fmu").write_text("no")
    (finding,) = _bad(tmp_path / "x.fmu")
    assert "not a readable FMU" in finding.text


def test_doctor_imports_nothing_that_an_archive_names(tmp_path, monkeypatch, python_fmu):
    """Neither a package that requirements.txt lists, nor a module that lies in the folder doctor is run in."""
    fmu, trace = tmp_path / "hostile.fmu", tmp_path / "trace"
    with zipfile.ZipFile(python_fmu.path) as source, zipfile.ZipFile(fmu, "w") as target:
        for name in source.namelist():
            content = b"numpy\nevil\n" if name.endswith("requirements.txt") else source.read(name)
            target.writestr(name, content)
    for module in ("evil", "json", "numpy"):
        (tmp_path / f"{module}.py").write_text(f"open({str(trace)!r}, 'w')")
    monkeypatch.chdir(tmp_path)
    assert any("numpy" in finding.text for finding in doctor.examine(fmu))
    assert not trace.exists()


@pytest.mark.parametrize("content", [b"", b"PK", b"<x/>", bytes(100)], ids=["empty", "zip", "xml", "zeros"])
def test_doctor_names_what_is_no_fmu(tmp_path, content):
    (tmp_path / "no.fmu").write_bytes(content)
    (finding,) = doctor.examine(tmp_path / "no.fmu")
    assert not finding.good and "is not a readable FMU" in finding.text
