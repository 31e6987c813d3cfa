"""Joining and leaving through FMI: what is asked for happens, once, or is refused with the platoon unharmed."""

from __future__ import annotations

from math import nan
from pathlib import Path

import numpy as np
import pytest

from fmu_src.native.build import build_native_fmu, native_platoon
from fmu_src.networks import networks_up_to
from fmu_src.python.build import build_python_fmu
from harness import ERROR, OK, Instance, Unpacked, random_start, starts
from psp_model import BEST_FIXED, PlatoonParameters, PlatoonState, Sampling, project, simulate
from psp_model.selection.network import read_networks

ONNX = Path(__file__).parents[2] / "onnx"

T, N = 0.01, 7
FIXED = {"parameter_source": 2, "lemma1_policy": 3}


@pytest.fixture
def road(instance):
    return instance


def join(behind: float, spacing: float, speed: float) -> dict[str, float]:
    return {"insert": 1.0, "insert_behind": behind, "insert_gap": spacing, "insert_speed": speed}


def active(road, name: str) -> list[float]:
    n = int(road.get("n_active")[0])
    values = road.group(name)
    assert not any(values[n - (name == "s") :])
    return values[: n - (name == "s")]


def test_after_a_join_it_goes_on_as_a_platoon_that_starts_there(road):
    s, v = random_start(32)
    assert road.initialise(FIXED | starts(s, v) | {"n_start": 6}) == OK
    assert road.get("n_active", "vehicle[6]", "vehicle[7]") == [6.0, 6.0, 0.0]
    assert road.step(0.0, 1.0) == OK
    spacings, speeds = active(road, "s"), active(road, "v")
    assert road.set(join(6, 9.5, 29.0)) == OK
    assert road.step(1.0, 1.0) == OK
    assert road.get("n_active", "vehicle[7]", "change_ok", "changes") == [7.0, 7.0, 1.0, 1.0]
    run = simulate(
        PlatoonState(np.array([*spacings, 9.5]), np.array([*speeds, 29.0])),
        BEST_FIXED,
        duration=1.0,
        sampling=Sampling(T),
    )
    np.testing.assert_allclose(active(road, "s"), run.s[-1], rtol=0, atol=1e-9)
    np.testing.assert_allclose(active(road, "v"), run.v[-1], rtol=0, atol=1e-9)


def test_a_trigger_acts_once_when_it_rises_and_between_instants_too(road):
    assert road.initialise(FIXED | {"n_start": 4}) == OK
    assert road.step(0.0, 0.0137) == OK
    assert road.set({"remove": 1.0, "remove_place": 1.0}) == OK
    assert road.step(0.0137, 0.0) == OK
    assert road.get("n_active") == [4.0]
    x = active(road, "x")
    for k in range(5):
        assert road.step(0.0137 + k * T, T) == OK
        assert road.get("n_active", "vehicle[1]", "vehicle[3]", "vehicle[4]") == [3.0, 2.0, 4.0, 0.0]
    assert all(now > before for now, before in zip(active(road, "x"), x[1:], strict=True))


def test_a_join_that_lemma_1_does_not_cover_is_refused_and_the_offered_spacing_does(road):
    assert road.initialise(FIXED | starts([20.0] * 6, [30.0] * 7) | {"n_start": 4}) == OK
    before = road.outputs()
    assert road.set(join(2, 5.1, 30.0)) == OK
    assert road.step(0.0, 1e-9) == OK
    assert road.get("change_ok", "refusals", "changes", "n_active") == [0.0, 1.0, 0.0, 4.0]
    (offered,) = road.get("gap_offered")
    assert "would be accepted" in road.messages[-1][1] and f"{offered:.10g}" in road.messages[-1][1]
    unharmed = len(before) - N - 5  # what changes counts comes last
    np.testing.assert_allclose(road.outputs()[:unharmed], before[:unharmed], atol=1e-6)
    assert road.set({"insert": 0.0}) == OK
    assert road.step(1e-9, 1e-9) == OK
    assert road.set(join(2, offered, 30.0)) == OK
    assert road.step(2e-9, T) == OK
    assert road.get("change_ok", "n_active", "vehicle[3]") == [1.0, 5.0, 5.0]


@pytest.mark.parametrize("request_", [join(nan, 9.0, 30.0), join(3, nan, 30.0), join(3, 9.0, nan), join(9, 9.0, 30.0)])
def test_a_senseless_join_is_refused(road, request_):
    assert road.initialise(FIXED | {"n_start": 3}) == OK
    assert road.set(request_) == OK
    assert road.step(0.0, T) == OK
    assert road.get("change_ok", "n_active") == [0.0, 3.0]


