"""The plant FMU: closed forms, other plants, any communication step, both runtimes, and what it refuses."""

from __future__ import annotations

from fractions import Fraction
from math import exp

import numpy as np
import pytest

from harness import ERROR, OK, Instance, random_start, starts
from lives import life
from masters import MASTERS, steps_of
from psp_model import Actuation, DelayedVehicles, IdealPlant, PlatoonState
from psp_model.vehicles.actuation import Foreign

T, N = 0.01, 7
DELAYED = {"actuation_delay": 0.237} | {f"actuator_lag[{i}]": 0.05 * i for i in range(1, N + 1)}
LIMITS = {f"a_min[{i}]": -4.0 - 0.5 * i for i in range(1, N + 1)} | {f"a_max[{i}]": 3.0 for i in range(1, N + 1)}
LENGTHS = {"length[1]": 16.5, "length[3]": 4.0}


def each(name: str, values) -> dict[str, float]:
    return {f"{name}[{i}]": float(value) for i, value in enumerate(values, start=1)}


@pytest.mark.parametrize("steps", [[1], [0.25], [3.7]], ids=str)
def test_a_constant_command_has_its_closed_form(instances, plant_fmu, steps):
    """Dead time 0.237 s is no multiple of T; vehicle i has a lag of i / 20 s, and a limit that cuts the last ones."""
    s, v = random_start(1)
    v = [speed + 20.0 for speed in v]
    plant, delay, wanted = instances(plant_fmu), 0.237, np.linspace(-8.0, 6.0, N)
    given = np.clip(wanted, [LIMITS[f"a_min[{i}]"] for i in range(1, N + 1)], 3.0)
    assert plant.initialise(starts(s, v) | {"x_start": 7.0} | DELAYED | LIMITS | each("a", wanted)) == OK
    x = 7.0 - np.cumsum([0.0, *s])
    size, time = steps[0] * T, 0.0
    for _ in range(round(2.0 / size)):
        assert plant.step(time, size) == OK
        time += size
        seen = np.floor(time / T + 1e-6) * T
        for i in range(N):
            since, lag = max(seen - delay, 0.0), 0.05 * (i + 1)
            gone = lag * (1.0 - exp(-since / lag))
            speed = v[i] + given[i] * (since - gone)
            moved = v[i] * seen + given[i] * (0.5 * since**2 - lag * (since - gone))
            found = plant.get(f"v[{i + 1}]", f"x[{i + 1}]", f"acceleration[{i + 1}]")
            assert found == pytest.approx([speed, x[i] + moved, given[i] * gone / lag], rel=1e-12, abs=1e-10)


def driven(instance, rng, periods: int, foreign: bool):
    """Accelerations, who drives himself, and all outputs, period by period."""
    for k in range(periods):
        a, automated = rng.normal(0.0, 5.0, N), np.ones(N)
        if foreign:
            automated[rng.integers(N)] = automated[0] = 0.0
        assert instance.set(each("a", a) | each("automated", automated)) == OK
        assert instance.step(k * T, T) == OK
        yield a, automated


@pytest.mark.parametrize("foreign", [False, True])
def test_it_is_the_delayed_vehicles_of_the_model(instances, plant_fmu, foreign):
    rng, (s, v) = np.random.default_rng(4), random_start(4)
    v = [speed - 26.9 for speed in v]  # they come to a stop, and drive off
    lag = np.array([DELAYED[f"actuator_lag[{i}]"] for i in range(1, N + 1)])
    actuation = Actuation(0.237, lag, np.array([LIMITS[f"a_min[{i}]"] for i in range(1, N + 1)]), 3.0)
    vehicles = DelayedVehicles(actuation)
    expected, plant, stood = vehicles.begin(0.0, np.array(s), np.array(v)), instances(plant_fmu), 0
    assert plant.initialise(starts(s, v) | DELAYED | LIMITS) == OK
    for a, automated in driven(plant, rng, 300, foreign):
        expected, _ = vehicles.advance(expected, a * automated, T, Foreign(automated, a))
        np.testing.assert_allclose(plant.group("v"), expected.v, rtol=0, atol=1e-11)
        np.testing.assert_allclose(plant.group("s"), expected.s, rtol=0, atol=1e-11)
        assert plant.get("x[1]")[0] == pytest.approx(expected.x, rel=0, abs=1e-11)
        seen = np.where(expected.v > 0.0, expected.actuators.a, np.maximum(expected.actuators.a, 0.0))
        np.testing.assert_allclose(plant.group("acceleration"), seen, rtol=0, atol=1e-11)
        stood += int((expected.v == 0.0).sum())
    assert stood > 20


