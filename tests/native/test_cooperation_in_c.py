"""The extended law in C against the model's, at random: lengths, time gaps, viscosity, some drive themselves."""

from __future__ import annotations

import ctypes
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from fmu_src.native import build
from fmu_src.toolchain.compile import host_platform
from psp_model import BEST_FIXED, V_OLD, PlatoonParameters, PotentialParameters
from psp_model.law.cooperation import (
    Cooperation,
    Traffic,
    clearances,
    closing_speeds,
    contact_spacing,
    cooperative_command,
    model_spacing,
)
from psp_model.law.extended import DrivenLeader, ExtendedLaw
from psp_model.law.feedback import feedback, feedback_towards
from psp_model.law.following import followed_by
from psp_model.sampling.exact import exact_period
from psp_model.sampling.hold import Motion
from psp_model.sampling.period import automated, lemma1_period, room

MOST = 6
EXPORTS = b"""
#include "certificate.h"
#define EXPORTED __attribute__((visibility("default")))
static Constants constants;
static Shape shape;
static Cooperation cooperation;
static Traffic traffic;
EXPORTED void told(const double *c, const double *h, const double *k, const double *length, const double *aims,
                   const double *automated, const double *a, const double *closing)
{
    constants = (Constants){c[0], c[1], c[2], c[3], c[4], c[5], c[6]};
    shape = (Shape){h[0], h[1], h[2], h[3]};
    papers_law(&cooperation, &constants);
    if (k) {
        cooperation = (Cooperation){k[0], k[1], k[2], k[3], (int64_t)k[4], k[5], k[6], k[7], {0}};
        for (int i = 0; i < PSP_N; i++) cooperation.length[i] = length[i];
    }
    traffic = (Traffic){automated, a, aims[0], aims[1], closing};
}
EXPORTED void command(int n, const double *s, const double *v, double *a)
{
    cooperative_command(&constants, &shape, &cooperation, &traffic, n, s, v, a);
}
EXPORTED void papers(int n, const double *s, const double *v, double *a)
{
    if (traffic.v_desired < 0.0) feedback(&constants, &shape, n, s, v, a);
    else feedback_towards(&constants, &shape, n, s, v, traffic.v_desired, a);
}
EXPORTED void spacings(int n, const double *s, const double *v, double *contact, double *clear, double *model)
{
    contact_spacing(&constants, &cooperation, n, s, contact);
    clearances(&constants, &cooperation, n, s, clear);
    model_spacing(&constants, &cooperation, n, s, v, model);
}
EXPORTED void closing(int n, const double *s, double *closing)
{
    closing_speeds(&cooperation, n, s, traffic.automated, closing);
}
EXPORTED void periods(int n, int driven, const double *s, const double *v, const double *a, double *found)
{
    found[0] = lemma1_period(&constants, &cooperation, driven, n, s, v, a);
    found[1] = exact_period(&constants, &cooperation, driven, n, s, v, a);
    found[2] = exact_period(&constants, NULL, driven, n, s, v, a);
}
EXPORTED void followed(int n, double *followed) { followed_by(n, traffic.automated, cooperation.following, followed); }
"""


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """The native platoon's sources with the extended law made visible."""
    sources = build.native_platoon(MOST, {}).sources("{none}") | {"exports.c": EXPORTS}
    path = tmp_path_factory.mktemp("cooperation") / "cooperation.so"
    path.write_bytes(build.compile_library(host_platform(), "cooperation", sources))
    return ctypes.CDLL(str(path))


def vector(values: Any) -> Any:
    return None if values is None else (ctypes.c_double * len(values))(*values)


