"""A platoon told to stand, a leader who brakes to standstill, measurements with rounding errors, driving off."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from harness import ERROR, OK, random_start
from psp_model import BEST_FIXED, V_OLD, Lemma1Policy, PlatoonParameters, PlatoonState, Sampling
from psp_model.controller import BadMeasurement, ControllerSettings, Measurement, SampledController
from psp_model.law.feedback import feedback, feedback_towards
from psp_model.parameters import Actuation
from psp_model.sampling.hold import Motion
from psp_model.selection.selectors import ParameterSource, Request
from psp_model.validate import validate
from psp_model.vehicles.ideal import IdealPlant

T, N, L, V_MAX = 0.01, 7, 5.0, 35.0
FIXED = {"parameter_source": 2}
BEARING = FIXED | {"bad_input": 2, "lemma1_policy": 2}


def named(s, v) -> dict[str, float]:
    spacings = {f"s[{i}]": spacing for i, spacing in enumerate(s, start=2)}
    return spacings | {f"v[{i}]": speed for i, speed in enumerate(v, start=1)}


def controller_of(vehicles: int, old: bool = False, policy: Lemma1Policy = Lemma1Policy.ERROR) -> SampledController:
    request = Request(old=old, source=ParameterSource.FIXED)
    sampling = Sampling(T, policy)
    return SampledController.begin(
        ControllerSettings(vehicles, request=request, sampling=sampling, bad_input=BadMeasurement.SAFE_ACTION)
    )


def drive(
    controller: SampledController,
    motion: Motion,
    seconds: float,
    desired: Callable[[float], float],
    leader: Callable[[float], float] | None = None,
) -> list[Motion]:
    """Motion at every sampling instant; a `leader` drives vehicle 1 at a speed of his own, and is followed."""
    plant, seen = IdealPlant(motion, T), [motion]
    for k in range(round(seconds / T)):
        now = plant.now
        v_desired = desired(k * T) if leader is None else float(now.v[0])
        controller.sample(k * T, Measurement(now.s, now.v, now.v.size, v_desired=v_desired))
        a = controller.now.a.copy()
        if leader is not None:
            a[0] = (leader((k + 1) * T) - now.v[0]) / T
        plant = plant.advanced_to(k + 1, a)
        seen.append(plant.now)
    return seen


@pytest.mark.parametrize("seed", range(4))
def test_a_platoon_told_the_speed_of_a_braking_leader_stands_and_stays(seed):
    rng = np.random.default_rng(seed)
    vehicles, braking, old = int(rng.integers(2, 6)), float(rng.uniform(0.8, 9.0)), bool(rng.integers(2))
    s, v = map(np.array, random_start(seed, vehicles))
    controller = controller_of(vehicles, old)
    stopped = 30.0 / braking
    seen = drive(controller, Motion(0.0, s, v), stopped + 90.0, lambda time: max(30.0 - braking * time, 0.0))
    late = seen[round((stopped + 60.0) / T)]
    assert controller.now.faults == controller.now.violations == 0
    assert min(motion.s.min() for motion in seen) > L
    assert (late.v < 1e-9).all() and (seen[-1].v < 1e-9).all()
    np.testing.assert_allclose(seen[-1].positions(), late.positions(), rtol=0, atol=1e-8)


@pytest.mark.parametrize("seed", range(4))
def test_behind_a_leader_of_his_own_who_stands_nobody_creeps(seed):
    rng = np.random.default_rng(seed)
    first, others, braking = rng.uniform([12.0, 8.0, 0.2], [40.0, 16.0, 0.5])
    controller = controller_of(4, bool(seed % 2))
    start = Motion(0.0, np.array([first, others, others]), np.full(4, 10.0))
    seen = drive(controller, start, 10.0 / braking + 80.0, float, lambda time: max(10.0 - braking * time, 0.0))
    late = seen[round((10.0 / braking + 50.0) / T)]
    assert controller.now.faults == 0 and min(motion.s.min() for motion in seen) > L + 0.35
    np.testing.assert_allclose(seen[-1].s, late.s, rtol=0, atol=1e-8)
    assert (seen[-1].v < 1e-9).all()


@pytest.mark.parametrize("old", [False, True])
def test_who_stands_close_together_stays_and_drives_off_when_told(old):
    controller, s = controller_of(4, old), np.array([5.5, 7.0, 9.0])
    start = Motion(0.0, s, np.zeros(4))
    standing = drive(controller, start, 30.0, lambda time: 0.0)
    assert all((motion.v == 0).all() and motion.s.tolist() == s.tolist() for motion in standing)
    moving = drive(controller_of(4, old, Lemma1Policy.WARN), start, 60.0, lambda time: min(time, 20.0))
    assert min(motion.s.min() for motion in moving) > L
    assert moving[-1].v == pytest.approx(20.0, abs=0.5) and moving[-1].x > 800.0


@pytest.mark.parametrize("old", [False, True])
def test_vehicles_that_stand_bumper_to_bumper_by_rounding_drive_off(old):
    controller = controller_of(4, old, Lemma1Policy.WARN)
    start = Motion(0.0, np.array([L - 1e-12, L, L - 3e-7]), np.zeros(4))
    standing = drive(controller, start, 5.0, lambda time: 0.0)
    assert (standing[-1].v == 0).all() and controller.now.faults == 0
    controller = SampledController.begin(
        ControllerSettings(
            4,
            request=controller.settings.request,
            sampling=Sampling(T, Lemma1Policy.WARN),
            actuation=Actuation(a_min=-8.0, a_max=2.0),
        )
    )
    moving = drive(controller, standing[-1], 120.0, lambda time: min(0.5 * time, 10.0))
    assert controller.now.faults == 0 and moving[-1].x > 800.0
    assert (moving[-1].s > L + 0.3).all() and (moving[-1].v > 8.0).all()


def test_the_fmus_stand_behind_a_standing_leader_and_drive_off(instances, controller_fmu, plant_fmu, leader_fmu):
    """The leader's wave goes down to 0 m/s; the platoon told its speed stands there, and goes again."""
    controller, plant, leader = instances(controller_fmu), instances(plant_fmu), instances(leader_fmu)
    s, v = random_start(2)
    starts = {f"s_start[{i}]": spacing for i, spacing in enumerate(s, start=2)}
    starts |= {f"v_start[{i}]": speed for i, speed in enumerate(v, start=1)}
    assert leader.initialise({"v_low": 0.0, "begin": 0.0, "period": 40.0}) == OK
    assert plant.initialise(starts) == OK and controller.initialise(FIXED | named(s, v)) == OK
    time = 0.0
    speeds, spacings = [], []

    def go(seconds: float, desired: float | None) -> None:
        nonlocal time
        for _ in range(round(seconds / T)):
            measured = named(plant.group("s"), plant.group("v"))
            told = leader.get("v")[0] if desired is None else desired
            assert controller.set(measured | {"v_desired": told}) == OK
            assert plant.set({f"a[{i}]": a for i, a in enumerate(controller.group("a"), start=1)}) == OK
            for instance in (controller, plant, leader):
                assert instance.step(time, T) == OK
            time += T
            speeds.append(plant.group("v"))
            spacings.append(plant.group("s"))

    go(20.0, None)
    assert leader.get("v")[0] < 0.01
    go(25.0, 0.0)
    standing = plant.group("x")
    go(5.0, -1e-9)  # a rounding error is no -1, which would mean v_star
    np.testing.assert_allclose(plant.group("x"), standing, rtol=0, atol=1e-3)
    assert controller.get("input_ok", "input_faults") == [1.0, 0.0]
    go(10.0, 20.0)
    assert np.min(speeds) >= 0.0 and np.min(spacings) > L and np.min(speeds[-1]) > 15.0


