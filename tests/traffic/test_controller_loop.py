"""The controller FMU around ideal vehicles is the closed loop: in process and as a flat SSP in three masters."""

from __future__ import annotations

import json
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from fmu_src.pack.ecosystem import write_cross_check
from fmu_src.pack.loops import write_loop
from fmu_src.pack.ssp import SCENARIOS, parameters_of
from harness import ERROR, OK, random_start, starts
from ssp_files import bound_parameters, steps_stated, system_files, valid_files

T, N = 0.01, 7
CASES = [{"potential": 1}, {"potential": 2}, {"parameter_source": 2, "alpha_fixed": 2e-3, "r_fixed": 12.0}]
SEEN = [f"v[{i}]" for i in range(1, N + 1)] + [f"s[{i}]" for i in range(2, N + 1)] + ["x[1]", "x[7]"]


def of_the_runtime_of(controller_fmu, component: str) -> str:
    """The fixture of a component in the controller's runtime: not every pair of runtimes is tried."""
    return f"{'native' if 'Native' in controller_fmu.path.name else 'python'}_{component}_fmu"


@pytest.fixture(scope="module")
def plant_fmu(request, controller_fmu):
    return request.getfixturevalue(of_the_runtime_of(controller_fmu, "plant"))


@pytest.fixture(scope="module")
def leader_fmu(request, controller_fmu):
    return request.getfixturevalue(of_the_runtime_of(controller_fmu, "leader"))


def measurement(plant) -> dict[str, float]:
    spacings, speeds = plant.group("s"), plant.group("v")
    named = {f"s[{i}]": spacing for i, spacing in enumerate(spacings, start=2)}
    return named | {f"v[{i}]": speed for i, speed in enumerate(speeds, start=1)}


@pytest.mark.parametrize("case", CASES, ids=["V_old", "network", "fixed"])
@pytest.mark.parametrize("steps_per_period", [1, 3])
def test_around_ideal_vehicles_it_is_the_closed_loop(
    instances, platoon_fmu, plant_fmu, controller_fmu, case, steps_per_period
):
    values = starts(*random_start(21)) | {"x_start": 3.0}
    loop, plant, controller = instances(platoon_fmu), instances(plant_fmu), instances(controller_fmu)
    assert loop.initialise(values | case) == OK
    assert plant.initialise(values) == OK
    assert controller.initialise(case) == OK
    step = T / steps_per_period
    for k in range(1000):
        np.testing.assert_allclose(plant.get(*SEEN), loop.get(*SEEN), rtol=0, atol=1e-9)
        assert controller.set(measurement(plant)) == OK
        a = controller.group("a")
        np.testing.assert_allclose(a, loop.group("a"), rtol=0, atol=1e-9)
        reports = ("alpha", "r", "p", "T_max", "lemma1_ok", "lemma1_violations")
        np.testing.assert_allclose(controller.get(*reports), loop.get(*reports), rtol=0, atol=1e-9)
        assert plant.set({f"a[{i}]": a_i for i, a_i in enumerate(a, start=1)}) == OK
        for j in range(steps_per_period):
            for instance in (loop, plant, controller):
                assert instance.step(k * T + j * step, step) == OK


@pytest.mark.parametrize("steps_per_period", [1, 3])
def test_set_step_get_of_the_controller_and_then_of_the_plant_is_the_closed_loop_too(
    instances, platoon_fmu, plant_fmu, controller_fmu, steps_per_period
):
    """The order that FMI 2.0, 4.2.4, allows: no output is read between setting inputs and the next step."""
    values, step = starts(*random_start(22)), T / steps_per_period
    loop, plant, controller = instances(platoon_fmu), instances(plant_fmu), instances(controller_fmu)
    assert loop.initialise(values) == plant.initialise(values) == controller.initialise() == OK
    for k in range(300):
        time = k * step
        assert controller.set(measurement(plant)) == OK
        assert controller.step(time, step) == OK
        a = controller.group("a")
        np.testing.assert_allclose(a, loop.group("a"), rtol=0, atol=1e-9)
        assert plant.set({f"a[{i}]": a_i for i, a_i in enumerate(a, start=1)}) == OK
        assert plant.step(time, step) == OK and loop.step(time, step) == OK
        if (k + 1) % steps_per_period:
            continue  # the plant shows the motion at the beginning of the period
        np.testing.assert_allclose(plant.get(*SEEN), loop.get(*SEEN), rtol=0, atol=1e-9)


@pytest.fixture(scope="module")
def expected(platoon_fmu) -> np.ndarray:
    """The closed loop after 2 s from the start values of the FMUs."""
    from harness import Instance

    instance = Instance(platoon_fmu)
    assert instance.initialise() == OK
    assert instance.step(0.0, 2.0) == OK
    values = instance.get(*SEEN)
    instance.close()
    return np.array(values)


@pytest.fixture(scope="module")
def ssp(tmp_path_factory, plant_fmu, controller_fmu, leader_fmu):
    path = tmp_path_factory.mktemp("ssp") / "loop.ssp"
    return write_loop(path, plant_fmu.path, controller_fmu.path, N, {}, leader_fmu.path)


