"""The flat .ssp of real vehicles behind a leader who drives himself: as psp_model has it, in three masters."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from build_fmu import main as build
from fmu_src.pack.loops import write_road_loop
from fmu_src.pack.ssp import SCENARIOS, parameters_of
from harness import Unpacked
from psp_model import (
    Actuation,
    BadMeasurement,
    ControllerSettings,
    Cooperation,
    Lemma1Policy,
    Measurement,
    ParameterSource,
    PlatoonState,
    PotentialParameters,
    Request,
    RoadPlant,
    SampledController,
    Sampling,
    Wave,
)
from psp_model.vehicles.leader import held_for
from ssp_files import bound_parameters, steps_stated, system_files, valid_files

T, N, DURATION = 0.01, 4, 40.0
DELAY, LAG, LENGTHS, START = 0.2, 0.2, [5.0, 12.0, 5.0, 4.5], 28.0
SPACINGS = [14.0, 21.5, 15.0]
BRAKING = {"v_high": START, "v_low": 0.0, "begin": 1.0, "period": 30.0}  # to standstill within 15 s, and off again
REAL = {"actuation_delay": DELAY} | {
    f"{name}[{i}]": value
    for i in range(1, N + 1)
    for name, value in {"actuator_lag": LAG, "a_min": -8.0, "a_max": 4.0, "length": LENGTHS[i - 1]}.items()
}
LAW = {"kappa": 1.0, "parameter_source": 2, "alpha_fixed": 1e-3, "r_fixed": 11.0, "p_fixed": 5.5}
STARTS = {f"s_start[{i}]": s for i, s in enumerate(SPACINGS, start=2)} | {f"v_start[{i}]": START for i in (2, 3, 4)}
GIVEN = BRAKING | REAL | LAW | STARTS
SEEN = [f"clearance[{i}]" for i in range(2, N + 1)] + [f"v[{i}]" for i in range(1, N + 1)] + ["x[1]"]


def built(component: str, runtime: str, folder: Path, *more: str) -> Path:
    """An FMU for N vehicles."""
    place = folder / f"{component}_{runtime}"
    assert (
        build(["--component", component, "--vehicles", str(N), "--output", str(place), "--runtime", runtime, *more])
        == 0
    )
    return next(place.glob("*.fmu"))


@pytest.fixture(scope="module", params=["python", "native"])
def fmus(request, tmp_path_factory) -> dict[str, Path]:
    """Plant, controller and leader of one runtime."""
    folder = tmp_path_factory.mktemp("fmus")
    return {component: built(component, request.param, folder) for component in ("plant", "controller", "leader")}


@pytest.fixture(scope="module")
def ssp(fmus, tmp_path_factory) -> Path:
    return write_road_loop(tmp_path_factory.mktemp("ssp") / "road.ssp", **fmus, vehicles=N, values=GIVEN)


def expected(duration: float, told: bool = True) -> list[np.ndarray]:
    """SEEN at the beginning of each period, by psp_model: the controller samples in the middle of a period the state at
    its beginning, and the leader's acceleration at 3/4 of a period is that of the plant's first vehicle.
    """
    wave, length = Wave(*BRAKING.values()), np.array(LENGTHS)
    actuation = Actuation(DELAY, np.full(N, LAG), np.full(N, -8.0), np.full(N, 4.0))
    plant = RoadPlant.begin(PlatoonState(SPACINGS, [START] * N), T, actuation, length)
    believed = actuation if told else Actuation(0.0, 0.0, actuation.a_min, actuation.a_max)
    controller = SampledController.begin(
        ControllerSettings(
            N,
            request=Request(source=ParameterSource.FIXED, fixed=PotentialParameters(1e-3, 11.0, 5.5)),
            cooperation=Cooperation(kappa=1.0 if told else 0.0, length=length),
            actuation=believed,
            sampling=Sampling(T, Lemma1Policy.ERROR if told else Lemma1Policy.WARN),
            bad_input=BadMeasurement.ERROR if told else BadMeasurement.SAFE_ACTION,
        )
    )
    automated, seen = np.array([0.0, 1.0, 1.0, 1.0]), []

    def acceleration(time: float) -> float:
        return held_for(wave.speed(time), wave.speed(time + T), T)

    for k in range(round(duration / T)):
        now, middle = plant.now, (k + 0.5) * T
        seen.append(np.array([*plant.clearances(), *now.v, now.x]))
        a_measured = np.array([acceleration(middle), 0.0, 0.0, 0.0])
        measured = Measurement(
            now.s,
            now.v,
            N,
            v_desired=wave.speed(middle),
            automated=automated if told else np.ones(N),
            a_measured=a_measured,
        )
        controller.sample(middle, measured)
        a = np.array([acceleration((k + 0.75) * T), *controller.now.a[1:]])
        plant = plant.advanced_to(k + 1, a, automated)
    return seen


def test_nobody_touches_behind_a_leader_who_brakes_to_standstill() -> None:
    seen = np.array(expected(DURATION))
    assert seen[:, : N - 1].min() > 1.0
    assert seen[:, N - 1 : -1].min() < 0.2 and seen[-1, N - 1] > 5.0  # they stood, and drove off
    assert np.array(expected(DURATION, told=False))[:, : N - 1].min() < 0.0  # whom the controller knows as ideal ones


def all_parameters(ssp: Path) -> list[SimpleNamespace]:
    """What the archive binds: fmpy does not read it."""
    bound = bound_parameters(system_files(ssp)["SystemStructure.ssd"])
    return [
        SimpleNamespace(name=f"{component}.{name}", value=value)
        for component, (values, _) in bound.items()
        for name, value in values.items()
    ]


def test_in_fmpy_it_is_what_the_model_has(ssp):
    from fmpy.ssp import simulation

    chosen = SimpleNamespace(parameters=all_parameters(ssp))
    result = simulation.simulate_ssp(str(ssp), stop_time=20.0 - T / 8, step_size=T / 4, parameter_set=chosen)
    names = [name for name in SEEN if not name.startswith("x")]
    rows = np.column_stack([result[f"plant.{name}"] for name in names])
    wanted = np.array(expected(20.0))[:, : len(names)]
    np.testing.assert_allclose(rows[3::4][: len(wanted) - 1], wanted[1:], rtol=0, atol=1e-9)
    assert rows[:, : N - 1].min() > 1.0


def run_script(text: str, folder) -> list[float]:
    """The numbers that a script prints after VALUES; in a process of its own, as masters load libraries for good."""
    ran = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, cwd=folder, check=False)
    assert "VALUES" in ran.stdout, ran.stdout + ran.stderr
    return json.loads(ran.stdout.split("VALUES")[1].splitlines()[0])


@pytest.mark.system("ecos", "unzip")
def test_in_ecos_it_is_what_the_model_has(ssp, tmp_path):
    script = f"""
