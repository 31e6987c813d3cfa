"""The hosts that the tests' environment brings run the native FMU; all hosts: python tests/hosts/table.py."""

from __future__ import annotations

import ctypes.util
import sys
from pathlib import Path

import pytest

from build_fmu import main as build
from hosts import table
from hosts.table import difference, reference


@pytest.fixture(scope="module")
def native(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("native")
    assert build(["--runtime", "native", "--output", str(folder)]) == 0
    return folder / "PspPlatoonNative.fmu"


@pytest.mark.parametrize(
    ("driver", "tolerance"),
    [
        ("fmpy_host", 1e-9),
        ("libcosimpy_host", 1e-9),
        ("ecospy_host", 1e-9),
        ("ecos_command_line_host", 1e-6),  # its CSV has six decimals
    ],
)
def test_the_native_fmu_runs_as_the_model_says(native, driver, tolerance):
    if driver.startswith("eco") and ctypes.util.find_library("tbb") is None:
        pytest.skip("ecos needs libtbb12")
    _, worst = difference(Path(sys.executable), driver, native, reference())
    assert float(worst) <= tolerance


def test_a_host_that_cannot_be_installed_has_a_row_that_says_so(monkeypatch, tmp_path):
    def nothing(packages, folder):
        raise OSError(f"{packages[0]} cannot be installed")

    monkeypatch.setattr(table, "environment", nothing)
    assert table.row("omsimulator_host", ["OMSimulator"], tmp_path, tmp_path, {}) == (
        "",
        "OMSimulator cannot be installed",
        "",
    )
