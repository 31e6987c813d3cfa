"""SSP, parameter sets, cross-check files and FMI-LS-REF around the FMUs."""

from __future__ import annotations

import csv
import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from fmpy import read_model_description
from fmpy.ssp.simulation import simulate_ssp

from fmu_src.interface.controller import controller_table
from fmu_src.interface.leader import leader_table
from fmu_src.interface.model_description import Component, model_description
from fmu_src.interface.plant import plant_table
from fmu_src.interface.platoon import platoon_table
from fmu_src.pack.ecosystem import LS_REF, main, write_cross_check, write_platoon_ssp
from fmu_src.pack.ssp import SCENARIOS, with_values
from harness import OK, Instance
from ssp_files import bound_parameters, steps_stated, system_files, valid_files

NAMES = ["x[7]", "v[1]", "s[2]", "T_max", "J"]
TABLES = {
    "platoon": platoon_table(3),
    "controller": controller_table(3),
    "plant": plant_table(3),
    "leader": leader_table(),
    "profile": leader_table(True),
}


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


def _as_default(ssp: Path, scenario: str, folder: Path) -> Path:
    """The archive unpacked, for masters that read SystemStructure.ssd only, with a scenario in its place."""
    with zipfile.ZipFile(ssp) as archive:
        archive.extractall(folder)
    shutil.copy(folder / f"{scenario}.ssd", folder / "SystemStructure.ssd")
    return folder


def test_the_files_of_the_ssp_are_valid_and_there_is_one_for_each_scenario(either_fmu, tmp_path):
    ssp = write_platoon_ssp(either_fmu.path, tmp_path / "Platoon.ssp")
    assert valid_files(ssp) == {
        *(f"{name}.ssd" for name in ("SystemStructure", *SCENARIOS)),
        *(f"resources/{name}.ssv" for name in SCENARIOS),
    }
    assert ssp.read_bytes() == write_platoon_ssp(either_fmu.path, tmp_path / "again" / "Platoon.ssp").read_bytes()


def test_each_system_binds_every_parameter_once_to_its_scenario(folder, native_fmu):
    model = read_model_description(str(native_fmu.path), validate=False)
    kinds = {row.name: row.type for row in model.modelVariables if row.causality == "parameter"}
    for name, root in system_files(folder / "Platoon.ssp").items():
        values, types = bound_parameters(root)["platoon"]
        assert types == kinds
        assert values == scenario_start(native_fmu, "scenario1" if name == "scenario1.ssd" else "scenario2")
        connectors = {each.get("name"): each.get("kind") for each in root.iter() if each.tag.endswith("}Connector")}
        assert {name for name, kind in connectors.items() if kind == "parameter"} == set(kinds)


def scenario_start(fmu, scenario: str) -> dict[str, float]:
    model = read_model_description(str(fmu.path), validate=False)
    starts = {row.name: float(row.start) for row in model.modelVariables if row.causality == "parameter"}
    return starts | {"potential": {"scenario1": 1.0, "scenario2": 2.0}[scenario], "lemma1_policy": 1.0}


def test_each_system_states_the_step_for_each_master(folder):
    for root in system_files(folder / "Platoon.ssp").values():
        assert steps_stated(root) == [0.01] * 4  # OMSimulator twice, OpenMCx, libcosim


@pytest.mark.parametrize("value", [1.5, float("nan"), float("inf")])
def test_an_integer_parameter_takes_whole_numbers_only(value):
    assert with_values({"potential": 2, "T": 0.01}, {"potential": 1.0, "T": 1, "z": 3}) == {"potential": 1, "T": 1.0}
    assert isinstance(with_values({"potential": 2}, {"potential": 1.0})["potential"], int)
    with pytest.raises(ValueError, match=r"potential = .* must be a whole number"):
        with_values({"potential": 2}, {"potential": value})
    with pytest.raises(ValueError, match=r"T = nan must be a finite number"):
        with_values({"T": 0.01}, {"T": float("nan")})


