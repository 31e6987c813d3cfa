"""The clock in C is that in Python, bit for bit; and, being fast, runs for days."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fmu_src.native import build
from fmu_src.toolchain.compile import compile_library, host_platform
from masters import MASTERS, ROUNDERS, STARTS, steps_of
from psp_model import ModelError
from psp_model.sampling.clock import Clock

DAY = 86_400  # [s]
EXPORTS = b"""
#include "clock.h"
#define EXPORTED __attribute__((visibility("default")))
EXPORTED void exported_begin(Clock *c, double start, double phase, double T) { clock_begin(c, start, phase, T); }
EXPORTED int exported_pass(Clock *c, double begin, double size, double T) { return clock_pass(c, begin, size, T); }
EXPORTED int64_t exported_at(const Clock *clock, double *fraction) { return clock_at(clock, fraction); }
EXPORTED double exported_time_of(const Clock *clock, int64_t k, double T) { return clock_time_of(clock, k, T); }
EXPORTED double exported_age_rounding(const Clock *c, double age, double T) { return clock_age_rounding(c, age, T); }

/* A run of `steps` equal steps, of which `parts` make `periods` sampling periods: the step after which an instant was
 * not where it should be, 0 if they all were.  kind: 0: t += h; 2: start + k h; 1, 3: these with differences */