from ecospy import EcosSimulation, EcosSimulationStructure
import json
with EcosSimulation(ssp_path={str(ssp)!r}, step_size={T / 4}) as simulation:
    simulation.init(parameter_set="given")
    simulation.step({round(16.0 / T * 4)})
    print("VALUES" + json.dumps([simulation.get_real("plant::" + name) for name in {SEEN!r}]))
    simulation.terminate()
"""
    np.testing.assert_allclose(run_script(script, tmp_path), expected(16.0 + T)[-1], rtol=0, atol=1e-9)


@pytest.mark.system("libcosim")
def test_in_libcosim_it_is_what_the_model_has(ssp, fmus, tmp_path):
    references = [Unpacked(fmus["plant"], tmp_path / "plant").reference[name] for name in SEEN]
    script = f"""
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
import json
execution = CosimExecution.from_ssp_file(ssp_path={str(ssp)!r})
observer = CosimObserver.create_last_value()
assert execution.add_observer(observer)
assert execution.simulate_until(target_time=16_000_000_000)
plant = execution.slave_index_from_instance_name("plant")
print("VALUES" + json.dumps(list(observer.last_real_values(plant, {references!r}))))
"""
    np.testing.assert_allclose(run_script(script, tmp_path), expected(16.0 + T)[-1], rtol=0, atol=1e-9)


def test_everything_is_bound_and_the_plant_s_vehicles_are_the_controller_s(ssp, fmus):
    assert valid_files(ssp) == {"SystemStructure.ssd", *(f"{name}.ssd" for name in SCENARIOS)}
    for name, root in system_files(ssp).items():
        assert steps_stated(root) == [T / 4] * 4
        changed, bound = SCENARIOS.get(name.removesuffix(".ssd"), {}), bound_parameters(root)
        for component, (values, _) in bound.items():
            own = parameters_of(fmus[component])
            wanted = own | {"phase": T / 2, "v_start[1]": START} | GIVEN | changed
            assert values == {key: wanted[key] for key in own}
        of_plant, of_controller = bound["plant"][0], bound["controller"][0]
        assert REAL.items() <= of_plant.items() and REAL.items() <= of_controller.items()


def test_the_first_vehicle_begins_at_the_leader_s_speed(tmp_path, fmus):
    (tmp_path / "profile.csv").write_text("0,17.5\n5,20\n10,20\n")
    runtime = "native" if "Native" in fmus["plant"].name else "python"
    leader = built("leader", runtime, tmp_path, "--profile", str(tmp_path / "profile.csv"))
    for more, speed in (({}, 17.5), ({"begin": -2.0}, 18.5), ({"v_start[1]": 12}, 12.0)):
        path = write_road_loop(tmp_path / "road.ssp", fmus["plant"], fmus["controller"], leader, N, STARTS | more)
        for root in system_files(path).values():
            bound = bound_parameters(root)
            values, types = bound["plant"]
            assert values["v_start[1]"] == speed and types["v_start[1]"] == "Real"
            assert bound["controller"][0]["length[2]"] == bound["plant"][0]["length[2]"] == 5.0


def test_values_that_no_component_can_have_are_refused(tmp_path, fmus):
    with pytest.raises(ValueError, match=r"aktuation_delay is no parameter of plant, controller, leader"):
        write_road_loop(tmp_path / "road.ssp", **fmus, vehicles=N, values={"aktuation_delay": 0.2})
    with pytest.raises(ValueError, match="v_low = 40 m/s must not exceed"):
        write_road_loop(tmp_path / "road.ssp", **fmus, vehicles=N, values={"v_low": 40.0})
    assert not list(tmp_path.iterdir())
