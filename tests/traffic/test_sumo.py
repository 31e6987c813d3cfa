"""Short runs in SUMO: repeatable, safe where the paper's assumptions hold, and honest where they do not."""

from __future__ import annotations

import json
from dataclasses import replace
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from build_fmu import main as build
from psp_model import PlatoonState, PotentialParameters, StartDomain, simulate
from psp_model.vehicles.leader import Profile
from psp_traffic.controller_fmu import ControllerFmu, Fleet, Platoon
from psp_traffic.driver import Driver, controllers, sumo_drivers
from psp_traffic.measures import Measures, contact, measure, spacings
from psp_traffic.results import Results
from psp_traffic.scale import SIZE, cost
from psp_traffic.scenario import STOP_AND_GO, Scenario, highway, highway_apart, on_profile, ramp, stop_and_go
from psp_traffic.simulation import Disturbance, Record, _Run
from psp_traffic.simulation import simulate as drive
from psp_traffic.summary import table
from psp_traffic.sweep import Tolerance, Trial, of_sweep, sweep, sweep_text
from psp_view.traffic import draw_following, draw_tolerance

pytestmark = pytest.mark.system("sumo")
ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def fmu(native_controller_fmu):
    return native_controller_fmu.path


def v_new(fmu) -> Driver:
    return controllers(fmu)[0]