SMALL = [1e-18, 1e-15, 1e-12, 1e-9, 1e-7]


@pytest.mark.parametrize("seed", range(4))
def test_a_rounding_error_outside_the_state_space_is_taken_as_the_bound(instances, controller_fmu, seed):
    rng = np.random.default_rng(seed)
    s, v = rng.uniform(5.5, 15.0, N - 1), rng.uniform(0.0, V_MAX, N)
    desired = float(rng.choice([0.0, V_MAX, rng.uniform(0.0, V_MAX)]))
    low, high = rng.choice(N, 2, replace=False)
    v[low], v[high] = 0.0, V_MAX
    seen_v, seen_s = v.copy(), s.copy()
    seen_v[low] -= rng.choice(SMALL)
    seen_v[high] += rng.choice(SMALL)
    close = int(rng.integers(N - 1))
    s[close], seen_s[close] = np.nextafter(L, 9.0), L - rng.choice([0.0, *SMALL])
    told = desired + float(rng.choice([0.0, *SMALL])) * (1 if desired > 0 else -1)
    controller = instances(controller_fmu)
    assert controller.initialise(BEARING | named(seen_s, seen_v) | {"v_desired": min(told, V_MAX + 1e-7)}) == OK
    law = feedback_towards(s, v, BEST_FIXED, PlatoonParameters(), min(max(told, 0.0), V_MAX))
    np.testing.assert_allclose(controller.group("a"), np.clip(law, -1000.0, 1000.0), rtol=1e-12, atol=1e-9)
    assert controller.get("input_ok", "input_faults") == [1.0, 0.0]