class InC:
    """The C functions for one case; keeps what they point to."""

    def __init__(
        self,
        library: ctypes.CDLL,
        constants: PlatoonParameters,
        shape: PotentialParameters,
        cooperation: Cooperation | None,
        traffic: Traffic,
    ) -> None:
        c, k = constants, cooperation
        scalars = k and [k.kappa, k.kappa_reach, k.time_gap, k.feedforward, k.following]
        scalars = k and [*scalars, k.closing_speed, k.closing_spacing, k.closing_reach]
        length = k and ([c.L] * MOST if k.length is None else [*k.length, *[0.0] * (MOST - len(k.length))])
        aims = [-1.0 if traffic.v_desired is None else traffic.v_desired, traffic.a_desired]
        numbers = [[c.L, c.lam, c.v_star, c.v_max, c.epsilon, c.mu, c.z], [shape.alpha, shape.r, shape.p, shape.hill]]
        self.kept = [*map(vector, [*numbers, scalars, length, aims, traffic.automated, traffic.a, traffic.closing])]
        self.library = library
        library.told(*self.kept)

    def command(self, s: Any, v: Any, law: str = "command") -> Any:
        a = vector(np.zeros(len(v)))
        getattr(self.library, law)(len(v), vector(s), vector(v), a)
        return np.array(a)

    def spacings(self, s: Any, v: Any) -> Any:
        found = [vector(np.zeros(len(s))) for _ in range(3)]
        self.library.spacings(len(v), vector(s), vector(v), *found)
        return [np.array(one) for one in found]

    def closing(self, s: Any) -> Any:
        found = vector(np.zeros(len(s) + 1))
        self.library.closing(len(s) + 1, vector(s), found)
        return np.array(found)

    def periods(self, driven: bool, s: Any, v: Any, a: Any) -> Any:
        found = vector(np.zeros(3))
        self.library.periods(len(v), driven, vector(s), vector(v), vector(a), found)
        return np.array(found)

    def followed(self, n: int) -> Any:
        found = vector(np.zeros(n))
        self.library.followed(n, found)
        return np.array(found)


def random_cooperation(rng: np.random.Generator, n: int) -> Cooperation:
    def perhaps(low: float, high: float, otherwise: float) -> float:
        return float(rng.uniform(low, high)) if rng.random() < 0.7 else otherwise

    spacing = float(rng.uniform(10, 30))
    return Cooperation(
        kappa=perhaps(0.1, 2.0, 0.0),
        kappa_reach=float(rng.uniform(10, 40)),
        time_gap=perhaps(0.1, 1.5, 0.0),
        feedforward=perhaps(0.0, 1.0, 1.0),
        following=int(rng.integers(1, 3)),
        closing_speed=perhaps(0.1, 1.5, 0.0),
        closing_spacing=spacing,
        closing_reach=spacing + float(rng.uniform(10, 80)),
        length=rng.uniform(3, 18, n) if rng.random() < 0.7 else None,
    )


def random_traffic(rng: np.random.Generator, n: int) -> Traffic:
    automated = (rng.random(n) < 0.6).astype(float) if rng.random() < 0.7 else None
    return Traffic(
        automated,
        rng.normal(0, 3, n) if rng.random() < 0.7 else None,
        float(rng.choice([0.0, 0.2, 34.8, 35.0, rng.uniform(0, 35)])) if rng.random() < 0.6 else None,
        float(rng.normal(0, 2)) if rng.random() < 0.5 else 0.0,
        rng.uniform(0, 4, n) if rng.random() < 0.5 else None,
    )


def random_vehicles(rng: np.random.Generator, n: int, cooperation: Cooperation, L: float) -> tuple[Any, Any]:
    lengths = np.full(n, L) if cooperation.length is None else cooperation.length
    s = lengths[:-1] + 10 ** rng.uniform(-2, 1.9, n - 1)
    v = np.clip(rng.uniform(-5, 40, n), 0.0, 35.0)
    return s, v


SHAPES = (V_OLD, BEST_FIXED, PotentialParameters(1e-2, 12.0, 4.0), PotentialParameters(1e-3, 0.0, 0.0, 0.0))


def same(found: Any, expected: Any, shape: PotentialParameters) -> None:
    if shape.hill == 0.0:
        np.testing.assert_array_equal(found, expected)
    else:
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)  # another library's power


