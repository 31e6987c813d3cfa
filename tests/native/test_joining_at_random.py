"""Thousands of random joins and leaves: nobody leaves the state space, nothing is lost, a replay is identical, and both
runtimes agree in every number and every word."""

from __future__ import annotations

import numpy as np
import pytest

from harness import OK, WARNING, Instance, random_start, starts
from joiners import INSTANT, V_MAX, L, Seen, T, ask, look, random_leave, random_request

SHORTEN = {"parameter_source": 2, "lemma1_policy": 3}


def in_the_state_space(seen: Seen) -> bool:
    inside = (seen.s > L).all() and (seen.v >= 0).all() and (seen.v <= V_MAX).all()
    return bool(inside and np.isfinite(seen.x).all() and np.isfinite(seen.a).all() and not seen.behind.any())


def expected(before: Seen, request: dict[str, float], joined: int) -> tuple[int, ...]:
    """Who is there once a request has been granted."""
    vehicles, place = before.vehicles, request.get("remove_place")
    if place is not None:
        return (*vehicles[: int(place) - 1], *vehicles[int(place) :])
    behind = int(request["insert_behind"])
    return (*vehicles[:behind], joined + 1, *vehicles[behind:])


def require_nothing_lost(before: Seen, after: Seen, request: dict[str, float], joined: int) -> None:
    """A change, or its refusal, an instant after it was asked for."""
    granted = after.report["change_ok"] == 1.0
    for name, more in (("changes", granted), ("refusals", not granted)):
        assert after.report[name] == before.report[name] + more
    assert after.vehicles == (expected(before, request, joined) if granted else before.vehicles)
    kept = [vehicle for vehicle in after.vehicles if vehicle in before.vehicles]
    now, was = ([seen.vehicles.index(vehicle) for vehicle in kept] for seen in (after, before))
    np.testing.assert_allclose(after.x[now], before.x[was], rtol=0, atol=V_MAX * INSTANT + 1e-8)  # nobody is moved
    np.testing.assert_allclose(after.v[now], before.v[was], rtol=0, atol=1e-2)
    most = INSTANT * ((after.a / 4) ** 2).sum() + INSTANT * after.s.sum() / 20  # J goes on, with twice its weights
    assert 0 <= after.report["J"] - before.report["J"] <= most + 1e-9
    if granted and "insert" in request:
        assert after.report["lemma1_ok"] == 1.0
        np.testing.assert_allclose(after.v[after.vehicles.index(joined + 1)], request["insert_speed"], atol=1e-2)
    if "insert" in request and after.n == before.n:
        return
    assert after.n == before.n + (1 if "insert" in request else -1) * granted


class Drive:
    """A platoon on its way, with its clock."""

    def __init__(self, road: Instance, rng: np.random.Generator):
        self.road, self.rng, self.time = road, rng, 0.0
        self.joined = 0  # vehicles there have been

    def step(self, size: float) -> Seen:
        assert self.road.step(self.time, size) <= WARNING
        self.time += size
        seen = look(self.road)
        assert in_the_state_space(seen)
        return seen

    def change(self, request: dict[str, float]) -> tuple[Seen, Seen]:
        """The platoon before and just after a request; the triggers are down again then."""
        before = look(self.road)
        ask(self.road, request)
        after = self.step(INSTANT)
        ask(self.road, {})
        return before, after

    def onwards(self) -> Seen:
        self.step(INSTANT)  # the platoon sees the triggers down
        return self.step(float(self.rng.choice([T / 3, T, 0.037, 0.3])))


def start(fmu, seed: int, values: dict[str, float]) -> Drive:
    road = Instance(fmu)
    s, v = random_start(seed, fmu.vehicles)
    assert road.initialise(starts(s, v) | {"n_start": 1 + seed % fmu.vehicles} | SHORTEN | values) == OK
    drive = Drive(road, np.random.default_rng(seed))
    drive.joined = 1 + seed % fmu.vehicles
    return drive


def try_the_spacing_that_was_offered(drive: Drive, state, request: dict[str, float], offered: float) -> None:
    """From the state before a refusal; the road is afterwards as it was."""
    refused, time = drive.road.slave.getFMUstate(), drive.time
    drive.road.slave.setFMUstate(state)
    drive.time -= INSTANT
    _, after = drive.change(request | {"insert_gap": offered})
    assert after.report["change_ok"] == 1.0
    drive.road.slave.setFMUstate(refused)
    drive.road.slave.freeFMUstate(refused)
    drive.time = time


def rounds(drive: Drive, count: int) -> list[list[float]]:
    """Requests and what became of them; all outputs after each."""
    capacity, outputs = drive.road.fmu.vehicles, []
    for _ in range(count):
        request = random_request(drive.rng, look(drive.road), capacity)
        state = drive.road.slave.getFMUstate()
        before, after = drive.change(request)
        require_nothing_lost(before, after, request, drive.joined)
        drive.joined += after.n > before.n
        if after.report["refusals"] > before.report["refusals"] and after.report["gap_offered"] > 0:
            try_the_spacing_that_was_offered(drive, state, request, after.report["gap_offered"])
        drive.road.slave.freeFMUstate(state)
        drive.onwards()
        outputs.append(drive.road.outputs())
    return outputs


