"""The hosts that the tests' environment brings run the native FMU; all hosts: python tests/hosts/table.py."""

from __future__ import annotations

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
        pytest.param("libcosimpy_host", 1e-9, marks=pytest.mark.system("libcosim")),
        pytest.param("ecospy_host", 1e-9, marks=pytest.mark.system("ecos")),
        pytest.param("ecos_command_line_host", 1e-6, marks=pytest.mark.system("ecos")),  # its CSV has six decimals
    ],
)
def test_the_native_fmu_runs_as_the_model_says(native, driver, tolerance):
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