def test_a_choice_by_rollouts_bears_rounding_too(instances, controller_fmu):
    s, v = random_start(3)
    exact, rounded = instances(controller_fmu), instances(controller_fmu)
    v[2] = 0.0
    case = BEARING | {"parameter_source": 3, "rollout_count": 4, "rollout_horizon": 0.2}
    assert exact.initialise(case | named(s, v)) == OK
    v[2] = -1e-9
    assert rounded.initialise(case | named(s, v)) == OK
    assert rounded.outputs() == exact.outputs()


WORSE = [
    ({"v[2]": -1e-3}, "v[2] = -0.001 m/s", ["0 m/s", "zero"], ["raise v_max", "apart"]),
    ({"v[2]": 35.001}, "v[2] = 35.001 m/s", ["v_max = 35 m/s", "raise v_max"], ["backwards", "apart"]),
    ({"s[4]": 4.9}, "s[4] = 4.9 m", ["L = 5 m", "lower L"], ["v_max", "number the"]),
    ({"s[4]": -4.9}, "s[4] = -4.9 m", ["vehicle 4", "vehicle 3", "number the vehicles"], ["lower L"]),
    ({"s[4]": np.nan}, "s[4] must be a finite number", ["value in m"], ["apart", "lower L"]),
    ({"v[4]": np.inf}, "v[4] must be a finite number", ["value in m/s"], ["raise v_max"]),
    ({"v_desired": -0.2}, "v_desired = -0.2 m/s", ["0 m/s to stand", "-1 m/s"], ["raise v_max"]),
    ({"v_desired": 36.0}, "v_desired = 36 m/s", ["v_max = 35 m/s", "raise v_max"], ["to stand"]),
    ({"v_desired": np.nan}, "v_desired = nan m/s", ["finite", "-1 m/s"], ["raise v_max"]),
    ({"t_measured": np.nan}, "nan s old", ["t_measured"], ["raise max_age", "more often"]),
    ({"t_measured": np.inf}, "-inf s old", ["t_measured"], ["raise max_age"]),
]


