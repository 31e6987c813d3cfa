"""What tests need from the system: installed where it may be, else a skip that names the package, in CI a failure."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

import system_packages
from system_packages import NEEDS, STRICT, Need, main, require

ROOT = Path(__file__).parents[2]
NAME = "psp-nowhere"
INSTALLS = f'case "$*" in *install*) touch "$(dirname "$0")/{NAME}"; chmod +x "$(dirname "$0")/{NAME}";; esac'


@pytest.fixture
def system(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of programs, first on PATH, on a system whose only need, a program in there, is not met."""
    need = Need("a program", ("its-package",), lambda: (tmp_path / NAME).exists())
    monkeypatch.setattr(system_packages, "NEEDS", {"program": need})
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.delenv(STRICT, raising=False)
    system_packages.found.cache_clear()
    yield tmp_path
    system_packages.found.cache_clear()


def apt_get(folder: Path, script: str) -> None:
    (folder / "apt-get").write_text(f"#!/bin/sh\n{script}\n")
    (folder / "apt-get").chmod(0o755)


def outcome(*names: str) -> tuple[str, str]:
    """What `require` does with the test that calls it, and why."""
    try:
        require(*names)
    except (pytest.skip.Exception, pytest.fail.Exception) as ended:
        return ("skipped" if isinstance(ended, pytest.skip.Exception) else "failed"), str(ended)
    return "runs", ""


def test_what_is_missing_is_installed(system, capsys):
    apt_get(system, INSTALLS)
    assert outcome("program")[0] == "skipped"
    assert main() == 0 and outcome("program")[0] == "runs"
    assert capsys.readouterr().out == "Installing what the tests need from the system: its-package\n"
    assert main() == 0 and capsys.readouterr().out == ""


@pytest.mark.parametrize("script", ["echo no such package >&2; exit 100", "exit 0"], ids=["fails", "installs nothing"])
@pytest.mark.parametrize(("strict", "code", "test"), [("", 0, "skipped"), ("1", 1, "failed")], ids=["test", "CI"])
def test_an_installation_that_fails_is_said_and_fails_in_ci(system, capsys, monkeypatch, script, strict, code, test):
    apt_get(system, script)
    monkeypatch.setenv(STRICT, strict)
    assert main() == code
    said = capsys.readouterr().err
    assert "for want of a program" in said and ("no such package" in said) == ("100" in script)
    assert outcome("program") == (test, "needs a program: install Debian's its-package")


@pytest.mark.parametrize("user", [1000, 0], ids=["no root", "no apt-get"])
def test_where_nothing_may_be_installed_tests_are_skipped_in_ci_too(system, capsys, monkeypatch, user):
    monkeypatch.setattr(os, "geteuid", lambda: user)
    monkeypatch.setenv(STRICT, "1")
    if user == 0:
        monkeypatch.setenv("PATH", str(system))
    assert main() == 0 and "its-package" in capsys.readouterr().out
    assert outcome("program") == ("skipped", "needs a program: install Debian's its-package")


def test_what_no_package_brings_is_skipped_in_ci_too(system, monkeypatch):
    apt_get(system, "exit 0")
    monkeypatch.setenv(STRICT, "1")
    monkeypatch.setitem(system_packages.NEEDS, "program", Need("a program", (), lambda: False))
    assert outcome("program") == ("skipped", "needs a program: no package of Debian brings it")
    assert main() == 0


def test_ci_is_the_test_command_and_skips_nothing():
    lines = (ROOT / ".ci/run").read_text(encoding="utf-8").splitlines()
    assert lines[-2:] == [f"export {STRICT}=1", "make test"] and "set -euo pipefail" in lines
    assert "test: system " in (ROOT / "Makefile").read_text(encoding="utf-8")


def test_no_test_decides_by_itself_that_a_program_is_missing():
    """Such a skip would be passed over in CI, and its package would not be installed."""
    for path in [*(ROOT / "tests").rglob("test_*.py"), *(ROOT / "tests").rglob("conftest.py")]:
        text = path.read_text(encoding="utf-8")
        if path.parent != Path(__file__).parent:
            assert not re.search(r"find_library\(|skipif|which\([^\n]*\) is None", text), f"{path}: use mark.system"
        for names in re.findall(r"mark\.system\(([^)]*)\)", text):
            assert set(re.findall(r'"([\w-]+)"', names)) <= set(NEEDS), path