def test_with_the_start_values_the_numbers_are_those_of_ideal_vehicles_bit_for_bit(instances, plant_fmu):
    rng, (s, v) = np.random.default_rng(5), random_start(5)
    v = [speed - 26.9 for speed in v]
    ideal, plant = IdealPlant.begin(PlatoonState(s, v), T), instances(plant_fmu)
    assert plant.initialise(starts(s, v)) == OK
    for k, (a, _) in enumerate(driven(plant, rng, 400, False), start=1):
        ideal = ideal.advanced_to(k, a)
        assert plant.group("v") == ideal.now.v.tolist() and plant.group("s") == ideal.now.s.tolist()
        assert plant.group("x") == ideal.now.positions().tolist()
        standing = (ideal.now.v == 0.0) & (a < 0.0)
        assert plant.group("acceleration") == np.where(standing, 0.0, a).tolist()
        assert plant.group("clearance") == (ideal.now.s - 5.0).tolist()


def inputs_of(period: int) -> dict[str, float]:
    """What belongs to a period; some of it repeats."""
    rng = np.random.default_rng(period // 3)
    return each("a", rng.normal(0.0, 4.0, N)) | each("automated", rng.random(N) > 0.3)


@pytest.mark.parametrize("start", [0.0, 1.7e9])
def test_any_communication_step_gives_the_same_bits_at_the_instants(instances, plant_fmu, start):
    values = starts(*random_start(6)) | DELAYED | LIMITS | LENGTHS
    length = Fraction(1, 100)

    def run(told) -> dict[Fraction, list[float]]:
        plant, seen = instances(plant_fmu), {}
        assert plant.initialise(values, start) == OK
        for begin, size, end in told:
            assert plant.set(inputs_of(-(-end // length))) == OK
            assert plant.step(begin, size) == OK
            if (end / length).denominator == 1:
                seen[end / length] = plant.outputs()
        return seen

    expected = run(steps_of(MASTERS["k h"], start, [length], 90))
    for master in MASTERS.values():
        for pattern in ("1/4", "1/2 1/3 1/6", "3/7 4/7"):
            parts = [Fraction(part) * length for part in pattern.split()]
            seen = run([told for told in steps_of(master, start, parts, 300) if told.end <= 90 * length])
            assert len(seen) >= 70
            assert all(row == expected[k] for k, row in seen.items())


def test_a_step_over_many_periods_is_as_many_steps(instances, plant_fmu):
    values = starts(*random_start(7)) | DELAYED | LIMITS | each("a", np.linspace(-3.0, 3.0, N)) | {"automated[1]": 0.0}
    one, many = instances(plant_fmu), instances(plant_fmu)
    assert one.initialise(values) == many.initialise(values) == OK
    for k in range(60):
        assert many.step(k * T, T) == OK
    assert one.step(0.0, 60 * T) == OK
    assert one.outputs() == many.outputs()


def test_a_vehicle_that_drives_itself_has_its_acceleration_at_once_whatever_its_limits(instances, plant_fmu):
    plant = instances(plant_fmu)
    assert plant.initialise(starts([20.0] * 6, [20.0] * 7) | DELAYED | LIMITS | {"automated[1]": 0.0}) == OK
    assert plant.set(each("a", [-9.0] * N)) == OK
    for k in range(10):
        assert plant.step(k * T, T) == OK
    assert plant.get("v[1]", "acceleration[1]") == pytest.approx([20.0 - 0.9, -9.0], rel=1e-12)
    assert plant.group("v")[1:] == [20.0] * 6 and plant.group("acceleration")[1:] == [0.0] * 6
    assert plant.set({"automated[1]": 1.0}) == OK  # its actuator begins with what it has
    assert plant.step(10 * T, T) == OK
    assert plant.get("acceleration[1]")[0] == pytest.approx(-9.0 * exp(-T / 0.05), rel=1e-12)


def test_clearances_go_by_the_length_of_the_vehicle_ahead(instances, plant_fmu):
    plant = instances(plant_fmu)
    assert plant.initialise(starts([20.0, 21.0, 22.0, 23.0, 24.0, 4.0], [20.0] * 7) | LENGTHS) == OK
    assert plant.group("clearance") == [3.5, 16.0, 18.0, 18.0, 19.0, -1.0]
    assert plant.step(0.0, T) == OK and plant.group("clearance") == [3.5, 16.0, 18.0, 18.0, 19.0, -1.0]


def settings(rng) -> dict[str, float]:
    """Parameters at random: ideal vehicles, some that have dead time or lag or limits only, or everything."""
    values = starts(rng.uniform(1.0, 20.0, N - 1), rng.uniform(0.0, 3.0, N)) | {"x_start": rng.normal(0.0, 100.0)}
    values["actuation_delay"] = float(rng.choice([0.0, 0.01, 0.05, rng.uniform(0.0, 0.6)]))
    kind = rng.integers(4)
    if kind in (1, 3):
        values |= each("actuator_lag", rng.choice([0.0, 0.05, 0.4, 3.0], N))
    if kind in (2, 3):
        values |= each("a_min", rng.choice([-1000.0, -5.0, -2.0], N)) | each("a_max", rng.choice([1000.0, 3.0], N))
    return values | each("length", rng.uniform(1.0, 20.0, N))


def inputs(rng) -> dict[str, float]:
    a = rng.normal(0.0, float(rng.choice([0.1, 3.0, 100.0])), N) * (rng.random(N) < 0.8)
    given = each("a", a) | each("automated", rng.random(N) < rng.choice([0.5, 1.0]))
    if rng.random() < 0.03:
        given[str(rng.choice(list(given)))] = float(rng.choice([np.nan, np.inf, -np.inf]))
    return given


@pytest.mark.parametrize("start_time", [0.0, -7.25])
def test_random_lives_are_the_same(python_plant_fmu, native_plant_fmu, start_time):
    seen = list[int]()
    for seed in range(25):
        one, other = (life(fmu, seed, settings, inputs, start_time) for fmu in (python_plant_fmu, native_plant_fmu))
        assert other.statuses == one.statuses and other.messages == one.messages
        np.testing.assert_allclose(other.rows, one.rows, rtol=1e-12, atol=1e-12)
        seen += one.statuses
    assert min(seen.count(status) for status in (OK, ERROR)) > 10


def test_without_lag_the_runtimes_agree_bit_for_bit(python_plant_fmu, native_plant_fmu):
    def sharp(rng) -> dict[str, float]:
        return settings(rng) | each("actuator_lag", [0.0] * N)

    for seed in range(10):
        one, other = (life(fmu, seed, sharp, inputs) for fmu in (python_plant_fmu, native_plant_fmu))
        assert other.rows.tolist() == one.rows.tolist() and len(one.rows) > 20


BAD = [
    *({name: value} for name in ("T", "x_start", "s_start[3]", "v_start[2]") for value in (np.nan, np.inf)),
    *({name: np.nan} for name in ("actuation_delay", "actuator_lag[4]", "length[7]")),
    *({name: -0.1} for name in ("T", "v_start[2]", "actuation_delay", "actuator_lag[1]", "length[2]", "s_start[7]")),
    *({"length[2]": 0.0}, {"s_start[2]": 0.0}, {"T": 0.0}),
    *({"a_min[3]": value} for value in (0.0, 1.0, np.nan)),
    *({"a_max[3]": value} for value in (0.0, -1.0, np.nan)),
    *({"actuation_delay": 5.2}, {"actuation_delay": 0.01, "T": 1e-6}, {"actuation_delay": 1.0, "T": 5e-324}),
]


def test_bad_values_are_refused_in_the_same_words(python_plant_fmu, native_plant_fmu):
    said = []
    for fmu in (python_plant_fmu, native_plant_fmu):
        instance = Instance(fmu)
        for values in BAD:
            assert instance.initialise(values) == ERROR, values
            name, sentence = next(iter(values)), instance.messages[-1][1]
            assert name.replace("_start", "") in sentence.replace("_start", "")
            assert instance.call("fmi2Reset") == OK
        said.append(instance.messages)
        instance.close()
    assert said[1] == said[0] and len(said[0]) == len(BAD)
    assert "510 periods of T = 0.01 s" in said[0][-3][1]


def test_a_bad_input_is_refused_and_a_good_one_goes_on_after_a_reset(instances, plant_fmu):
    plant = instances(plant_fmu)
    for name in ("a[3]", "automated[3]"):
        assert plant.initialise() == OK and plant.set({name: np.nan}) == OK and plant.step(0.0, T) == ERROR
        assert f"{name} must be a finite number" in plant.messages[-1][1]
        assert plant.call("fmi2Reset") == OK
    assert plant.initialise({"actuation_delay": 5.1}) == OK  # as many periods as are remembered
    for k in range(600):
        assert plant.set({"a[2]": float(k % 5)}) == OK
        assert plant.step(k * T, T) == OK


def test_the_variables_are_the_same(python_plant_fmu, native_plant_fmu):
    def rows(fmu):
        return [
            (v.name, v.valueReference, v.type, v.causality, v.variability, v.initial, v.start, v.unit, v.min, v.max)
            for v in fmu.description.modelVariables
        ]

    assert rows(native_plant_fmu) == rows(python_plant_fmu)
