"""The clock against exact fractions of what masters mean: every sampling instant is met where they meet it."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from math import floor, lcm

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from masters import MASTERS, ROUNDERS, STARTS, Told, steps_of, sums, sums_and_differences
from psp_model import ModelError
from psp_model.sampling.clock import MOST_PERIODS, TIME_TOLERANCE, Clock

PERIODS = {
    "0.1 s": Fraction(1, 10),
    "0.01 s": Fraction(1, 100),
    "1 ms": Fraction(1, 1000),
    "0.1 ms": Fraction(1, 10000),
}
PATTERNS = {  # sizes of the communication steps [sampling periods], which repeat
    "T": "1",
    "5 T": "5",
    "T/4": "1/4",
    "T/3": "1/3",
    "T/20": "1/20",
    "3.7 T": "37/10",
    "10/3 T": "10/3",
    "in pieces": "3/10 7/10",
    "in uneven pieces": "1/2 1/3 1/6 2 1/7 6/7",
}


def sizes(pattern: str, T: Fraction) -> list[Fraction]:
    return [Fraction(part) * T for part in PATTERNS[pattern].split()]


def walk(told: Iterable[Told], T: Fraction, clock: Clock, tolerance: float) -> int:
    """Take the steps; each is where the master means it to be. How many instants were met."""
    period, met = float(T), 0
    for begin, size, end in told:
        clock = clock.after(begin, size, period)
        whole, fraction = clock.at()
        exact = end / T
        assert whole == floor(exact), (begin, size, exact, clock)
        assert (fraction == 0.0) == (exact == whole), (begin, size, exact, clock)
        assert abs(fraction - float(exact - whole)) <= tolerance, (begin, size, exact, clock)
        assert clock.time == begin + size
        met += fraction == 0.0
    return met


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("name", MASTERS)
@pytest.mark.parametrize("period", PERIODS)
def test_every_instant_is_met_where_the_master_meets_it_and_nowhere_else(period: str, name: str, start: float) -> None:
    T = PERIODS[period]
    resolution = float(np.spacing(abs(start) + 10.0)) / float(T)
    for pattern in PATTERNS:
        told = steps_of(MASTERS[name], start, sizes(pattern, T), 180)
        met = walk(told, T, Clock.begin(start), TIME_TOLERANCE + 20 * resolution)
        assert met == sum((step.end / T).denominator == 1 for step in told) > 0


@pytest.mark.parametrize("name", ROUNDERS)
@pytest.mark.parametrize("T", [Fraction(1, 100), Fraction(1, 30), Fraction(1, 10)])
def test_masters_that_round_more_are_understood_too(name: str, T: Fraction) -> None:
    for pattern in ("T", "5 T", "T/4", "10/3 T", "in pieces"):
        told = steps_of(ROUNDERS[name], 0.0, sizes(pattern, T), 6000 if pattern == "T" else 1500)
        assert walk(told, T, Clock.begin(0.0), 1e-5) > 300


@pytest.mark.parametrize("start", [0.0, 1.7e9])
@pytest.mark.parametrize("phase", [Fraction(1, 2), Fraction(3, 10), Fraction(1, 3)])
def test_instants_may_have_a_phase(phase: Fraction, start: float) -> None:
    T = Fraction(1, 100)
    for master in MASTERS.values():
        clock = Clock.begin(start, float(phase * T), float(T))
        assert clock.at()[0] == -1 and clock.time_of(0, float(T)) == pytest.approx(start + float(phase * T), abs=1e-9)
        told = steps_of(master, start, [phase * T, (1 - phase) * T], 200)
        assert walk([step._replace(end=step.end - phase * T) for step in told], T, clock, 1e-3) == 100


@given(
    st.sampled_from(sorted(MASTERS)),
    st.sampled_from(STARTS),
    st.sampled_from(sorted(PERIODS)),
    st.lists(st.fractions(Fraction(1, 12), 12, max_denominator=12), min_size=1, max_size=4),
)
@settings(max_examples=150, deadline=None)
def test_any_pattern_of_steps(name: str, start: float, period: str, parts: list[Fraction]) -> None:
    assume(len(parts) * sum(parts).denominator <= 32)  # steps from one instant to the next that is met, at most
    T, apart = PERIODS[period], Fraction(1, lcm(*(part.denominator for part in parts)))
    coarse = float(np.spacing(abs(start) + 10.0)) / float(T)
    assume(20 * coarse < apart)  # else the master's time cannot tell its points from instants
    told = steps_of(MASTERS[name], start, [part * T for part in parts], 60)
    walk(told, T, Clock.begin(start), TIME_TOLERANCE + 32 * coarse)


@given(
    st.lists(st.floats(1e-9, 0.3), min_size=1, max_size=10).map(lambda parts: parts * 6),
    st.sampled_from([0.01, 0.003, 0.1]),
)
@settings(max_examples=150, deadline=None)
def test_steps_of_any_size_at_an_ordinary_time(parts: list[float], T: float) -> None:
    """Never back, and no more wrong than the tolerance and the 2e-9 s that are dropped at an instant."""
    clock, exact, before, dropped = Clock.begin(0.0), Fraction(0), (0, 0.0), 0.0
    for size in parts:
        clock = clock.after(clock.time, size, T)
        exact += Fraction(size) / Fraction(T)
        assert clock.at() >= before
        dropped += 2e-9 / T * (clock.at()[1] == 0.0 and clock.at() != before)
        before = clock.at()
        assert abs(float(before[0] + Fraction(before[1]) - exact)) <= 1.5 * TIME_TOLERANCE + dropped


@pytest.mark.parametrize("h", [1e-9, 2e-9, 1e-8, 1.7e-7])
def test_steps_shorter_than_any_tolerance_go_on(h: float) -> None:
    clock = Clock.begin(0.0)
    for _ in range(5000):
        clock = clock.after(clock.time, h, 0.0001)
    assert clock.period + clock.offset == pytest.approx(
        5000 * h / 0.0001, abs=1.5 * TIME_TOLERANCE * (1 + clock.period)
    )


@pytest.mark.parametrize("h", [0.0099, 0.0101, 0.010001, 0.00999])
@pytest.mark.parametrize("start", [0.0, 1e6])
def test_a_step_that_is_nearly_T_is_not_taken_for_T(h: float, start: float) -> None:
    for master in (sums, sums_and_differences):
        walk(steps_of(master, start, [Fraction(str(h))], 3000), Fraction(1, 100), Clock.begin(start), 1e-3)


def drifted(T: float, h: float, periods: int, drift: float) -> Clock:
    """The clock of a master that has added up h for so long that its time is off by `drift` [s]."""
    return Clock(0.0, periods * T + drift, periods, 0.0, h)


@pytest.mark.parametrize("drift", [-2e-5, 3e-7, 5e-5])
def test_a_last_step_that_aims_at_the_end_meets_it_in_spite_of_drift(drift: float) -> None:
    """min(h, stop - t) after a day of t += h; the sum of the steps is not what the master aims at."""
    T, days = 0.01, 8_640_000
    for h, left in ((T, 1), (5 * T, 5)):
        clock, stop = drifted(T, h, days - left, drift), days * T
        clock = clock.after(clock.time, min(h, stop - clock.time), T)
        if clock.time < stop:
            clock = clock.after(clock.time, stop - clock.time, T)
        assert clock.at()[0] == days and clock.at()[1] < 0.01 and clock.time == stop


def test_a_time_that_really_moves_is_followed() -> None:
    clock = Clock.begin(0.0).after(0.0, 0.01, 0.01)
    assert clock.after(0.0105, 0.01, 0.01).at() == (2, pytest.approx(0.05))
    assert clock.after(0.01, 0.0, 0.01).at() == clock.at()
    assert clock.after(0.0101, 0.0, 0.01).at() == (1, pytest.approx(0.01))
    assert clock.after(0.0, 0.0, 0.01).at() == (1, 0.0)  # never back


def test_times_of_instants_are_the_masters() -> None:
    clock = Clock.begin(1.7e9)
    for step in steps_of(sums, 1.7e9, [Fraction(1, 100)], 1000):
        clock = clock.after(step.begin, step.size, 0.01)
        assert clock.time_of(clock.at()[0], 0.01) == clock.time
    assert clock.time_of(1003, 0.01) == pytest.approx(clock.time + 0.03, abs=1e-6)
    assert clock.age_rounding(0.02, 0.01) < 1e-5 and Clock.begin(0.0).age_rounding(0.02, 0.01) == 1e-8


def test_more_periods_than_can_be_counted_are_refused() -> None:
    for size in (MOST_PERIODS * 0.01, 1e308):
        with pytest.raises(ModelError, match=r"s are more sampling periods of T = 0\.01 s than can be counted"):
            Clock.begin(0.0).after(0.0, size, 0.01)
    with pytest.raises(ModelError) as caught:
        Clock.begin(1e308).after(1e308, 1e308, 1e300)
    assert caught.value.key == "periods"
