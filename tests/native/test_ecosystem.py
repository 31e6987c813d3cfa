"""SSP, parameter sets, cross-check files and FMI-LS-REF around the FMUs."""

from __future__ import annotations

import csv
import os
import shutil
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp

from fmu_src.ecosystem import LS_REF, SCENARIOS, main
from harness import OK, Instance

NAMES = ["x[7]", "v[1]", "s[2]", "T_max", "J"]


@pytest.fixture(scope="module")
def folder(native_fmu, tmp_path_factory) -> Path:
    """Everything around the native FMU."""
    written = tmp_path_factory.mktemp("ecosystem")
    main(native_fmu.path, written)
    return written


def _after_two_seconds(fmu, scenario: str) -> list[float]:
    instance = Instance(fmu)
    assert instance.initialise(SCENARIOS[scenario]) == OK
    assert instance.step(0.0, 2.0) == OK
    values = instance.get(*NAMES)
    instance.close()
    return values


@pytest.mark.system("ecos", "unzip")
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_ecos_runs_the_ssp_with_each_parameter_set(folder, native_fmu, scenario, tmp_path):
    import ecospy

    binaries = Path(ecospy.__file__).parent / "binaries"
    program = shutil.copy(binaries / "ecos", tmp_path)
    os.chmod(program, 0o755)
    command = [program, "simulate", "--path", str(folder / "Platoon.ssp"), "--stopTime", "2.05", "--stepSize", "0.01"]
    for tool in ("unzip", "chmod"):  # ecos calls these; there is no Python on its PATH
        (tmp_path / tool).symlink_to(str(shutil.which(tool)))
    environment = {"PATH": str(tmp_path), "LD_LIBRARY_PATH": str(binaries)}
    subprocess.run([*command, "--parameterSet", scenario], check=True, cwd=tmp_path, env=environment)
    (table,) = tmp_path.rglob("*.csv")
    with table.open() as file:
        rows = csv.DictReader(file, skipinitialspace=True)
        last = min(rows, key=lambda row: abs(float(row["time"]) - 2.0))
    seen = [float(next(last[key] for key in last if f"::{name}[" in key)) for name in NAMES]
    assert seen == pytest.approx(_after_two_seconds(native_fmu, scenario), rel=0, abs=1e-6)  # six decimals


@pytest.mark.system("libcosim")
def test_libcosim_loads_the_ssp(folder):
    from libcosimpy.CosimExecution import CosimExecution

    execution = CosimExecution.from_ssp_file(ssp_path=str(folder / "Platoon.ssp"), step_size=10_000_000)
    assert execution.simulate_until(target_time=1_000_000_000)


def test_fmpy_runs_the_ssp(folder, native_fmu):
    result = simulate_ssp(str(folder / "Platoon.ssp"), stop_time=2.01, step_size=0.01)
    row = result[np.argmin(abs(result["time"] - 1.99))]  # fmpy writes the time at which a step began
    seen = [row[f"platoon.{name}"] for name in NAMES]
    assert seen == pytest.approx(_after_two_seconds(native_fmu, "scenario2"), rel=0, abs=1e-9)


def test_cross_check_files_are_complete(folder):
    with (folder / "PspPlatoonNative_ref.csv").open() as file:
        header, *rows = csv.reader(file)
    assert header[0] == "time" and len(header) <= 11 and len(rows) == 201
    options = dict(line.split(",") for line in (folder / "PspPlatoonNative_ref.opt").read_text().splitlines())
    assert set(options) == {"StartTime", "StopTime", "StepSize", "RelTol"}
    assert (folder / "PspPlatoonNative_in.csv").read_text().startswith('"time"')


def test_the_fmu_carries_its_scenarios_and_reproduces_their_results(either_fmu):
    base = either_fmu.folder / LS_REF
    manifest = ElementTree.parse(base / "fmi-ls-manifest.xml").getroot()
    assert manifest.get("{http://fmi-standard.org/fmi-ls-manifest}fmi-ls-name") == "org.fmi-standard.fmi-ls-ref"
    assert all((base / related.get("source")).exists() for related in manifest)
    for experiment in ElementTree.parse(base / "experiments.xml").getroot():
        instance = Instance(either_fmu)
        assert instance.initialise(SCENARIOS[experiment.get("name")]) == OK
        with (base / experiment.find("References").get("source")).open() as file:
            for k, row in enumerate(csv.DictReader(file)):
                assert k == 0 or instance.step((k - 1) * 0.1, 0.1) == OK
                values = [float(value) for name, value in row.items() if name != "time"]
                assert instance.get(*list(row)[1:]) == pytest.approx(values, rel=1e-9, abs=1e-9)
        instance.close()