@pytest.mark.system("ecos", "unzip")
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_ecos_runs_the_ssp_with_each_scenario(folder, native_fmu, scenario, tmp_path):
    import ecospy

    binaries = Path(ecospy.__file__).parent / "binaries"
    program = shutil.copy(binaries / "ecos", tmp_path)
    os.chmod(program, 0o755)
    ssp = folder / "Platoon.ssp"
    system = ssp if scenario == "scenario2" else _as_default(ssp, scenario, tmp_path / "unpacked")
    command = [program, "simulate", "--path", str(system), "--stopTime", "2.05", "--stepSize", "0.01"]
    for tool in ("unzip", "chmod"):  # ecos calls these; there is no Python on its PATH
        (tmp_path / tool).symlink_to(str(shutil.which(tool)))
    environment = {"PATH": str(tmp_path), "LD_LIBRARY_PATH": str(binaries)}
    subprocess.run([*command, "--parameterSet", scenario], check=True, cwd=tmp_path, env=environment)
    (table,) = tmp_path.glob("*.csv")
    with table.open() as file:
        rows = csv.DictReader(file, skipinitialspace=True)
        last = min(rows, key=lambda row: abs(float(row["time"]) - 2.0))
    seen = [float(next(last[key] for key in last if f"::{name}[" in key)) for name in NAMES]
    assert seen == pytest.approx(_after_two_seconds(native_fmu, scenario), rel=0, abs=1e-6)  # six decimals


@pytest.mark.system("libcosim")
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_libcosim_runs_each_scenario_with_the_step_that_is_stated(folder, native_fmu, scenario, tmp_path):
    system = _as_default(folder / "Platoon.ssp", scenario, tmp_path) / f"{scenario}.ssd"
    script = f"""
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
import json
execution = CosimExecution.from_ssp_file(ssp_path={str(system)!r})
observer = CosimObserver.create_last_value()
assert execution.add_observer(observer)
assert all(execution.step() for _ in range(200))
slave = execution.slave_index_from_instance_name("platoon")
references = {[native_fmu.reference[name] for name in NAMES]!r}
print("VALUES" + json.dumps(list(observer.last_real_values(slave, references))))
"""
    ran = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert "VALUES" in ran.stdout, ran.stdout + ran.stderr
    seen = json.loads(ran.stdout.split("VALUES")[1].splitlines()[0])
    assert seen == pytest.approx(_after_two_seconds(native_fmu, scenario), rel=0, abs=1e-9)


def test_fmpy_runs_the_ssp(folder, native_fmu):
    result = simulate_ssp(str(folder / "Platoon.ssp"), stop_time=2.01, step_size=0.01)
    row = result[np.argmin(abs(result["time"] - 1.99))]  # fmpy writes the time at which a step began
    seen = [row[f"platoon.{name}"] for name in NAMES]
    assert seen == pytest.approx(_after_two_seconds(native_fmu, "scenario2"), rel=0, abs=1e-9)


@pytest.mark.parametrize("name", ["native", "python", "native_controller"])
def test_cross_check_files_are_complete_and_name_all_inputs(request, name, tmp_path):
    fmu = request.getfixturevalue(f"{name}_fmu")
    files = {path.name.removeprefix(f"{fmu.path.stem}_"): path for path in write_cross_check(fmu.path, tmp_path)}
    assert set(files) == {"in.csv", "ref.csv", "ref.opt"}
    with files["ref.csv"].open() as file:
        header, *rows = csv.reader(file)
    assert header[0] == "time" and 4 <= len(header) <= 11 and len(rows) == 201
    options = dict(line.split(",") for line in files["ref.opt"].read_text().splitlines())
    assert set(options) == {"StartTime", "StopTime", "StepSize", "RelTol"}
    model = read_model_description(str(fmu.path), validate=False)
    starts = {row.name: float(row.start) for row in model.modelVariables if row.causality == "input"}
    with files["in.csv"].open() as file:
        given = list(csv.DictReader(file))
    assert [float(row["time"]) for row in given] == [0.0, 20.0]
    for row in given:
        assert {name: float(value) for name, value in row.items() if name != "time"} == starts


@pytest.mark.parametrize("name", TABLES)
def test_every_description_states_a_tolerance_and_an_exponent_for_each_unit(name):
    root = ElementTree.fromstring(model_description(Component("Psp", "A model.", "1.0", "{1}"), TABLES[name]))
    assert 0 < float(root.find("DefaultExperiment").get("tolerance")) < 1
    units = {unit.get("name"): unit.find("BaseUnit").attrib for unit in root.findall("UnitDefinitions/Unit")}
    assert all(units.values())
    assert units.get("1", {"m": "0"}) == {"m": "0"}
    assert set(units) >= {row.unit for row in TABLES[name] if not row.integer}


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