@pytest.mark.parametrize(("bad", "value", "fits", "does_not"), WORSE, ids=lambda x: str(x)[:24])
@pytest.mark.parametrize("bad_input", [1, 2])
def test_more_than_rounding_is_refused_with_a_remedy_that_fits_until_it_is_good_again(
    instances, controller_fmu, bad, value, fits, does_not, bad_input
):
    controller, (s, v) = instances(controller_fmu), random_start(8)
    good = named(s, v) | {"v_desired": -1.0, "t_measured": -1.0}
    assert controller.initialise(FIXED | good | {"bad_input": bad_input}) == OK
    assert controller.step(0.0, T) == OK and controller.set(bad) == OK
    assert controller.step(T, T) == (ERROR if bad_input == 1 else OK)
    (sentence,) = [text for _, text in controller.messages]
    assert value in sentence and all(part in sentence for part in fits), sentence
    assert not any(part in sentence for part in [*does_not, "bad_input"]), sentence
    if bad_input == 2:
        assert controller.set(good) == OK and controller.step(2 * T, T) == OK
        assert controller.get("input_ok", "input_faults") == [1.0, 1.0]
        np.testing.assert_allclose(
            controller.group("a"), feedback(np.array(s), np.array(v), BEST_FIXED, PlatoonParameters()), atol=1e-12
        )


def test_under_policy_1_a_spacing_of_L_is_refused_as_a_spacing(instances, controller_fmu):
    s, v = random_start(8)
    s[2] = L - 1e-12
    controller = instances(controller_fmu)
    assert controller.initialise(FIXED | named(s, v)) == OK and controller.step(0.0, T) == ERROR
    assert "the measured spacing s[4] = 4.99999999999" in controller.messages[-1][1]


def test_a_spacing_that_lemma_1_does_not_cover_is_named_with_the_spacing_it_needs(instances, controller_fmu):
    s, v = random_start(8)
    s[2] = 5.3
    controller = instances(controller_fmu)
    assert controller.initialise(FIXED | named(s, v)) == OK and controller.step(0.0, T) == ERROR
    sentence = controller.messages[-1][1]
    assert "s[4] = 5.3 m" in sentence and "keep that spacing above 5.35 m" in sentence and "T < 0.008571" in sentence


@pytest.mark.parametrize("shape", [V_OLD, BEST_FIXED])
def test_without_a_desired_speed_nothing_has_changed(shape):
    s, v = map(np.array, random_start(5))
    controller = SampledController.begin(
        ControllerSettings(N, request=Request(old=shape is V_OLD, source=ParameterSource.FIXED))
    )
    controller.sample(0.0, Measurement(s, v, N))
    assert controller.now.a.tolist() == feedback(s, v, shape, PlatoonParameters()).tolist()


def test_the_plant_fmu_starts_at_standstill_and_names_who_is_not_behind(instances, plant_fmu):
    plant = instances(plant_fmu)
    assert plant.initialise({f"v_start[{i}]": 0.0 for i in range(1, N + 1)} | {"s_start[3]": 5.0 - 1e-12}) == OK
    before = plant.outputs()
    assert plant.set({f"a[{i}]": -2.0 for i in range(1, N + 1)}) == OK
    for k in range(100):
        assert plant.step(k * T, T) == OK
    assert plant.outputs() == before
    assert plant.call("fmi2Reset") == OK and plant.initialise({"s_start[3]": -1.0}) == ERROR
    assert "spacing s[3] = -1 m" in plant.messages[-1][1] and "lower L" not in plant.messages[-1][1]


def test_a_platoon_refuses_a_start_with_the_remedy_that_fits():
    for s, v, part, does_not in [
        ([9.0], [30.0, -1e-9], "vehicle 2 at 0 m/s or more", "v_max,"),
        ([9.0], [36.0, 30.0], "no faster than v_max, or raise v_max", "0 m/s or more"),
        ([-1.0], [30.0, 30.0], "vehicle 2 behind vehicle 1", "lower L"),
    ]:
        with pytest.raises(ValueError, match=part) as caught:
            validate(PlatoonState(np.array(s), np.array(v)))
        assert does_not not in str(caught.value)