def drive(road, seed: int, count: int, first: int) -> list[list[float]]:
    """Steps of random length with a random request before each."""
    rng, seen, time = np.random.default_rng(seed), [], first * 0.05
    for k in range(count):
        asked = join(rng.integers(0, 8), rng.uniform(5, 30), rng.uniform(0, 35))
        asked |= {"insert": float(k % 2), "remove": float(rng.random() < 0.3), "remove_place": rng.integers(1, 8)}
        assert road.set({name: float(value) for name, value in asked.items()}) == OK
        assert road.step(time, 0.05) == OK
        time += 0.05
        seen.append(road.outputs())
    return seen


def test_a_replay_from_a_saved_or_serialised_state_gives_the_identical_future(road):
    other = Instance(road.fmu)
    assert road.initialise(FIXED) == OK
    drive(road, 1, 60, 0)
    state = road.slave.getFMUstate()
    data = road.slave.serializeFMUstate(state)
    expected = drive(road, 2, 60, 60)
    sizes = {row[-(N + 5)] for row in expected}
    assert len(sizes) > 2
    road.slave.setFMUstate(state)
    assert drive(road, 2, 60, 60) == expected
    other.slave.setFMUstate(other.slave.deSerializeFMUstate(data))
    assert drive(other, 2, 60, 60) == expected
    assert other.call("fmi2Reset") == OK
    assert road.call("fmi2Reset") == OK
    assert road.initialise(FIXED) == OK and other.initialise(FIXED) == OK
    assert road.outputs() == other.outputs()
    other.close()


def test_a_platoon_may_start_with_one_vehicle_and_be_left_with_one(road):
    names = [name for name in road.fmu.reference if name[:2] in ("x[", "v[", "a[", "s[")]
    names += ["T_max", "alpha", "r", "p", "n_active"]
    seen = []
    for n in (1, 2):
        assert road.initialise(FIXED | {"n_start": n, "v_start[1]": 25.0}) == OK
        assert road.set({"remove": float(n == 2), "remove_place": 2.0}) == OK
        for k in range(50):
            assert road.step(0.1 * k, 0.1) == OK
        seen.append(road.get(*names))
        assert road.set({"remove": 0.0, "remove_place": 1.0}) == OK and road.step(5.0, 0.1) == OK
        assert road.set({"remove": 1.0}) == OK and road.step(5.1, 0.1) == OK
        assert "last vehicle" in road.messages[-1][1]
        assert road.call("fmi2Reset") == OK
    assert seen[0] == seen[1] and seen[0][-1] == 1.0


def test_a_lone_vehicle_at_rest_with_its_desired_speed_has_a_finite_bound(road):
    assert road.initialise(FIXED | {"n_start": 1, "v_start[1]": 30.0}) == OK
    assert road.get("T_max", "lemma1_ok") == [1e9, 1.0]


def test_a_fallback_that_is_not_feasible_is_refused_before_it_is_needed(road):
    assert road.initialise({"parameter_source": 1, "p_fixed": 8.0}) == ERROR
    assert "max |V_new'|" in road.messages[-1][1]


def test_joining_as_the_leader_with_a_spacing_too_small_says_which_place(road):
    assert road.initialise(FIXED | starts([20.0] * 6, [30.0] * 7) | {"n_start": 3}) == OK
    assert road.set(join(0, 5.2, 30.0)) == OK and road.step(0.0, T) == OK
    assert "at place 1 with a spacing of 5.2 m at 30 m/s" in road.messages[-1][1]


@pytest.mark.parametrize("runtime", ["python", "native"])
def test_without_a_network_for_as_many_vehicles_the_fixed_triple_takes_over(tmp_path, runtime):
    networks = {7: networks_up_to(7)[7]}
    if runtime == "python":
        path = build_python_fmu(7, tmp_path, networks)
    else:
        path = build_native_fmu(native_platoon(7, networks), tmp_path)
    road = Instance(Unpacked(path, tmp_path / "unpacked"))
    assert road.initialise(starts(*random_start(33))) == OK
    assert road.get("network_in_domain") == [1.0]
    assert road.set({"remove": 1.0, "remove_place": 7.0}) == OK and road.step(0.0, T) == OK
    assert "the initial state has 6 vehicles, for which there is no network here" in road.messages[-1][1]
    assert road.get("network_in_domain", "r") == [0.0, 11.0]
    road.close()


def test_with_a_network_for_as_many_vehicles_it_is_asked_anew(road):
    s, v = random_start(33)
    assert road.initialise(starts(s, v)) == OK
    network = read_networks(ONNX, {4: "platoon_any.onnx"})[4]
    for k in range(3):
        assert road.set({"remove": 1.0, "remove_place": 7.0 - k}) == OK
        assert road.step(2e-7 * k, 1e-7) == OK
        assert road.set({"remove": 0.0}) == OK and road.step(2e-7 * k + 1e-7, 1e-7) == OK
    chosen = project(
        network.evaluate(np.array(road.group("s")[:3]), np.array(road.group("v")[:4])), PlatoonParameters()
    )
    assert road.get("network_in_domain") == [1.0]
    np.testing.assert_allclose(road.get("alpha", "r", "p"), [chosen.alpha, chosen.r, chosen.p], rtol=1e-5)