def test_a_run_is_repeatable(fmu):
    scenario = highway(duration=3.0)
    for driver in (v_new(fmu), sumo_drivers()[2]):
        one, other = drive(scenario, driver), drive(scenario, driver)
        for name in ("x", "v", "on_road", "co2", "fuel"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


@pytest.mark.parametrize("scenario", [ramp(duration=20.0), replace(stop_and_go(), duration=15.0)], ids=["ramp", "wave"])
def test_both_controllers_drive_alike(native_controller_fmu, python_controller_fmu, scenario):
    disturbance = Disturbance(delay=0.1, lag=0.2)
    by_native, by_python = (
        drive(scenario, v_new(fmu.path), disturbance=disturbance)
        for fmu in (native_controller_fmu, python_controller_fmu)
    )
    for name in ("x", "v", "on_road", "co2", "fuel"):
        np.testing.assert_allclose(getattr(by_native, name), getattr(by_python, name), rtol=0, atol=1e-9)
    assert by_native.reports == pytest.approx(by_python.reports, rel=0, abs=1e-9)


def test_a_fleet_of_platoons_is_commanded_as_each_of_them_alone(fmu, tmp_path):
    unpacked, count = ControllerFmu(fmu, tmp_path), 3
    fleet = Fleet(unpacked, count, {"parameter_source": 2}, 0.01)
    alone = [Platoon(unpacked, f"alone{k}", {"parameter_source": 2}, 0.01) for k in range(count)]
    for k in range(5):
        s, v = StartDomain().draw(np.random.default_rng(k), 5, count)
        together = fleet.command(s.T, v.T, 0.01 * k)
        one_by_one = [one.command(s[:, i], v[:, i], 0.01 * k) for i, one in enumerate(alone)]
        np.testing.assert_array_equal(together, one_by_one)
    with pytest.raises(RuntimeError, match="status 3"):
        alone[0].command(np.array([4.0]), np.array([30.0, 30.0]), 0.05)
        alone[0].command(np.array([4.0]), np.array([30.0, 30.0]), 0.06)
    fleet.close()


def test_the_cost_of_a_run_is_told_apart(fmu, tmp_path):
    with pytest.raises(ValueError, match="10 vehicles do not fit"):
        cost(1, 1, v_new(fmu))
    options = ["--component", "controller", "--vehicles", str(SIZE), "--output", str(tmp_path)]
    assert build(options) == 0
    driver = v_new(tmp_path / "PspController.fmu")
    of_controller, of_nobody = cost(2, 20, driver), cost(2, 20, driver, exchange=True)
    of_sumo = cost(2, 20, sumo_drivers()[2])
    assert {one.vehicles * one.steps for one in (of_controller, of_nobody, of_sumo)} == {20 * 2 * SIZE}
    assert of_controller.controller > of_nobody.controller > of_sumo.controller == of_sumo.exchange == 0.0


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
    assert measures.collisions == 0 and measures.clearance_min > 0


def test_a_leader_drives_its_own_speed_whoever_follows(fmu):
    wltc = np.loadtxt(ROOT / "psp_traffic/profiles/wltc_high.csv", delimiter=",", comments=("#", "time"))
    for driver in (controllers(fmu, led=True)[2], sumo_drivers()[0]):
        record = drive(stop_and_go(duration=13.0), driver)
        np.testing.assert_allclose(record.v[:, 0], [STOP_AND_GO.speed(t) for t in record.time], atol=1e-6)
        record = drive(on_profile(duration=8.0), driver)
        np.testing.assert_allclose(record.v[:, 0], np.interp(record.time, *wltc.T), atol=1e-6)
        assert measure(record, on_profile()).collisions == 0


STANDING = Profile((0.0, 60.0), (0.0, 0.0))
STOPPING = Profile((0.0, 2.0, 9.0, 60.0), (25.0, 25.0, 0.0, 0.0))


@pytest.mark.parametrize("number", range(7))
@pytest.mark.parametrize("leader", [STANDING, STOPPING], ids=["standing", "stopping"])
def test_nobody_leaves_the_lane_of_a_leader_who_stands(fmu, leader, number, monkeypatch):
    """SUMO's own lane change model would take the drivers round him; whoever drives on touches him, and is counted."""
    driver = [*controllers(fmu, led=True), *sumo_drivers()][number]
    lanes: set[str] = set()
    read = _Run._read

    def noted(self, *arguments):
        read(self, *arguments)
        lanes.update(self.sumo.vehicle.getLaneID(name) for name in self.names)

    monkeypatch.setattr(_Run, "_read", noted)
    v = np.r_[leader.speed(0.0), np.full(4, 20.0)]
    scenario = Scenario("standing", np.r_[60.0, np.full(3, 25.0)], v, duration=16.0, leader=leader)
    record = drive(scenario, driver)
    assert lanes == {"before_0"} and record.on_road.all()
    passed = (record.x[:, 1:] > record.x[:, :1]).any()
    collisions = measure(record, scenario).collisions
    assert collisions > 0 or not passed
    assert driver.fmu is not None or (collisions == 0 and not passed)


def test_on_a_ramp_only_those_who_come_in_change_lanes_and_only_once(fmu):
    scenario = ramp(duration=25.0)
    for driver in (v_new(fmu), *sumo_drivers()):
        on_road = drive(scenario, driver).on_road
        through = scenario.v.size
        assert on_road[:, :through].all()
        assert (np.diff(on_road[:, through:].astype(int), axis=0) >= 0).all()


def test_only_contacts_on_the_same_lane_are_counted():
    time, both = 0.1 * np.arange(200), np.ones((200, 2), dtype=bool)
    x = np.stack([10.0 * time + 30.0, 20.0 * time], axis=1)  # the second passes the first
    scenario = Scenario("passing", np.array([30.0]), np.array([10.0, 20.0]))
    together = Record(time, x, np.tile([10.0, 20.0], (200, 1)), both, np.ones(2), np.ones(2), {})
    assert measure(together, scenario).collisions == 1 and contact(together) < 3
    assert np.isinf(contact(replace(together, on_road=both & [True, False])))


def test_warnings_name_situation_driver_and_start(native_controller_fmu):
    ran = psp("stop-and-go", "--fmu", native_controller_fmu.path, "--starts", "2", "--duration", "15")
    said = [line for line in ran.stderr.splitlines() if line.startswith("psp: warning: ")]
    assert {line.split(": ")[2] for line in said} >= {
        f"stop-and-go, {driver}, start {start}" for driver in ("V_new", "V_new, v_leader") for start in (1, 2)
    }
    assert not [line for line in ran.stderr.splitlines() if line.startswith("controller: ")]


def test_a_terminal_gets_drawn_tables(monkeypatch, capsys):
    from psp_cli import sumo_tables

    screen = Console(force_terminal=True, width=110, color_system=None)
    monkeypatch.setattr(sumo_tables, "console", lambda: screen)
    row = Measures(0, 2.0, 3.0, 1.0, 0.5, 1.0, 0.5, 5000.0, 20.0, 4.0, np.nan, 150.0, 50.0)
    sumo_tables.show_measures("**highway**, 1 start", {"V_new": [row], "[IDM]": [row]})
    trial = Trial(np.inf, np.inf, 1.25, 0.4)
    sumo_tables.show_tolerances("highway", {("V_new", 0.0, lag): Tolerance((trial,)) for lag in (0.0, 0.5)})
    shown = capsys.readouterr().out
    assert "| " not in shown and "**" not in shown and "[IDM]" in shown and "CO2 [g/km]" in shown
    assert sum("│" in line for line in shown.splitlines()) >= 14 and "1.25 m" in shown and "Without delay:" in shown


def test_a_delay_of_half_a_second_is_felt(native_controller_fmu):
    fmu = native_controller_fmu.path
    scenario = highway(duration=6.0)
    plain, late = drive(scenario, v_new(fmu)), drive(scenario, v_new(fmu), disturbance=Disturbance(delay=0.5))
    assert measure(late, scenario).a_rms > measure(plain, scenario).a_rms
    lazy = drive(scenario, v_new(fmu), disturbance=Disturbance(lag=0.5))
    assert measure(lazy, scenario).clearance_min != measure(plain, scenario).clearance_min


def test_measures_of_a_run_made_by_hand():
    """Two cars, the rear one closing at 2 m/s until it touches, on a clock of 0.1 s."""
    time = 0.1 * np.arange(200)
    x = np.stack([20.0 * time + 25.0, 22.0 * time], axis=1)
    v = np.tile([20.0, 22.0], (200, 1))
    record = Record(time, x, v, np.ones_like(x, dtype=bool), np.array([10.0, 12.0]), np.ones(2), {})
    scenario = Scenario("by hand", np.array([25.0]), np.array([20.0, 22.0]), v_star=21.0)
    s, closing, pairs = spacings(record)
    np.testing.assert_allclose(s[:, 0], np.abs(25.0 - 2 * time))
    np.testing.assert_allclose(closing[:120], 2.0)
    assert (pairs == [0, 1]).all()
    measures = measure(record, scenario)
    assert measures.collisions == 1 and np.isinf(measures.settling)
    assert contact(record) == pytest.approx(10.0)
    assert measures.clearance_min == 0.0
    np.testing.assert_allclose(measures.ttc_min, 0.1, atol=1e-6)
    np.testing.assert_allclose(measures.co2, 22.0 / (1e-3 * (20.0 + 22.0) * 19.9))
    apart = measure(replace(record, x=x + np.array([100.0, 0.0])), scenario)
    assert apart.collisions == 0
    np.testing.assert_allclose(apart.clearance_min, 120.0 - 2 * 19.9)


def test_nobody_brakes_hard_only_because_he_starts_fast():
    scenario = highway_apart(duration=6.0)
    assert scenario.v.max() > 32
    record = drive(scenario, sumo_drivers()[1])
    assert np.diff(record.v, axis=0).min() / 0.01 > -3.0 and record.v[-1].max() < 30.1


def psp(*arguments: object):
    from typer.testing import CliRunner

    from psp_cli.main import app

    return CliRunner().invoke(app, ["sumo", *map(str, arguments)])


def test_the_command_line_keeps_its_runs_and_goes_on_from_them(native_controller_fmu, tmp_path):
    fmu = native_controller_fmu.path
    kept = tmp_path / "runs.json"
    options = ("highway-apart", "--fmu", fmu, "--duration", "15", "--starts", "1", "--output", kept)
    ran = psp(*options)
    assert ran.exit_code == 0, ran.output
    rows = [line for line in ran.stdout.splitlines() if line.startswith(("| V_", "| IDM", "| ACC", "| CACC"))]
    assert len(rows) == 5
    made = json.loads(kept.read_text())
    fewer = {name: run for name, run in made["runs"].items() if "IDM" not in name}
    assert len(fewer) == 4 and made["settings"]["duration"] == 15
    kept.write_text(json.dumps(made | {"runs": fewer}))
    assert psp(*options).stdout == ran.stdout
    assert json.loads(kept.read_text())["runs"] == made["runs"]
    ran = psp(*options[:4], "16", *options[5:])
    assert ran.exit_code == 2 and "other settings (duration)" in ran.output and kept.read_text() != ""
    kept.write_text("[]")
    ran = psp(*options)
    assert ran.exit_code == 2 and "holds no results" in ran.output and kept.read_text() == "[]"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("ramp", "--profile", "own.csv"), "--profile says nothing to ramp"),
        (("profile", "--profile", "none.csv"), "none.csv cannot be read"),
        (("profile", "--profile", "own.csv"), "lasts 4000 s, more than 3600 s"),
        (("ramp", "--sweep"), "ramp is not swept"),
        (("--plot", "spacings.png"), "--plot draws one situation"),
        (("ramp", "--fmu", "none.fmu"), "none.fmu does not exist"),
    ],
)
def test_what_the_command_line_refuses(arguments, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("own.csv").write_text("10,0\n4010,1\n")
    ran = psp(*arguments)
    assert ran.exit_code == 2 and ran.output.startswith("psp: ") and words in ran.output


def test_a_sweep_ends_each_run_at_the_first_contact(native_controller_fmu):
    fmu = native_controller_fmu.path
    starts = {1: highway(seed=1, duration=6.0)}
    runs = Results()
    found = sweep(starts, fmu, runs, delays=(0.0, 0.5), lags=(0.0, 0.8))
    kind, bad = found["V_new", 0.0, 0.0], found["V_old", 0.5, 0.8]
    assert (kind.collided, kind.violated, kind.first) == (0, 0, np.inf) and kind.clearance_min > 1
    assert (bad.collided, bad.clearance_min) == (1, 0.0) and bad.first < 3
    assert of_sweep(runs.runs, "highway") == found
    lines = sweep_text(found).splitlines()
    assert "| **0.5 s** |" in "\n".join(lines) and sum("1 of 1" in line for line in lines) >= 1


def test_several_starts_become_one_row():
    good = Measures(0, 2.0, 3.0, 1.0, 0.5, 1.0, 0.5, 5000.0, 20.0, 4.0, np.nan, 150.0, 50.0)
    bad = replace(good, collisions=2, clearance_min=0.0, capacity=1000.0, settling=np.inf)
    (row,) = table({"V_new": [good, bad]}).splitlines()[2:]
    assert row.startswith("| V_new | 2 (in 1 of 2) | 1.00 (0.00) | 3.00 (3.00) |")
    assert "| 3000 (1000) |" in row and "| 4.0 (never) | - |" in row


def test_the_map_of_a_sweep_says_what_happened_in_each_field():
    fine, bad = Trial(np.inf, np.inf, 1.25, 0.4), Trial(3.0, 2.5, 0.0, 2.0)
    found = {("V_new", 0.0, 0.0): Tolerance((fine, fine)), ("V_new", 0.0, 0.5): Tolerance((fine, bad))}
    figure = draw_tolerance(found, "by hand", "psp sumo")
    axes = figure.axes[0]
    assert [text.get_text() for text in axes.texts] == ["1.25 m", "1 of 2"]
    np.testing.assert_array_equal(axes.images[0].get_array(), [[0.0, 0.5]])
    lines = sweep_text(found).splitlines()
    assert lines[-3] == "| **0 s** | 1.25 m | 1 of 2, 2.5 s |"
    told = "contacts 1 in 4 runs, without a violation before 0, otherwise 0.50 to 0.50 s before (median 0.50 s)"
    assert lines[-1] == f"Without delay: {told}. With delay: contacts 0 in 0 runs, without a violation before 0."


def test_the_picture_of_a_run_shows_free_spacings_and_ends_at_the_contact(native_controller_fmu):
    scenario = stop_and_go(duration=3.0)
    record = drive(scenario, controllers(native_controller_fmu.path, led=True)[0])
    touching = replace(record, x=record.x + np.where(record.time >= 2.0, 10.0, 0.0)[:, None] * (np.arange(7) == 6))
    figure = draw_following({"free": record, "touching": touching}, 3.0, "by hand", "psp sumo")
    spacing = figure.axes[0].lines[5]
    np.testing.assert_allclose(spacing.get_ydata(), record.x[:, 5] - record.x[:, 6] - 5.0)
    assert [text.get_text() for text in figure.axes[2].texts] == ["contact at 2.0 s"]
    assert not figure.axes[0].texts and len(figure.axes[1].lines) == 7


def test_the_example_runs(capsys):
    spec = spec_from_file_location("in_sumo", ROOT / "examples" / "04_in_sumo.py")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    rows = module.main(15.0)
    assert rows["V_new"][0].collisions == 0 and "| CACC |" in capsys.readouterr().out
