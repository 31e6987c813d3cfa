"""The FMU in three hosts: fmpy from the shell, libcosim (C++, through libcosimpy), ecos (C++, through ecospy)."""

from __future__ import annotations

import csv
import subprocess
import sys

import numpy as np
import pytest
from fmpy import simulate_fmu

from harness import OK

NAMES = ["x[1]", "x[7]", "v[3]", "a[5]", "s[4]", "T_max", "J"]


@pytest.fixture(scope="module")
def expected(fmu) -> np.ndarray:
    """The outputs after 2 s in steps of 0.01 s."""
    from harness import Instance

    instance = Instance(fmu)
    assert instance.initialise({"potential": 1}) == OK
    for k in range(200):
        assert instance.step(k * 0.01, 0.01) == OK
    values = instance.get(*NAMES)
    instance.close()
    return np.array(values)


def test_fmpy_from_python(fmu, expected):
    result = simulate_fmu(str(fmu.path), stop_time=2.0, step_size=0.01, start_values={"potential": 1}, output=NAMES)
    np.testing.assert_allclose([result[name][-1] for name in NAMES], expected, rtol=0, atol=1e-9)


def test_fmpy_from_the_shell(fmu, expected, tmp_path):
    out = tmp_path / "out.csv"
    command = [sys.executable, "-m", "fmpy", "simulate", str(fmu.path), "--stop-time", "2", "--output-interval", "0.01"]
    command += ["--start-values", "potential", "1", "--output-file", str(out), "--output-variables", *NAMES]
    subprocess.run(command, check=True, capture_output=True, text=True)
    with out.open() as file:
        last = list(csv.DictReader(file))[-1]
    np.testing.assert_allclose([float(last[name]) for name in NAMES], expected, rtol=0, atol=1e-9)


@pytest.mark.system("libcosim")
def test_libcosim(fmu, expected):
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    execution = CosimExecution.from_step_size(step_size=10_000_000)  # [ns]
    slave = execution.add_local_slave(CosimLocalSlave(fmu_path=str(fmu.path), instance_name="platoon"))
    observer = CosimObserver.create_last_value()
    assert execution.add_observer(observer)
    assert execution.integer_initial_value(slave, fmu.reference["potential"], 1)
    assert execution.simulate_until(target_time=2_000_000_000)
    values = observer.last_real_values(slave, [fmu.reference[name] for name in NAMES])
    np.testing.assert_allclose(values, expected, rtol=0, atol=1e-9)


@pytest.mark.system("ecos")
def test_ecos(fmu, expected, tmp_path):
    script = f"""
from ecospy import EcosSimulation, EcosSimulationStructure
structure = EcosSimulationStructure()
structure.add_model("platoon", {str(fmu.path)!r})
structure.add_parameter_set("old", {{"platoon::potential": 1}})
with EcosSimulation(structure=structure, step_size=0.01) as simulation:
    simulation.init(parameter_set="old")
    simulation.step(200)
    print("VALUES", *(repr(simulation.get_real("platoon::" + name)) for name in {NAMES!r}))
    simulation.terminate()
"""
    ran = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, cwd=tmp_path, check=False)
    assert "VALUES" in ran.stdout, ran.stdout + ran.stderr
    values = [float(word) for word in ran.stdout.split("VALUES")[1].split()]
    np.testing.assert_allclose(values, expected, rtol=0, atol=1e-9)