def test_each_system_binds_every_parameter_and_states_the_step(tmp_path, plant_fmu, controller_fmu, leader_fmu):
    fmus = {"plant": plant_fmu, "controller": controller_fmu, "leader": leader_fmu}
    given = {"T": 0.008, "v_start[3]": 29, "lemma1_policy": 2.0, "v_low": 20, "a_min[2]": -6, "potential": 1}
    paths = (tmp_path / "loop.ssp", tmp_path / "again" / "loop.ssp")
    one, other = (write_loop(path, plant_fmu.path, controller_fmu.path, N, given, leader_fmu.path) for path in paths)
    assert one.read_bytes() == other.read_bytes()
    assert valid_files(one) == {"SystemStructure.ssd", *(f"{name}.ssd" for name in SCENARIOS)}
    for name, root in system_files(one).items():
        assert steps_stated(root) == [0.002] * 4
        changed = SCENARIOS.get(name.removesuffix(".ssd"), {})
        bound = bound_parameters(root)
        assert set(bound) == set(fmus)
        for component, (values, types) in bound.items():
            own = parameters_of(fmus[component].path)
            wanted = own | {"phase": 0.004} | given | changed
            assert values == {key: wanted[key] for key in own}
            assert types == {key: "Integer" if isinstance(start, int) else "Real" for key, start in own.items()}


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"potental": 1}, "potental is no parameter of plant, controller"),
        ({"v[1]": 30.0}, "v.1. is no parameter"),
        ({"v_low": 20.0}, "v_low is no parameter"),  # there is no leader
        ({"potential": 1.5}, "potential = 1.5 must be a whole number"),
        ({"T": float("inf")}, "T = inf must be a finite number"),
    ],
)
def test_values_that_no_component_can_have_are_refused(tmp_path, plant_fmu, controller_fmu, values, sentence):
    with pytest.raises(ValueError, match=sentence):
        write_loop(tmp_path / "loop.ssp", plant_fmu.path, controller_fmu.path, N, values)
    assert not list(tmp_path.iterdir())


def test_cross_check_files_of_plant_and_leader(tmp_path, plant_fmu, leader_fmu):
    names = [path.name for fmu in (plant_fmu, leader_fmu) for path in write_cross_check(fmu.path, tmp_path)]
    plant, leader = plant_fmu.path.stem, leader_fmu.path.stem
    endings = [f"{plant}_in.csv", f"{plant}_ref.csv", f"{plant}_ref.opt", f"{leader}_ref.csv", f"{leader}_ref.opt"]
    assert names == endings  # a leader has no inputs
    header, *rows = (tmp_path / f"{plant}_in.csv").read_text().splitlines()
    inputs = [f"{name}[{i}]" for name in ("a", "automated") for i in range(1, N + 1)]
    assert header.replace('"', "").split(",") == ["time", *inputs]
    assert [float(row.split(",")[0]) for row in rows] == [0.0, 20.0]


def test_the_ssp_in_fmpy(ssp, expected):
    from fmpy.ssp import simulation

    phase = SimpleNamespace(name="controller.phase", value=0.5 * T)  # fmpy does not read inline parameters
    chosen = SimpleNamespace(parameters=[phase])
    result = simulation.simulate_ssp(str(ssp), stop_time=2.0 - T / 8, step_size=T / 4, parameter_set=chosen)
    names = [name for name in SEEN if not name.startswith("x")]
    values = [result[f"plant.{name}"][-1] for name in names]
    np.testing.assert_allclose(values, expected[: len(names)], rtol=0, atol=1e-9)


def test_the_leader_drives_its_wave_and_refuses_a_senseless_one(instances, leader_fmu):
    leader = instances(leader_fmu)
    assert leader.initialise({"v_low": 14.0}) == OK
    seen = []
    for k in range(50):
        seen.append(leader.get("v")[0])
        assert leader.step(float(k), 1.0) == OK
    expected = [30.0 if k < 10 else 22 + 8 * np.cos(2 * np.pi * (k - 10) / 40) for k in range(50)]
    np.testing.assert_allclose(seen, expected, atol=1e-12)
    assert leader.call("fmi2Reset") == OK
    assert leader.initialise({"v_low": 31.0}) == ERROR
    assert "31" in leader.messages[-1][1]


def run_script(text: str, folder) -> list[float]:
    """The numbers that a script prints after VALUES; in a process of its own, as masters load libraries for good."""
    ran = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, cwd=folder, check=False)
    assert "VALUES" in ran.stdout, ran.stdout + ran.stderr
    return json.loads(ran.stdout.split("VALUES")[1].splitlines()[0])


@pytest.mark.system("ecos", "unzip")
def test_the_ssp_in_ecos(ssp, expected, tmp_path):
    script = f"""
from ecospy import EcosSimulation, EcosSimulationStructure
import json
with EcosSimulation(ssp_path={str(ssp)!r}, step_size={T / 4}) as simulation:
    simulation.init(parameter_set="given")
    simulation.step(800)
    print("VALUES" + json.dumps([simulation.get_real("plant::" + name) for name in {SEEN!r}]))
    simulation.terminate()
"""
    np.testing.assert_allclose(run_script(script, tmp_path), expected, rtol=0, atol=1e-9)


@pytest.mark.system("libcosim")
@pytest.mark.parametrize("step", [f", step_size={round(T / 4 * 1e9)}", ""], ids=["given", "stated in the file"])
def test_the_ssp_in_libcosim(ssp, expected, plant_fmu, tmp_path, step):
    references = [plant_fmu.reference[name] for name in SEEN]
    script = f"""
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
import json
execution = CosimExecution.from_ssp_file(ssp_path={str(ssp)!r}{step})
observer = CosimObserver.create_last_value()
assert execution.add_observer(observer)
assert execution.simulate_until(target_time=2_000_000_000)
plant = execution.slave_index_from_instance_name("plant")
print("VALUES" + json.dumps(list(observer.last_real_values(plant, {references!r}))))
"""
    np.testing.assert_allclose(run_script(script, tmp_path), expected, rtol=0, atol=1e-9)
