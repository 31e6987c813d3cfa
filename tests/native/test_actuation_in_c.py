"""Actuators and vehicles that act late and softly: the C of the native FMUs does what psp_model does."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
import pytest

from fmu_src.native import build
from fmu_src.toolchain.compile import host_platform
from psp_model.parameters import Actuation
from psp_model.vehicles.actuation import Foreign, at_rest, commanded, drive, settle
from psp_model.vehicles.membership import of_members
from psp_model.vehicles.ride import ride

N, T = 7, 0.01
EXPORTS = b"""
#include "actuation.h"
#include "ride.h"
#include <stdlib.h>
#define EXPORTED __attribute__((visibility("default")))
EXPORTED void *new_actuators(int64_t rows)
{
    Actuators *made = malloc(offsetof(Actuators, queue) + (size_t)rows * sizeof(OnItsWay)); /* no more is touched */
    actuators_begin(made, rows);
    for (int64_t k = 0; k < rows; k++) made->queue[k] = (OnItsWay){0};
    return made;
}
EXPORTED void free_actuators(void *all) { free(all); }
EXPORTED int64_t rows(double longest, double T) { return actuators_rows(longest, T); }
EXPORTED int can_be(Actuators *all, int64_t rows) { return actuators_can_be(all, rows); }
EXPORTED int command(Actuators *all, int n, const double *a, double due) { return actuators_command(all, n, a, due); }
EXPORTED void read_all(const Actuators *all, int n, double *a, double *command, double *last)
{
    for (int i = 0; i < n; i++) {
        a[i] = all->a[i];
        command[i] = all->command[i];
        last[i] = actuators_last(all)[i];
    }
}
static const Foreign *others(const double *automated, const double *a, Foreign *made)
{
    *made = (Foreign){automated, a};
    return automated ? made : NULL;
}
EXPORTED void drive_all(Actuators *all, const Actuation *actuation, int n, double tau, const double *automated,
                        const double *of_others, double *v, double *moved)
{
    Foreign made;
    actuators_drive(all, actuation, n, tau, others(automated, of_others, &made), v, moved);
}
EXPORTED void foresee(const Actuators *all, const int32_t *of, const Actuation *actuation, int n, double wait,
                      double tau, const double *automated, const double *of_others, double *v, double *moved, double *a,
                      double *c)
{
    Foreign made;
    const Foreign *foreign = others(automated, of_others, &made);
    actuators_foresee(all, of, actuation, n, wait, tau, foreign, v, moved, a, c);
}
EXPORTED void settle_all(Actuators *all, const Actuation *actuation, int n, double tau)
{
    actuators_settle(all, actuation, n, tau);
}
EXPORTED void rearrange(Actuators *all, int n, const int32_t *places) { actuators_rearrange(all, n, places); }
EXPORTED void steadily(double v, double a, double span, double *then, double *moved)
{
    ride_steadily(v, a, span, then, moved);
}
"""


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    sources = build.native_controller(N, {}).sources("{none}") | {"exports.c": EXPORTS}
    path = tmp_path_factory.mktemp("actuation") / "actuation.so"
    path.write_bytes(build.compile_library(host_platform(), "actuation", sources))
    loaded = ctypes.CDLL(str(path))
    loaded.new_actuators.restype = ctypes.c_void_p
    loaded.rows.restype = ctypes.c_int64
    loaded.rows.argtypes = [ctypes.c_double] * 2
    return loaded


def numbers(values: Any) -> Any:
    """A copy in C's order, which ctypes passes as a pointer; None as NULL."""
    return None if values is None else np.array(values, dtype=np.float64).ctypes.data_as(ctypes.c_void_p)


def places(members: list[int | None] | None) -> Any:
    """Places before as C has them."""
    if members is None:
        return None
    return (ctypes.c_int32 * len(members))(*(-1 if one is None else one for one in members))