EXPORTED int64_t exported_run(int kind, double start, double h, double T, int64_t steps, int64_t parts, int64_t periods)
{
    Clock clock;
    double t = start, fraction;
    clock_begin(&clock, start, 0.0, T);
    for (int64_t k = 1; k <= steps; k++) {
        const double next = kind < 2 ? t + h : start + (double)k * h;
        if (!clock_pass(&clock, t, kind % 2 ? next - t : h, T)) return k;
        t = next;
        const int64_t period = clock_at(&clock, &fraction);
        if (period != k * periods / parts || (fraction == 0.0) != (k * periods % parts == 0)) return k;
    }
    return 0;
}
"""


class CClock(ctypes.Structure):
    """The struct Clock of clock.h."""

    _fields_ = (
        ("first", ctypes.c_double),
        ("time", ctypes.c_double),
        ("period", ctypes.c_int64),
        ("offset", ctypes.c_double),
        ("last", ctypes.c_double),
        ("doubt", ctypes.c_double),
    )


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """clock.c with its functions made visible."""
    sources = build.native_platoon(2, {}).sources("{none}")
    files = {name: text for name, text in sources.items() if name.endswith(".h") or name == "clock.c"}
    path = tmp_path_factory.mktemp("clock") / "clock.so"
    path.write_bytes(compile_library(host_platform(), "clock", files | {"exports.c": EXPORTS}))
    loaded = ctypes.CDLL(str(path))
    double, whole, clock = ctypes.c_double, ctypes.c_int64, ctypes.POINTER(CClock)
    loaded.exported_begin.argtypes = (clock, double, double, double)
    loaded.exported_pass.argtypes = (clock, double, double, double)
    loaded.exported_at.argtypes, loaded.exported_at.restype = (clock, ctypes.POINTER(double)), whole
    loaded.exported_time_of.argtypes, loaded.exported_time_of.restype = (clock, whole, double), double
    loaded.exported_age_rounding.argtypes, loaded.exported_age_rounding.restype = (clock, double, double), double
    loaded.exported_run.argtypes = (ctypes.c_int, double, double, double, whole, whole, whole)
    loaded.exported_run.restype = whole
    return loaded


def both(library: ctypes.CDLL, start: float, phase: float, T: float, steps: Iterable[tuple[float, float]]) -> None:
    """Take the steps with both clocks, which are equal in every field after each."""
    theirs, ours = CClock(), Clock.begin(start, phase, T)
    library.exported_begin(theirs, start, phase, T)
    for begin, size in steps:
        try:
            ours = ours.after(begin, size, T)
            counted = True
        except ModelError:
            counted = False
        assert bool(library.exported_pass(theirs, begin, size, T)) == counted
        assert tuple(getattr(theirs, name) for name, _ in CClock._fields_) == tuple(ours)
        fraction = ctypes.c_double()
        assert (library.exported_at(theirs, fraction), fraction.value) == ours.at()
        assert library.exported_time_of(theirs, ours.period + 3, T) == ours.time_of(ours.period + 3, T)
        assert library.exported_age_rounding(theirs, size, T) == ours.age_rounding(size, T)


@pytest.mark.parametrize("start", STARTS)
@pytest.mark.parametrize("name", [*MASTERS, *ROUNDERS])
def test_both_clocks_are_equal_for_every_master(library: ctypes.CDLL, name: str, start: float) -> None:
    for T, pattern in ((0.01, "1"), (0.01, "1/4 3/4 1/3"), (0.1, "10/3"), (0.001, "37/10"), (0.0001, "5/7")):
        steps = [Fraction(part) * Fraction(str(T)) for part in pattern.split()]
        told = steps_of((MASTERS | ROUNDERS)[name], start, steps, 60)
        both(library, start, 0.0, T, [(step.begin, step.size) for step in told])


numbers = st.one_of(
    st.floats(0, 1), st.floats(0, width=32), st.floats(0, allow_infinity=False), st.sampled_from([0.0, 0.01, 5e-324])
)


@given(
    st.floats(allow_nan=False, allow_infinity=False) | st.sampled_from(STARTS),
    st.floats(0, 1, exclude_max=True),
    st.floats(1e-12, 1e12) | st.sampled_from([0.01, 5e-324, 1e308]),
    st.lists(numbers.map(float), max_size=20),
    st.floats(-2, 2),
)
@settings(max_examples=300, deadline=None)
def test_both_clocks_are_equal_whatever_they_are_told(
    library: ctypes.CDLL, start: float, phase: float, T: float, parts: list[float], noise: float
) -> None:
    time, steps = start, []
    for size in parts:
        if not np.isfinite(time):
            break
        steps.append((time, size if np.isfinite(size) else 1.0))
        time += size * (1.0 + noise * 1e-9)
    both(library, start, phase * T, T, steps)


@pytest.mark.parametrize(
    ("kind", "start", "T", "parts", "periods", "seconds"),
    [
        (0, 0.0, 0.01, 1, 1, 10 * DAY),
        (0, 1.7e9, 0.01, 1, 1, 10 * DAY),
        (0, 0.0, 0.001, 1, 1, DAY // 4),
        (0, 1.7e9, 0.01, 4, 1, DAY // 4),
        (0, 0.0, 0.01, 3, 1, DAY // 4),
        (0, 0.0, 0.01, 1, 5, DAY),
        (0, 1e6, 0.01, 10, 37, DAY),
        (0, -1.7e9, 0.01, 3, 10, DAY),
        (1, 0.0, 0.01, 1, 1, DAY // 2),
        (1, 1.7e9, 0.01, 1, 1, DAY // 2),
        (1, 1.7e9, 0.01, 10, 37, DAY),
        (1, -1.7e9, 0.01, 3, 1, DAY // 8),
        (1, 1.7e9, 0.001, 4, 1, DAY // 80),
        (2, 1.7e9, 0.01, 1, 1, DAY),
        (2, -1.7e9, 0.01, 3, 10, DAY),
        (3, 0.0, 0.01, 1, 1, DAY // 2),
        (3, 1.7e9, 0.01, 1, 1, DAY // 2),
        (3, 1.7e9, 0.001, 3, 1, DAY // 40),
        (3, 1700000000.123, 0.01, 10, 37, DAY),
    ],
)
def test_days_of_steps_meet_every_instant(
    library: ctypes.CDLL, kind: int, start: float, T: float, parts: int, periods: int, seconds: int
) -> None:
    h = float(Fraction(str(T)) * periods / parts)
    steps = round(seconds / h)
    assert library.exported_run(kind, start, h, T, steps, parts, periods) == 0
