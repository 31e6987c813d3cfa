"""PspPlatoon with the extended law: both runtimes agree in random lives, and it does what the law promises."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from harness import ERROR, OK, WARNING, Instance, Unpacked, random_start, starts
from joiners import INSTANT, ask, look, random_request
from psp_model import BEST_FIXED, Cooperation, DrivenLeader, ExtendedLaw, PlatoonState, Wave, simulate
from psp_model.sampling.exact import exact_period
from psp_model.vehicles.braking import Braking, brake_margin

L, V_MAX, T, N = 5.0, 35.0, 0.01, 7
LENGTHS = [f"length[{i}]" for i in range(1, N + 1)]


@pytest.fixture(params=["python", "native"])
def fmu(request: pytest.FixtureRequest) -> Unpacked:
    """Each of the two runtimes in turn."""
    return request.getfixturevalue(f"{request.param}_fmu")


def perhaps(rng: np.random.Generator, low: float, high: float) -> float:
    return float(rng.uniform(low, high)) if rng.random() < 0.6 else 0.0


def random_values(rng: np.random.Generator) -> dict[str, float]:
    """Parameters of the extended law, and a start in which no vehicles touch."""
    lengths = np.where(rng.random(N) < 0.5, rng.uniform(3, 14, N), 0.0)
    ahead = np.where(lengths > 0.0, lengths, L)[:-1]
    far = rng.random() < 0.3
    s = ahead + (rng.uniform(20, 45, N - 1) if far else rng.uniform(2.5, 9, N - 1))
    values = starts(s.tolist(), rng.uniform(25, 32, N).tolist())
    values |= dict(zip(LENGTHS, lengths.tolist(), strict=True))
    values |= {
        "kappa": perhaps(rng, 0.1, 1.5),
        "kappa_reach": float(rng.uniform(12, 35)),
        "closing_speed": perhaps(rng, 0.1, 1.0),
        "closing_spacing": float(rng.uniform(10, 20)),
        "certificate": int(rng.integers(1, 3)),
        "join_brake_margin": perhaps(rng, 0.5, 8.0),
        "join_a_min": float(rng.uniform(-9, -4)),
        "potential": int(rng.integers(1, 3)),
        "parameter_source": 2,
        "lemma1_policy": int(rng.choice([2, 3, 3])),
        "max_short_periods": 200,
        "T": float(rng.choice([0.01, 0.02, 0.1])),
        "n_start": int(rng.integers(2, N + 1)),
    }
    return values | random_leader(rng)


def random_leader(rng: np.random.Generator) -> dict[str, float]:
    """What is told of the leader."""
    flag = float(rng.random() < 0.3)
    return {
        "leader_automated": flag,
        "leader_speed": float(rng.choice([0.0, V_MAX, rng.uniform(20, 33)], p=[0.1, 0.1, 0.8])),
        "leader_acceleration": float(rng.normal(0, 1)),
    }


@dataclass(frozen=True)
class Asked:
    """What a host does at a communication point."""

    request: dict[str, float]
    length: float
    leader: dict[str, float] | None
    size: float
    saves: str


def random_asked(rng: np.random.Generator, road: Instance) -> Asked:
    request = random_request(rng, look(road), N) if rng.random() < 0.25 else {}
    length = float(rng.choice([0.0, rng.uniform(3, 15), np.nan, -1.0], p=[0.3, 0.66, 0.02, 0.02]))
    leader = random_leader(rng) if rng.random() < 0.4 else None
    size = float(rng.choice([INSTANT, T / 3, T, 0.02, 0.1, 0.37]))
    saves = str(rng.choice(["", "set", "bytes"], p=[0.8, 0.1, 0.1]))
    return Asked(request, length, leader, size, saves)


def life(fmu: Unpacked, values: dict[str, float], todo: Callable[[Instance, int], Asked]) -> tuple[Any, Any]:
    """Statuses and all outputs of a life, and what was said."""
    road, time = Instance(fmu), 0.0
    seen = [[float(road.initialise(values)), *road.outputs()]]
    for k in range(60):
        if seen[-1][0] > WARNING:
            break
        asked = todo(road, k)
        ask(road, asked.request)
        road.set({"insert_length": asked.length} | (asked.leader or {}))
        if asked.saves:
            state = road.slave.getFMUstate()
            if asked.saves == "bytes":
                data = road.slave.serializeFMUstate(state)
                road.slave.freeFMUstate(state)
                state = road.slave.deSerializeFMUstate(data)
            road.slave.setFMUstate(state)
            road.slave.freeFMUstate(state)
        seen.append([float(road.step(time, asked.size)), *road.outputs()])
        time += asked.size
    messages = road.messages
    road.close()
    return np.array(seen), messages


@pytest.mark.parametrize("seed", range(40))
def test_random_lives_are_the_same(python_fmu: Unpacked, native_fmu: Unpacked, seed: int) -> None:
    rng, done = np.random.default_rng(seed), []
    values = random_values(rng)

    def first(road: Instance, k: int) -> Asked:
        done.append(random_asked(rng, road))
        return done[-1]

    reference, sentences = life(python_fmu, values, first)
    seen, said = life(native_fmu, values, lambda road, k: done[k])
    assert said == sentences
    np.testing.assert_allclose(seen, reference, rtol=1e-9, atol=1e-9)


def test_what_random_lives_come_to(python_fmu: Unpacked) -> None:
    """They are no use if the interesting things do not happen."""
    words, joined = "", 0.0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        values = random_values(rng)
        seen, said = life(python_fmu, values, lambda road, k, rng=rng: random_asked(rng, road))
        words += " ".join(text for _, text in said)
        joined += seen[-1][-2]  # changes
    assert joined > 50
    for part in ("brake margin", "T_exact", "length", "Lemma 1"):
        assert part in words, part


def test_it_is_the_model_s_law(fmu: Unpacked) -> None:
    law = Cooperation(kappa=0.8, closing_speed=0.5, length=np.array([5.0, 12.0, 5.0, 4.0, 16.5, 5.0, 5.0]))
    s, v = np.array([15.0, 22.0, 30.0, 12.0, 28.0, 15.0]), np.full(N, 29.0)
    values = starts(s.tolist(), v.tolist()) | dict(zip(LENGTHS, law.length.tolist(), strict=True))  # type: ignore[union-attr]
    values |= {"kappa": 0.8, "closing_speed": 0.5, "parameter_source": 2}
    road = Instance(fmu)
    assert road.initialise(values) == OK
    for k in range(500):
        assert road.step(k * T, T) == OK
    run = simulate(
        PlatoonState(s, v), BEST_FIXED, duration=5.0, controller=lambda one, other: ExtendedLaw(one, other, law)
    )
    np.testing.assert_allclose(road.group("s"), run.s[-1], rtol=0, atol=1e-9)
    np.testing.assert_allclose(road.group("v"), run.v[-1], rtol=0, atol=1e-9)
    np.testing.assert_allclose(road.get("T_max", "J"), [run.T_max[-1], run.J], rtol=1e-9)
    road.close()


def test_vehicles_close_up(fmu: Unpacked) -> None:
    rng = np.random.default_rng(1)
    values = starts(rng.uniform(38, 48, N - 1).tolist(), [27.0] * N) | {"v_star": 27.0, "parameter_source": 2}
    road = Instance(fmu)
    assert road.initialise(values | {"closing_speed": 0.6}) == OK
    largest, smallest = 0.0, np.inf
    for k in range(600):
        assert road.step(k * 0.1, 0.1) == OK
        largest = max(largest, *np.abs(road.group("a")).tolist())
        smallest = min(smallest, *road.group("s"))
    assert max(road.group("s")) <= 20.0 and largest <= 1.5 and smallest > 14.0
    road.close()


@pytest.mark.parametrize(("policy", "size", "certificate"), [(1, T, 1), (3, T, 1), (1, T / 4, 2), (3, T / 3, 2)])
def test_a_leader_that_drives_itself_follows_its_profile(
    fmu: Unpacked, policy: int, size: float, certificate: int
) -> None:
    wave = Wave(30.0, 14.0, 2.0, 40.0)

    def told(time: float) -> dict[str, float]:
        now, then = wave.speed(time), wave.speed(time + T)
        return {"leader_speed": now, "leader_acceleration": (then - now) / T}

    road, steps = Instance(fmu), round(T / size)
    values = starts(*random_start(4)) | {"leader_automated": 0.0, "kappa": 1.0, "parameter_source": 2}
    values |= {"v_start[1]": wave.speed(0.0), "lemma1_policy": policy, "certificate": certificate}
    assert road.initialise(values | told(0.0)) == OK
    x, worst = 0.0, 0.0
    for k in range(3000):
        assert road.set(told(k * T)) == OK
        for part in range(steps):
            assert road.step(k * T + part * size, size) == OK
        x += 0.5 * T * (wave.speed(k * T) + wave.speed((k + 1) * T))
        seen = road.get("v[1]", "x[1]")
        worst = max(worst, abs(seen[0] - wave.speed((k + 1) * T)), abs(seen[1] - x))
    assert worst < 1e-9
    assert min(road.group("s")) > L and road.get("lemma1_violations") == [0.0]
    road.close()


def test_a_leader_takes_over_at_once_and_gives_back(fmu: Unpacked) -> None:
    road = Instance(fmu)
    alone = {"v_start[1]": 30.0, "parameter_source": 2, "n_start": 1}
    assert road.initialise(starts(*random_start(5)) | alone) == OK
    assert road.step(0.0, T) == OK
    (before,) = road.get("v[1]")
    road.set({"leader_automated": 0.0, "leader_speed": before, "leader_acceleration": -1.0})
    assert road.step(T, T) == OK
    np.testing.assert_allclose(road.get("v[1]"), before - T, atol=1e-12)
    road.set({"leader_speed": 0.0, "leader_acceleration": -1e6})  # what [0, v_max] allows for a period
    for k in range(2, 5):
        assert road.step(k * T, T) <= WARNING
        assert abs(road.get("v[1]")[0]) < 1e-12
    road.set({"leader_speed": V_MAX, "leader_acceleration": 1e6})
    assert road.step(5 * T, T) <= WARNING
    np.testing.assert_allclose(road.get("v[1]"), V_MAX, atol=1e-12)
    road.close()


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"leader_automated": np.nan}, "leader_automated must be a finite number"),
        ({"leader_automated": 0.0, "leader_speed": np.inf}, "leader_speed must be a finite number"),
        ({"leader_automated": 0.0, "leader_speed": -0.1}, "leader_speed = -0.1 m/s must lie in [0, 35] m/s"),
        ({"leader_automated": 0.0, "leader_speed": 35.1}, "leader_speed = 35.1 m/s must lie in [0, 35] m/s"),
        ({"leader_automated": 0.0, "leader_acceleration": np.nan}, "leader_acceleration must be a finite number"),
    ],
)
def test_what_is_told_of_the_leader_is_checked(fmu: Unpacked, values: dict[str, float], sentence: str) -> None:
    road = Instance(fmu)
    assert road.initialise(values) == ERROR and sentence in road.messages[-1][1]
    road.close()
    road = Instance(fmu)
    assert road.initialise() == OK and road.set(values) == OK
    assert road.step(0.0, T) == ERROR and sentence in road.messages[-1][1]
    road.close()


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"kappa": -0.1}, "kappa = -0.1 1/s must not be negative"),
        ({"kappa": 1.0, "kappa_reach": 5.0}, "kappa_reach = 5 m must exceed L = 5 m"),
        ({"closing_speed": np.nan}, "closing_speed must be a finite number"),
        ({"closing_speed": -1.0}, "closing_speed = -1 m/s must not be negative"),
        ({"closing_spacing": 30.0, "closing_reach": 30.0}, "closing_reach = 30 m must exceed closing_spacing = 30 m"),
        ({"length[2]": -4.0}, "length[2] = -4 m must be positive"),
        ({"length[3]": np.inf}, "length[3] must be a finite number"),
        ({"length[1]": 10.0}, "spacing s[2] = 10 m must exceed the length of vehicle 1, 10 m"),
        ({"certificate": 3}, "certificate = 3 must lie in 1 to 2"),
        ({"join_brake_margin": 12.5}, "join_brake_margin = 12.5 m/s2 must lie in [0, 12] m/s2"),
        ({"join_brake_margin": np.nan}, "join_brake_margin must be a finite number"),
        ({"join_a_min": 0.0}, "join_a_min = 0 m/s2 must be negative"),
    ],
)
def test_every_bad_parameter_is_refused(fmu: Unpacked, values: dict[str, float], sentence: str) -> None:
    road = Instance(fmu)
    assert road.initialise(values) == ERROR
    assert sentence in road.messages[-1][1]
    road.close()


def test_lengths_below_L_allow_starts_below_L(fmu: Unpacked) -> None:
    road = Instance(fmu)
    values = {name: 4.0 for name in LENGTHS} | {f"s_start[{i}]": 4.8 for i in range(2, N + 1)}
    assert road.initialise(values | {"parameter_source": 2}) == OK
    np.testing.assert_allclose(road.get("T_max"), (4.8 - 4.0) / V_MAX, rtol=1e-12)
    road.close()


def test_the_exact_period_is_that_of_the_state(fmu: Unpacked) -> None:
    road = Instance(fmu)
    assert road.initialise(starts(*random_start(6)) | {"parameter_source": 2}) == OK
    for k in range(20):
        s, v, a = (np.array(road.group(name)) for name in ("s", "v", "a"))
        (found,) = road.get("T_exact")
        constants = PlatoonState(s, v).constants
        np.testing.assert_allclose(found, min(float(exact_period(s, v, a, constants)), 1e9), rtol=1e-12)
        assert road.get("T_exact", "T_max")[0] >= road.get("T_max")[0]
        assert road.step(k * T, T) == OK
    road.close()


def test_policy_goes_by_the_certificate(fmu: Unpacked) -> None:
    """At 4 Hz the exact period certifies a run that Lemma 1 does not; policy 3 then cuts fewer periods."""
    values = starts(*random_start(7)) | {"T": 0.25, "parameter_source": 2}
    refused = Instance(fmu)
    assert refused.initialise(values) == ERROR and "Lemma 1" in refused.messages[-1][1]
    refused.close()
    road = Instance(fmu)
    assert road.initialise(values | {"certificate": 2}) == OK
    assert road.get("certified", "lemma1_ok") == [1.0, 0.0]
    road.close()
    ends = []
    for certificate in (1, 2):
        road = Instance(fmu)
        assert road.initialise(values | {"certificate": certificate, "lemma1_policy": 3}) == OK
        for k in range(40):
            assert road.step(k * 0.25, 0.25) == OK
            assert min(road.group("s")) > L and min(road.group("v")) >= 0.0 and max(road.group("v")) <= V_MAX
        ends.append(road.get("lemma1_violations")[0])
        road.close()
    assert ends[1] < ends[0]


def test_a_touch_within_the_period_is_told(fmu: Unpacked) -> None:
    values = starts([5.2, *[12.0] * (N - 2)], [0.0, *[30.0] * (N - 1)])
    road = Instance(fmu)
    assert road.initialise(values | {"T": 0.1, "certificate": 2, "parameter_source": 2}) == ERROR
    assert "as vehicle 2 would close its spacing s[2] = 5.2 m to 5 m within T" in road.messages[-1][1]
    road.close()
    road = Instance(fmu)
    values |= {"T": 0.1, "certificate": 2, "parameter_source": 2, "length[1]": 5.1}
    assert road.initialise(values) == ERROR and "s[2] = 5.2 m to 5.1 m within T" in road.messages[-1][1]
    road.close()


def joins(road: Instance, time: float, values: dict[str, float]) -> list[float]:
    """A vehicle that wants to join; what became of it."""
    base = {"insert": 1.0, "insert_behind": 7.0, "insert_speed": 30.0}
    ask(road, base | {name: value for name, value in values.items() if name != "insert_length"})
    road.set({"insert_length": values.get("insert_length", 0.0)})
    assert road.step(time, INSTANT) <= WARNING
    ask(road, {})
    assert road.step(time + INSTANT, INSTANT) <= WARNING
    return road.get("change_ok", "gap_offered")


def test_joining_asks_for_a_brake_margin(fmu: Unpacked) -> None:
    road = Instance(fmu)
    start = {f"s_start[{i}]": 25.0 for i in range(2, N + 1)} | {f"v_start[{i}]": 30.0 for i in range(1, N + 1)}
    start |= {"n_start": 6, "join_brake_margin": 6.0, "join_a_min": -6.5, "parameter_source": 2}
    assert road.initialise(start) == OK
    behind = {"insert_behind": 6.0, "insert_speed": 33.0}
    ok, offered = joins(road, 0.0, behind | {"insert_gap": 12.0})
    assert ok == 0.0 and offered > 12.0
    assert "the brake margin would be below join_brake_margin = 6 m/s2: a spacing of" in road.messages[-1][1]
    ok, _ = joins(road, 2 * INSTANT, behind | {"insert_gap": offered})
    assert ok == 1.0
    s, v = np.array(road.group("s")), np.array(road.group("v"))
    margin = brake_margin(s - L, Braking(v, np.array(road.group("a")), 0.0, 0.0, -6.5))
    assert margin >= 6.0 - 1e-6
    road.close()
    road = Instance(fmu)  # nothing would do: too fast for any spacing that is looked at
    assert road.initialise(start | {"join_brake_margin": 11.9, "join_a_min": -0.5}) == OK
    assert joins(road, 0.0, behind | {"insert_gap": 12.0}) == [0.0, 0.0]
    assert "no spacing would be accepted there now" in road.messages[-1][1]
    road.close()


def test_a_vehicle_that_joins_has_its_length(fmu: Unpacked) -> None:
    road = Instance(fmu)
    start = {f"s_start[{i}]": 30.0 for i in range(2, N + 1)} | {f"v_start[{i}]": 30.0 for i in range(1, N + 1)}
    assert road.initialise(start | {"n_start": 6, "parameter_source": 2}) == OK
    for bad in (np.nan, -1.0, np.inf):
        assert joins(road, 0.0, {"insert_behind": 2.0, "insert_gap": 12.0, "insert_length": bad})[0] == 0.0
        assert "the joining vehicle's length" in road.messages[-1][1]
        break  # time goes on
    ok, offered = joins(road, 2 * INSTANT, {"insert_behind": 2.0, "insert_gap": 12.0, "insert_length": 17.9})
    assert ok == 0.0 and 5.0 < offered < 12.0  # 18 m are left behind it
    ok, _ = joins(road, 4 * INSTANT, {"insert_behind": 2.0, "insert_gap": 10.0, "insert_length": 12.0})
    assert ok == 1.0
    np.testing.assert_allclose(road.get("T_max"), min((10.0 - 5.0), (20.0 - 12.0)) / V_MAX, rtol=1e-6)
    ask(road, {"remove": 1.0, "remove_place": 3.0})
    assert road.step(6 * INSTANT, INSTANT) == OK
    np.testing.assert_allclose(road.get("T_max", "n_active"), [(30.0 - 5.0) / V_MAX, 6.0], rtol=1e-6)
    road.close()


def test_closing_up_remembers_who_joined_and_left(fmu: Unpacked) -> None:
    """What closing up adds is engaged in time: a join in front of vehicles leaves theirs as it was."""
    road = Instance(fmu)
    start = {f"s_start[{i}]": 40.0 for i in range(2, N + 1)} | {f"v_start[{i}]": 27.0 for i in range(1, N + 1)}
    start |= {"v_star": 27.0, "n_start": 5, "closing_speed": 0.6, "parameter_source": 2}
    assert road.initialise(start) == OK
    for k in range(300):
        assert road.step(k * T, T) == OK
    before = road.group("a")
    ok, _ = joins(road, 3.0, {"insert_behind": 0.0, "insert_gap": 40.0, "insert_speed": 27.0})
    assert ok == 1.0
    after = road.group("a")
    np.testing.assert_allclose(after[1:6], before[:5], atol=1e-4)
    assert abs(after[0]) < 1e-4
    ask(road, {"remove": 1.0, "remove_place": 1.0})
    assert road.step(3.0 + 2 * INSTANT, INSTANT) == OK
    np.testing.assert_allclose(road.group("a")[:5], before[:5], atol=1e-4)
    road.close()


@pytest.mark.parametrize("automated", [1.0, 0.0])
def test_a_driven_leader_s_own_speed_bounds_do_not_count(fmu: Unpacked, automated: float) -> None:
    values = starts([20.0] * (N - 1), [0.001, *[20.0] * (N - 1)])
    road = Instance(fmu)
    told = {"leader_automated": automated, "leader_speed": 0.001, "leader_acceleration": -0.05}
    assert road.initialise(values | told | {"lemma1_policy": 2, "parameter_source": 2}) <= WARNING
    s, v, a = (np.array(road.group(name)) for name in ("s", "v", "a"))
    law = ExtendedLaw(BEST_FIXED, PlatoonState(s, v).constants, leader=DrivenLeader(0.001, -0.05))
    _, expected = law.decide(None, s, v)
    if automated == 0.0:
        np.testing.assert_allclose(a, expected, rtol=1e-9)
        assert 0.001 / -a[0] < road.get("T_max")[0]
    road.close()