class InC:
    """Actuators in C with the functions of the model."""

    def __init__(self, library: ctypes.CDLL, rows: int, actuation: Actuation, n: int):
        self.library, self.rows, self.n = library, rows, n
        self.it = ctypes.c_void_p(library.new_actuators(ctypes.c_int64(rows)))
        each = [np.resize(np.broadcast_to(x, n), N) for x in (actuation.actuator_lag, actuation.a_min, actuation.a_max)]
        self.actuation = np.concatenate([[actuation.actuation_delay], *each])
        self.delay = actuation.actuation_delay

    def command(self, a: Any, ago: float = 0.0) -> bool:
        return bool(self.library.command(self.it, self.n, numbers(a), ctypes.c_double(self.delay - ago)))

    def drive(self, v: Any, tau: float, foreign: Foreign | None) -> tuple[Any, Any]:
        then, moved = np.array(v), np.full(self.n, np.nan)
        parts = (None, None) if foreign is None else (numbers(foreign.automated), numbers(foreign.a))
        self.library.drive_all(
            self.it, numbers(self.actuation), self.n, ctypes.c_double(tau), *parts,
            then.ctypes.data_as(ctypes.c_void_p), moved.ctypes.data_as(ctypes.c_void_p),
        )  # fmt: skip
        return then, moved

    def foresee(
        self, v: Any, wait: float, tau: float, foreign: Foreign | None, members: list[int | None] | None = None
    ) -> list[Any]:
        n = self.n if members is None else len(members)
        found = [np.array(v), *(np.full(n, np.nan) for _ in range(3))]
        parts = (None, None) if foreign is None else (numbers(foreign.automated), numbers(foreign.a))
        self.library.foresee(
            self.it, places(members), numbers(self.actuation), n, ctypes.c_double(wait), ctypes.c_double(tau), *parts,
            *(one.ctypes.data_as(ctypes.c_void_p) for one in found),
        )  # fmt: skip
        return found

    def settle(self, tau: float) -> None:
        self.library.settle_all(self.it, numbers(self.actuation), self.n, ctypes.c_double(tau))

    def rearrange(self, members: list[int | None]) -> None:
        self.library.rearrange(self.it, len(members), places(members))
        self.n = len(members)

    def read(self) -> list[Any]:
        found = [np.empty(self.n) for _ in range(3)]
        self.library.read_all(self.it, self.n, *(one.ctypes.data_as(ctypes.c_void_p) for one in found))
        return found

    def is_possible(self) -> bool:
        return bool(self.library.can_be(self.it, ctypes.c_int64(self.rows)))

    def free(self) -> None:
        self.library.free_actuators(self.it)


def lags(rng: np.random.Generator, kind: int, n: int) -> Any:
    """None, one for all, or different ones, some of them 0."""
    return (0.0, float(rng.uniform(0.05, 0.6)), rng.choice([0.0, 0.0, 0.1, 0.3, 0.7], n))[kind]


def drawn(rng: np.random.Generator, kind: int, n: int) -> tuple[Actuation, Foreign | None]:
    delay = float(rng.choice([0.0, 0.5, 1.0, 7.3, 20.0])) * T
    limits = -rng.uniform(3.0, 9.0, n), rng.uniform(1.0, 4.0, n)
    automated = rng.choice([0.0, 1.0], n)
    foreign = Foreign(automated, rng.normal(0.0, 3.0, n)) if rng.random() < 0.5 else None
    return Actuation(delay, lags(rng, kind, n), *limits), foreign


@pytest.mark.parametrize("kind", [0, 1, 2])
def test_drives_and_predictions_are_those_of_the_model(library: ctypes.CDLL, kind: int) -> None:
    """Bit for bit without a lag; else up to what two mathematical libraries make of exp."""
    rng, close = np.random.default_rng(kind), 0.0 if kind == 0 else 1e-11

    def same(found: Any, expected: Any) -> None:
        for one, other in zip(found, expected, strict=True):
            np.testing.assert_allclose(one, other, rtol=0, atol=close)

    stood, rode = 0, 0
    for _ in range(60):
        n = int(rng.integers(1, N + 1))
        actuation, foreign = drawn(rng, kind, n)
        mine, theirs = InC(library, library.rows(actuation.actuation_delay, T), actuation, n), at_rest(np.zeros(n))
        v = rng.choice([0.0, 0.05, 1.0, 30.0], n)
        for _ in range(40):
            a = rng.choice([0.0, -9.0, 3.0, 1.0, -2.0], n)
            assert mine.command(a) and mine.is_possible()
            theirs = commanded(theirs, a, actuation)
            wait, tau = float(rng.choice([0.0, 0.3, 1.0])) * T, float(rng.choice([0.0, 1.0, 2.7, 30.0])) * T
            before = settle(theirs, actuation, wait) if wait > 0.0 else theirs
            then, moved, ahead = drive(v, before, actuation, tau, foreign)
            same(mine.foresee(v, wait, tau, foreign), (then, moved, ahead.a, ahead.command))
            span = float(rng.choice([1.0, 1.0, 1.4])) * T
            if rng.random() < 0.2:
                mine.settle(span)
                theirs = settle(theirs, actuation, span)
            else:
                then, moved, theirs = drive(v, theirs, actuation, span, foreign)
                same(mine.drive(v, span, foreign), (then, moved))
                v = then
            last = theirs.queue[-1][1] if theirs.queue else theirs.command
            same(mine.read(), (theirs.a, theirs.command, last))
            stood, rode = stood + np.sum(v == 0.0), rode + np.sum(v > 0.0)
        mine.free()
    assert min(stood, rode) > 1000


