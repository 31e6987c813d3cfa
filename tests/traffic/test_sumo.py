"""Short runs in SUMO: repeatable, safe where the paper's assumptions hold, and honest where they do not."""

from __future__ import annotations

from dataclasses import replace
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import pytest

from psp_model import PlatoonState, PotentialParameters, simulate
from psp_traffic.driver import Driver, controllers, sumo_drivers
from psp_traffic.measures import gaps, measure
from psp_traffic.scenario import Scenario, highway, ramp, stop_and_go, wave_speed
from psp_traffic.simulation import Disturbance, Record
from psp_traffic.simulation import simulate as drive

pytest.importorskip("libsumo")


@pytest.fixture(scope="module")
def fmu(controller_fmu):
    return controller_fmu.path


def v_new(fmu) -> Driver:
    return controllers(fmu)[0]


def test_a_run_is_repeatable(fmu):
    scenario = highway(duration=3.0)
    for driver in (v_new(fmu), sumo_drivers()[2]):
        one, other = drive(scenario, driver), drive(scenario, driver)
        for name in ("x", "v", "on_road", "co2", "fuel"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_sumos_vehicles_do_what_the_model_does_up_to_sumos_euler_step(fmu):
    scenario = highway(duration=15.0)
    record = drive(scenario, v_new(fmu))
    shape = PotentialParameters(*(record.reports[name] for name in ("alpha", "r", "p")))
    run = simulate(PlatoonState(scenario.s, scenario.v), shape, duration=14.99)
    euler = np.abs(-np.diff(record.x) - run.s).max()
    assert record.reports["saturated"] == 0 and record.reports["lemma1_violations"] == 0
    assert 1e-4 < euler < 0.05
    ballistic = drive(scenario, v_new(fmu), disturbance=Disturbance(ballistic=True))
    np.testing.assert_allclose(-np.diff(ballistic.x), run.s, rtol=0, atol=1e-9)


def test_vehicles_from_the_ramp_join_the_platoon_and_nobody_collides(fmu):
    scenario = ramp(duration=25.0)
    record = drive(scenario, v_new(fmu))
    assert record.on_road[0].sum() == 5 and record.on_road[-1].all()
    assert record.reports["choices"] >= 2 and record.reports["input_faults"] == 0
    measures = measure(record, scenario)
    assert measures.collisions == 0 and measures.gap_min > 0


def test_on_the_wave_the_leader_drives_the_profile(fmu):
    scenario = stop_and_go(duration=20.0)
    for driver in (controllers(fmu, wave=True)[2], sumo_drivers()[0]):
        record = drive(scenario, driver)
        expected = [wave_speed(t) for t in record.time]
        np.testing.assert_allclose(record.v[:, 0], expected, atol=1e-6)


def test_a_delay_of_half_a_second_is_felt(fmu):
    scenario = highway(duration=20.0)
    plain, late = drive(scenario, v_new(fmu)), drive(scenario, v_new(fmu), disturbance=Disturbance(delay=0.5))
    assert measure(late, scenario).a_rms > measure(plain, scenario).a_rms
    lazy = drive(scenario, v_new(fmu), disturbance=Disturbance(lag=0.5))
    assert measure(lazy, scenario).gap_min != measure(plain, scenario).gap_min


def test_measures_of_a_run_made_by_hand():
    """Two cars, the rear one closing at 2 m/s until it touches, on a clock of 0.1 s."""
    time = 0.1 * np.arange(200)
    x = np.stack([20.0 * time + 25.0, 22.0 * time], axis=1)
    v = np.tile([20.0, 22.0], (200, 1))
    record = Record(time, x, v, np.ones_like(x, dtype=bool), np.array([10.0, 12.0]), np.ones(2), {})
    scenario = Scenario("by hand", np.array([25.0]), np.array([20.0, 22.0]), v_star=21.0)
    s, closing, pairs = gaps(record)
    np.testing.assert_allclose(s[:, 0], np.abs(25.0 - 2 * time))
    np.testing.assert_allclose(closing[:120], 2.0)
    assert (pairs == [0, 1]).all()
    measures = measure(record, scenario)
    assert measures.collisions == 1 and np.isnan(measures.settling)
    assert measures.gap_min == 0.0
    np.testing.assert_allclose(measures.ttc_min, 0.1, atol=1e-6)
    np.testing.assert_allclose(measures.co2, 22.0 / (1e-3 * (20.0 + 22.0) * 19.9))
    apart = measure(replace(record, x=x + np.array([100.0, 0.0])), scenario)
    assert apart.collisions == 0
    np.testing.assert_allclose(apart.gap_min, 120.0 - 2 * 19.9)


def test_the_command_line_shows_a_table(fmu, capsys):
    from typer.testing import CliRunner

    from psp_cli.main import app

    ran = CliRunner().invoke(app, ["sumo", "highway", "--fmu", str(fmu), "--duration", "15"])
    assert ran.exit_code == 0, ran.output
    rows = [line for line in ran.output.splitlines() if line.startswith(("| V_", "| IDM", "| ACC", "| CACC"))]
    assert len(rows) == 5


def test_the_example_runs(capsys):
    spec = spec_from_file_location("in_sumo", Path(__file__).parents[2] / "examples" / "04_in_sumo.py")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    rows = module.main(15.0)
    assert rows["V_new"].collisions == 0 and "| CACC |" in capsys.readouterr().out