@pytest.mark.parametrize("seed", range(12))
def test_nobody_leaves_the_state_space_and_nothing_is_lost(native_fmu_of_twelve, seed):
    values = {"potential": 1 + seed % 2, "parameter_source": 1 if seed % 4 == 3 else 2}
    drive = start(native_fmu_of_twelve, seed, values)
    place = [v.name for v in drive.road.fmu.description.modelVariables if v.causality == "output"].index("n_active")
    sizes = [row[place] for row in rounds(drive, 300)]
    assert min(sizes) < 7 and max(sizes) > 7
    assert len(drive.road.messages) >= look(drive.road).report["refusals"] > 10
    drive.road.close()


def test_the_python_fmu_holds_the_same(python_fmu):
    for seed in range(2):
        drive = start(python_fmu, seed, {"potential": 1 + seed % 2})
        rounds(drive, 60)
        drive.road.close()


def test_a_full_platoon_takes_nobody_and_the_last_vehicle_stays(native_fmu_of_twelve):
    drive = start(native_fmu_of_twelve, 11, {})
    request = {"insert": 1.0, "insert_behind": 12.0, "insert_gap": 30.0, "insert_speed": 30.0}
    _, after = drive.change(request)
    assert after.n == 12 and "the platoon is full (12 vehicles)" in drive.road.messages[-1][1]
    for n in range(11, 0, -1):
        drive.onwards()
        _, after = drive.change(random_leave(drive.rng, look(drive.road)))
        assert after.n == n
    drive.onwards()
    _, after = drive.change({"remove": 1.0, "remove_place": 1.0})
    assert after.n == 1 and "last vehicle" in drive.road.messages[-1][1]
    drive.road.close()


@pytest.mark.parametrize("seed", range(4))
def test_a_saved_state_has_the_identical_future_here_and_in_another_instance(native_fmu_of_twelve, seed):
    drive = start(native_fmu_of_twelve, seed, {"potential": 1 + seed % 2})
    rounds(drive, 30)
    state, time, joined = drive.road.slave.getFMUstate(), drive.time, drive.joined
    data = drive.road.slave.serializeFMUstate(state)
    other = Drive(Instance(native_fmu_of_twelve), drive.rng)
    other.road.slave.setFMUstate(other.road.slave.deSerializeFMUstate(data))
    futures = []
    for each in (drive, drive, other):
        if each is drive:
            drive.road.slave.setFMUstate(state)
        each.rng, each.time, each.joined = np.random.default_rng(1000 + seed), time, joined
        futures.append(rounds(each, 40))
    assert futures[0] == futures[1] == futures[2]
    drive.road.close()
    other.road.close()


CASES = [  # potential, parameter_source, lemma1_policy, rounds
    (1, 2, 3, 60),
    (2, 2, 3, 60),
    (2, 2, 2, 60),
    (1, 2, 2, 60),
    (2, 2, 1, 60),
    (1, 2, 1, 60),
    (2, 1, 3, 60),
    (2, 3, 3, 6),
]


def trajectory(fmu, values: dict[str, float], asked: list[tuple[dict[str, float], float]], rng=None):
    """Statuses and outputs after each request, and the messages; with a source of randomness the requests are made up
    and put into `asked`, else taken from there."""
    road, seen, time = Instance(fmu), [], 0.0
    assert road.initialise(values) <= WARNING
    for k in range(len(asked)):
        if rng is not None:
            request = random_request(rng, look(road), 7) if k % 3 else {}
            asked[k] = request, float(rng.choice([INSTANT, T / 3, T, 0.037, 0.2]))
        request, size = asked[k]
        ask(road, request)
        status = road.step(time, size)
        time += size
        seen.append([float(status), *road.outputs()])
        if status > WARNING:
            break
    messages = road.messages
    road.close()
    return np.array(seen), messages


@pytest.mark.parametrize(("potential", "source", "policy", "count"), CASES)
def test_both_runtimes_agree_in_every_number_and_word(python_fmu, native_fmu, potential, source, policy, count):
    values = {"potential": potential, "parameter_source": source, "lemma1_policy": policy, "rollout_horizon": 2.0}
    for seed in range(1 if source == 3 else 3):
        n_start = 7 if source != 2 else 1 + 3 * seed
        asked = [({}, 0.0)] * count
        begin = starts(*random_start(3 + seed)) | values | {"n_start": n_start}
        reference, sentences = trajectory(python_fmu, begin, asked, np.random.default_rng(seed))
        seen, said = trajectory(native_fmu, begin, asked)
        assert said == sentences
        np.testing.assert_allclose(seen, reference, rtol=0, atol=1e-12)
        assert any("join" in text or "leave" in text or "place" in text for _, text in said)


@pytest.mark.parametrize("seed", [2, 14, 23, 34])
def test_vehicles_that_policy_2_let_out_of_the_state_space_join_and_leave_alike(python_fmu, native_fmu, seed):
    rng = np.random.default_rng(seed)
    begin = starts(rng.uniform(6, 14, 6), rng.choice([0.0, 35.0, 30.0, 34.9], 7))
    begin |= {"T": 0.3, "lemma1_policy": 2, "n_start": 6}
    asked = [({}, 0.0)] * 20
    reference, sentences = trajectory(python_fmu, begin, asked, rng)
    seen, said = trajectory(native_fmu, begin, asked)
    assert said == sentences
    assert any("has fallen to L" in text for _, text in said)
    np.testing.assert_allclose(seen, reference, rtol=0, atol=1e-12)