def other_members(rng: np.random.Generator, n: int) -> list[int | None]:
    """The same vehicles but one, one more, fewer, or more."""
    same: list[int | None] = list(range(n))
    k = int(rng.integers(n + 1))
    fewer, more = same[: max(k, 1)], same + [None] * (N - n)
    one_less = same[:k] + same[k + 1 :] if n > 1 else same
    return (one_less, [*same[:k], None, *same[k:]][:N], fewer, more)[rng.integers(4)]


def test_actuators_of_other_vehicles_are_those_of_the_model(library: ctypes.CDLL) -> None:
    rng = np.random.default_rng(7)
    for _ in range(200):
        n = int(rng.integers(1, N + 1))
        actuation = Actuation(float(rng.choice([0.0, 3.7])) * T, 0.0, -5.0, 3.0)
        mine, theirs = InC(library, library.rows(actuation.actuation_delay, T), actuation, n), at_rest(np.zeros(n))
        for _ in range(6):
            a = rng.normal(0.0, 3.0, n)
            mine.command(a)
            mine.settle(T)
            theirs = settle(commanded(theirs, a, actuation), actuation, T)
        members = other_members(rng, n)
        others = of_members(theirs, members)
        v = rng.uniform(0.0, 1.0, len(members))
        then, moved, ahead = drive(v, settle(others, actuation, 0.5 * T), actuation, 2.5 * T)
        found = mine.foresee(v, 0.5 * T, 2.5 * T, None, members)
        mine.rearrange(members)
        for one, other in zip(found, (then, moved, ahead.a, ahead.command), strict=True):
            np.testing.assert_array_equal(one, other)
        for one, other in zip(mine.read()[:2], (others.a, others.command), strict=True):
            np.testing.assert_array_equal(one, other)
        then, moved, _ = drive(v, others, actuation, 10.0 * T)
        np.testing.assert_array_equal(mine.drive(v, 10.0 * T, None)[0], then)
        mine.free()


def test_rides_without_a_lag_are_those_of_the_model(library: ctypes.CDLL) -> None:
    rng = np.random.default_rng(5)
    for _ in range(300):
        v, a, span = float(rng.choice([0.0, 0.3, 20.0])), float(rng.normal(0, 3)), float(rng.uniform(0, 10))
        found = np.empty(2)
        out = [found[k:].ctypes.data_as(ctypes.c_void_p) for k in (0, 1)]
        library.steadily(*(ctypes.c_double(x) for x in (v, a, span)), *out)
        then, moved, _ = ride(np.array([v]), np.array([a]), np.array([a]), 0.0, span)
        assert found.tolist() == [then[0], moved[0]]


@pytest.mark.parametrize(
    ("longest", "expected"),
    [(0.0, 0), (0.5 * T, 3), (T, 3), (0.5, 52), (509.5 * T, 512), (510.5 * T, -1), (1e300, -1), (np.inf, -1)],
)
def test_the_ring_has_room_for_what_can_be_on_its_way(library: ctypes.CDLL, longest: float, expected: int) -> None:
    assert library.rows(longest, T) == expected


@pytest.mark.parametrize("delay", [0.5, 1.0, 1.5, 50.0, 509.5])
def test_a_full_ring_refuses_and_commands_every_period_never_fill_it(library: ctypes.CDLL, delay: float) -> None:
    actuation = Actuation(delay * T)
    mine = InC(library, library.rows(delay * T, T), actuation, N)
    for _ in range(1200):
        assert mine.command(np.zeros(N))
        mine.settle(T)
    while mine.command(np.zeros(N)):
        pass
    assert mine.is_possible() and not mine.command(np.ones(N))
    mine.free()