def test_the_law_is_that_of_the_model(library: ctypes.CDLL) -> None:
    rng = np.random.default_rng(3)
    for _ in range(1500):
        n, shape = int(rng.integers(1, MOST + 1)), SHAPES[int(rng.integers(len(SHAPES)))]
        constants = PlatoonParameters(v_star=float(rng.uniform(10, 34)), mu=float(rng.uniform(0.2, 1.0)))
        cooperation, traffic = random_cooperation(rng, n), random_traffic(rng, n)
        s, v = random_vehicles(rng, n, cooperation, constants.L)
        here = InC(library, constants, shape, cooperation, traffic)
        expected = cooperative_command(s, v, shape, constants, cooperation, traffic)
        same(here.command(s, v), expected, shape)


def test_spacings_shares_and_who_is_followed_are_those_of_the_model(library: ctypes.CDLL) -> None:
    rng = np.random.default_rng(4)
    constants = PlatoonParameters()
    for _ in range(500):
        n = int(rng.integers(1, MOST + 1))
        cooperation, traffic = random_cooperation(rng, n), random_traffic(rng, n)
        s, v = random_vehicles(rng, n, cooperation, constants.L)
        here = InC(library, constants, V_OLD, cooperation, traffic)
        contact, clear, model = here.spacings(s, v)
        np.testing.assert_array_equal(contact, contact_spacing(s, cooperation, constants))
        np.testing.assert_array_equal(clear, clearances(s, cooperation, constants))
        np.testing.assert_array_equal(model, model_spacing(s, v, cooperation, constants))
        np.testing.assert_array_equal(here.closing(model), closing_speeds(model, cooperation, traffic.automated))
        automated = np.ones(n) if traffic.automated is None else traffic.automated
        np.testing.assert_array_equal(here.followed(n), followed_by(automated, cooperation.following))


def test_certified_periods_are_those_of_the_model(library: ctypes.CDLL) -> None:
    rng = np.random.default_rng(5)
    constants = PlatoonParameters()
    for _ in range(1000):
        n, by_itself = int(rng.integers(1, MOST + 1)), bool(rng.random() < 0.5)
        cooperation = random_cooperation(rng, n)
        s, v = random_vehicles(rng, n, cooperation, constants.L)
        a = rng.choice([0.0, 1.0], n, p=[0.2, 0.8]) * rng.normal(0, 3, n)
        leader = DrivenLeader(20.0, 1.0) if by_itself else None
        law = ExtendedLaw(V_OLD, constants, cooperation, leader)
        here = InC(library, constants, V_OLD, cooperation, Traffic())
        moving, foreign = Motion(0.0, s, v), automated(law, v)
        lemma1 = lemma1_period(law, moving, a)
        exact = exact_period(room(law, s), v, a, constants, foreign)
        plain = exact_period(s, v, a, constants, foreign)
        np.testing.assert_array_equal(here.periods(by_itself, s, v, a), [lemma1, exact, plain])


@pytest.mark.parametrize("n", [2, 3, MOST])
@pytest.mark.parametrize("shape", SHAPES, ids=str)
@pytest.mark.parametrize("told", [False, True])
def test_with_start_values_it_is_the_papers_law(
    library: ctypes.CDLL, n: int, shape: PotentialParameters, told: bool
) -> None:
    rng = np.random.default_rng(n)
    constants, cooperation = PlatoonParameters(), Cooperation(length=np.full(n, 5.0)) if told else None
    for _ in range(50):
        s, v = random_vehicles(rng, n, Cooperation(), constants.L)
        here = InC(library, constants, shape, cooperation, Traffic())
        same(here.command(s, v), feedback(s, v, shape, constants), shape)
        np.testing.assert_array_equal(here.command(s, v), here.command(s, v, "papers"))
        wanted = float(rng.uniform(0, 35))
        here = InC(library, constants, shape, cooperation, replace(Traffic(), v_desired=wanted))
        same(here.command(s, v), feedback_towards(s, v, shape, constants, wanted), shape)
        np.testing.assert_array_equal(here.command(s, v), here.command(s, v, "papers"))
