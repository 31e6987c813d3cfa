"""`psp simulate --leader`: three FMUs behind a leader who drives himself, against the model's own loop."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from psp_cli.behind import CLEARANCE, START, Behind, parameters, run_behind
from psp_cli.main import app
from psp_model import BEST_FIXED, ControllerSettings, Lemma1Policy, Measurement, Sampling
from psp_model.analysis.behind import BehindLeader
from psp_model.controller import SampledController, margin_of
from psp_model.law.cooperation import Cooperation
from psp_model.parameters import Actuation
from psp_model.selection.selectors import ParameterSource, Request
from psp_model.vehicles.actuation import Foreign
from psp_model.vehicles.delayed import DelayedVehicles
from psp_view.results import read_csv

N, T = 4, 0.05
BRAKES = "# a leader who brakes and drives off\ntime,speed\n0,28\n2,28\n6,12\n8,12\n11,16\n"


@pytest.fixture
def leader(tmp_path: Path) -> Path:
    (tmp_path / "leader.csv").write_text(BRAKES)
    return tmp_path / "leader.csv"


def run(leader: Path, **others: object) -> BehindLeader:
    given = {"T": T} | dict(others.pop("given", {}))  # type: ignore[call-overload]
    asked = Behind(leader, N, values=parameters(given, N), **others)  # type: ignore[arg-type]
    return run_behind(asked, lambda steps: lambda: None)[0]


def model(late: int, told: Actuation, true: Actuation, steps: int, cooperation: Cooperation) -> tuple[list, list]:  # type: ignore[type-arg]
    """The same loop in the model: states of the plant, and brake margins, at the sampling instants."""
    speeds = np.interp(T * np.arange(steps + 2), [0, 2, 6, 8, 11], [28, 28, 12, 12, 16])
    own = np.diff(speeds) / T
    request = Request(source=ParameterSource.FIXED, fixed=BEST_FIXED)
    controller = SampledController.begin(
        ControllerSettings(
            N,
            sampling=Sampling(T, Lemma1Policy.WARN),
            request=request,
            cooperation=cooperation,
            actuation=told,
            a_safe=-4.0,
            max_age=late * T + 2 * T,
        )
    )
    plant, automated = DelayedVehicles(true), np.r_[0.0, np.ones(N - 1)]
    now, past, states, margins = plant.begin(0.0, np.full(N - 1, 5.0 + CLEARANCE), np.full(N, 28.0)), [], [], []
    for k in range(steps + 1):
        past = [*past[-late:], (now, own[k], k)] if late else [(now, own[k], k)]
        seen, a_leader, then = past[0]
        measured = Measurement(
            seen.s, seen.v, N, age=(k - then) * T, automated=automated, a_measured=np.full(N, a_leader)
        )
        controller.sample(k * T, measured)
        states.append(now)
        margins.append(margin_of(controller.settings, controller.now))
        now = plant.advance(now, controller.now.a, T, Foreign(automated, np.full(N, own[k])))[0]
    return states, margins


@pytest.mark.parametrize("runtime", ["python", "native"])
def test_the_fmus_do_what_the_model_does(leader: Path, runtime: str) -> None:
    found = run(leader, delay=0.17, lag=0.2, age=0.1, runtime=runtime)
    actuation = Actuation(0.17, 0.2, START["a_min"], START["a_max"])
    states, margins = model(2, actuation, actuation, 220, Cooperation(kappa=1.0))
    np.testing.assert_allclose(found.s, [state.s for state in states], atol=1e-6)
    np.testing.assert_allclose(found.v, [state.v for state in states], atol=1e-6)
    np.testing.assert_allclose(found.brake_margin, margins, atol=1e-4)
    np.testing.assert_allclose(found.v[:, 0], np.interp(found.time, [0, 2, 6, 8, 11], [28, 28, 12, 12, 16]), atol=1e-9)
    assert found.contact is None and found.time[-1] == pytest.approx(11.0)


def test_what_is_believed_may_be_wrong(leader: Path) -> None:
    found = run(leader, delay=0.2, lag=0.2, given={"actuation_delay": 0.1, "actuator_lag": 0.3})
    told, true = (Actuation(*of, START["a_min"], START["a_max"]) for of in ((0.1, 0.3), (0.2, 0.2)))
    states, _ = model(0, told, true, 220, Cooperation(kappa=1.0))
    np.testing.assert_allclose(found.s, [state.s for state in states], atol=1e-6)


def test_the_command_writes_prints_and_draws(leader: Path, tmp_path: Path) -> None:
    line = f"simulate --leader {leader} -n {N} --delay 200ms --lag 0.2 --set T=0.05 --csv {tmp_path / 'run.csv'} "
    line += f"--plot {tmp_path / 'run.png'} --json {tmp_path / 'run.json'}"
    result = CliRunner().invoke(app, line.split())
    assert result.exit_code == 0, result.output
    table = read_csv(tmp_path / "run.csv")
    figures = json.loads((tmp_path / "run.json").read_text())["runs"]["behind leader.csv"]
    least = min(table[f"clearance[{i}]"].min() for i in range(2, N + 1))
    assert figures["least clearance"] == {"value": least, "unit": "m"} and f"{least:.6g}" in result.stdout
    a = [np.diff(table[f"v[{i}]"]) / 0.05 for i in range(1, N + 1)]
    size = [np.sqrt((one**2).mean()) for one in a]
    assert figures["head-to-tail gain"]["value"] == pytest.approx(size[-1] / size[0])
    assert figures["gain along the platoon"]["value"] == pytest.approx(size[-1] / size[1])
    assert (tmp_path / "run.png").stat().st_size > 10_000


def test_a_contact_ends_the_run_and_is_said(leader: Path, tmp_path: Path) -> None:
    line = f"simulate --leader {leader} -n {N} --delay 0.9 --set T=0.05 --set kappa=0 --set actuation_delay=0 "
    result = CliRunner().invoke(app, [*line.split(), "--set", "feedforward=0", "--plot", str(tmp_path / "run.png")])
    assert result.exit_code == 0 and "touches vehicle" in result.stderr and "where the run ends" in result.stderr


WRONG = [
    ("--delay -1", "psp: delay = -1 s must be finite and not negative: give it 0 s or more"),
    (
        "--set lenght=3",
        "psp: 'lenght' is not a parameter of a controller or plant of 4 vehicles: did you mean",
    ),
    ("--set following=1.5", "psp: following = 1.5 is not one of its choices: give it a whole number"),
    ("--set mu=-1", "psp: mu = -1 1/s must be positive"),
    ("--set T=0", "psp: T = 0 s must be positive"),
    ("--delay 30", "psp: actuation_delay = 30 s must not exceed"),
    ("--scenario x.toml", "psp: --scenario does not go with --leader: leave it out"),
    ("--seed 1", "psp: --seed does not go with --leader: leave it out"),
]


@pytest.mark.parametrize(("option", "sentence"), WRONG)
def test_what_is_wrong_is_one_sentence(leader: Path, option: str, sentence: str) -> None:
    result = CliRunner().invoke(app, ["-q", "simulate", "--leader", str(leader), "-n", str(N), *option.split()])
    assert result.exit_code == 2 and result.stderr.count("\n") == 1 and result.stderr.startswith(sentence), (
        result.stderr
    )


def test_options_of_a_leader_need_one() -> None:
    result = CliRunner().invoke(app, ["simulate", "--delay", "0.1"])
    assert result.exit_code == 2
    assert result.stderr == "psp: --delay goes with --leader only: give a leader's profile, or leave it out\n"


def test_the_start_values_are_those_of_the_road_page() -> None:
    page = (Path(__file__).parents[2] / "docs" / "road.md").read_text(encoding="utf-8")
    for name, value in START.items():
        assert f"`{name}` {value:g}" in page, name
