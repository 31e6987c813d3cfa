"""Random joins and leaves: nobody leaves the state space, nothing is lost, and a replay gives the identical future."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from psp_model import (
    BEST_FIXED,
    V_OLD,
    Lemma1Policy,
    ObjectiveWeights,
    PlatoonParameters,
    PlatoonState,
    SampledPlatoon,
    Sampling,
    StartDomain,
    feedback,
)
from psp_model.membership import OpenPlatoon

C = PlatoonParameters()
T, CAPACITY = 0.01, 12
SHORTEN = Sampling(T, Lemma1Policy.SHORTEN)


def open_platoon(seed: int, n: int, old: bool = False, sampling: Sampling = SHORTEN) -> OpenPlatoon:
    s, v = StartDomain().draw(np.random.default_rng(seed), n, 1)
    shape = V_OLD if old else BEST_FIXED
    platoon = SampledPlatoon.begin(PlatoonState(s[:, 0], v[:, 0], C), shape, ObjectiveWeights(), sampling)
    return OpenPlatoon.begin(platoon, CAPACITY, lambda s, v: shape)


def step(road: OpenPlatoon, rng: np.random.Generator, time: list[float]) -> OpenPlatoon:
    """Drive on for a while, then ask for a random change, often at the limits."""
    time[0] += rng.choice([0.0, 1.0, rng.uniform(0, 30), float(rng.integers(0, 20))])
    at = int(time[0]), time[0] % 1.0
    road.platoon.advance_to(*at)
    n = len(road.vehicles)
    before, seen = road.vehicles, road.platoon.observe(*at)
    if rng.random() < (0.65 if n < 9 else 0.5):
        place = int(rng.integers(0, n + 1))
        room = seen.s[place - 1] if 0 < place < n else 40.0
        spacing = rng.choice(
            [rng.uniform(C.L, max(room - C.L, C.L + 0.1)), C.L, C.L + T * C.v_max * 1.01, 0.5 * room, 30.0]
        )
        speed = rng.choice([0.0, C.v_max, C.v_star, rng.uniform(0, C.v_max), seen.v[min(place, n - 1)]])
        asked, refused = road.insert(place, spacing, speed, *at)
        road = asked
        joined = () if refused else (road.joined,)
        assert road.vehicles == (*before[:place], *joined, *before[place:])
        if refused and np.isfinite(refused.spacing):
            assert road.insert(place, refused.spacing, speed, *at)[1] is None  # the spacing that is offered does
    else:
        place = int(rng.integers(1, n + 1))
        road, refused = road.remove(place, *at)
        assert (refused is not None) == (n == 1)
        if not refused:
            assert road.vehicles == before[: place - 1] + before[place:]
    after = road.platoon.observe(*at)
    kept = [i for i, vehicle in enumerate(road.vehicles) if vehicle in before]
    was = [before.index(road.vehicles[i]) for i in kept]
    np.testing.assert_allclose(after.x[kept], seen.x[was], rtol=0, atol=1e-8)  # nobody is moved by a change
    np.testing.assert_array_equal(after.v[kept], seen.v[was])
    np.testing.assert_array_equal(after.cost, seen.cost)
    return road


def in_omega(road: OpenPlatoon) -> bool:
    now = road.platoon.now
    return bool((now.s > C.L).all() and (now.v >= 0).all() and (now.v <= C.v_max).all())


@pytest.mark.parametrize("seed", range(24))
def test_thousands_of_joins_and_leaves_keep_everybody_in_the_state_space(seed):
    rng, time = np.random.default_rng(seed), [0.0]
    road = open_platoon(seed, 2 + seed % 11, old=seed % 2 == 1)
    sizes = set()
    for _ in range(150):
        road = step(road, rng, time)
        assert in_omega(road)
        now = road.platoon.now
        assert now.v.size == len(road.vehicles) == len(set(road.vehicles)) == now.s.size + 1 == now.a.size
        np.testing.assert_allclose(now.a, feedback(now.s, now.v, road.platoon.shape, C))
        sizes.add(now.v.size)
    assert len(sizes) > 3


@pytest.mark.parametrize("seed", range(6))
def test_a_saved_platoon_has_the_identical_future(seed):
    rng, time = np.random.default_rng(100 + seed), [0.0]
    road = open_platoon(seed, 5)
    for _ in range(20):
        road = step(road, rng, time)
    platoon = road.platoon
    saved = replace(road, platoon=SampledPlatoon(platoon.loop, platoon.sampling, platoon.now))
    ends = []
    for each in (road, saved):
        again, clock = np.random.default_rng(seed), list(time)
        for _ in range(40):
            each = step(each, again, clock)
        now = each.platoon.now
        ends.append((each.vehicles, now.x, now.s.tolist(), now.v.tolist(), now.cost, now.violations))
    assert ends[0] == ends[1]


def test_a_join_that_lemma_1_does_not_cover_is_refused_with_a_spacing_that_would_do():
    for policy in Lemma1Policy:
        road = open_platoon(3, 4, sampling=Sampling(T, policy))
        apart = road.platoon.take_over(0, 0.0, 0.0, np.array([20.0, 20.0, 20.0]), np.full(4, 30.0), BEST_FIXED)
        road = replace(road, platoon=apart)
        before = road.platoon.now
        same, refused = road.insert(2, C.L + T * C.v_max, 30.0, 0, 0.0)
        assert same is road
        assert refused is not None and "would be accepted" in refused.sentence and road.platoon.now is before
        road, again = road.insert(2, refused.spacing, 30.0, 0, 0.0)
        assert again is None
        assert road.vehicles == (1, 2, 5, 3, 4)
        np.testing.assert_allclose(road.platoon.now.s, [20, refused.spacing, 20 - refused.spacing, 20])


def test_no_spacing_would_do_where_there_is_no_room():
    road = open_platoon(3, 4)
    _, refused = road.insert(1, 5.5, 30.0, 0, 0.0)  # between two that are 12 m apart at most
    assert refused is not None and "no spacing would be accepted" in refused.sentence and np.isnan(refused.spacing)


@pytest.mark.parametrize(
    ("change", "part"),
    [
        (lambda road: road.insert(9, 10.0, 30.0, 0, 0.0), "insert_behind = 9"),
        (lambda road: road.insert(1.5, 10.0, 30.0, 0, 0.0), "insert_behind = 1.5"),
        (lambda road: road.insert(4, 10.0, 36.0, 0, 0.0), "36 m/s"),
        (lambda road: road.insert(4, float("nan"), 30.0, 0, 0.0), "would be accepted"),
        (lambda road: road.insert(4, 10.0, float("nan"), 0, 0.0), "nan m/s"),
        (lambda road: road.remove(0, 0, 0.0), "remove_place = 0"),
        (lambda road: road.remove(float("nan"), 0, 0.0), "remove_place = nan"),
    ],
)
def test_a_senseless_change_is_refused_in_one_sentence(change, part):
    road = open_platoon(1, 4)
    before = road.platoon.now
    road, refused = change(road)
    assert part in refused.sentence and "\n" not in refused.sentence and road.platoon.now is before


def test_a_platoon_may_shrink_to_one_vehicle_and_fill_up():
    road = open_platoon(2, 3)
    for place in (1, 2):
        road, refused = road.remove(place, 0, 0.0)
        assert refused is None
    assert road.vehicles == (2,)
    assert "last" in road.remove(1, 0, 0.0)[1].sentence
    road.platoon.advance_to(1000, 0.0)
    assert road.platoon.now.v[0] == pytest.approx(30.0, abs=0.2)  # alone it goes to v_star
    for k in range(11):
        road, refused = road.insert(len(road.vehicles), 15.0, 30.0, 1000, 0.0)
        assert refused is None, k
    assert "12" in road.insert(12, 15.0, 30.0, 1000, 0.0)[1].sentence
