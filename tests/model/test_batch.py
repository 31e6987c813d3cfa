"""A batch is so many runs: the same numbers, whichever engine makes them, and refusals that name the start."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from psp_model import (
    BEST_FIXED,
    V_OLD,
    Lemma1Policy,
    ModelError,
    ObjectiveWeights,
    PlatoonParameters,
    PlatoonState,
    Runs,
    Sampling,
    StartDomain,
    simulate,
    simulate_many,
)
from strategies import feasible_triple

WEIGHTS = ObjectiveWeights(w1=0.2, w2=1.5, a_ref=3.0, s_ref=11.0)
POTENTIALS = (V_OLD, BEST_FIXED, feasible_triple(1), feasible_triple(7), feasible_triple(12))


def starts_of(seed: int, n: int, count: int, constants: PlatoonParameters | None = None) -> list[PlatoonState]:
    s, v = StartDomain().draw(np.random.default_rng(seed), n, count)
    return [PlatoonState(s[:, k], v[:, k], constants, x_leader=100.0 * k) for k in range(count)]


def one_by_one(starts: list[PlatoonState], potentials: Any, T: float, duration: float) -> dict[str, Any]:
    """What `simulate` says of the same runs, whatever Lemma 1 does, in the columns of `Runs`."""
    found: dict[str, list[Any]] = {name: [] for name in ("s", "v", "s_min", "a_peak", "T_max", "cost")}
    for start, potential in zip(starts, potentials, strict=True):
        run = simulate(start, potential, weights=WEIGHTS, sampling=Sampling(T, Lemma1Policy.WARN), duration=duration)
        before = slice(None, -1)  # what is decided at the end is no longer held
        row = (run.s[-1], run.v[-1], run.s.min(), np.abs(run.a[before]).max(), run.T_max[before].min(), run.cost[-1])
        for column, value in zip(found.values(), row, strict=True):
            column.append(value)
    return {name: np.array(column) for name, column in found.items()}


def require_equal(many: Runs, alone: dict[str, Any], tolerance: float) -> None:
    for name, column in alone.items():
        np.testing.assert_allclose(getattr(many, name), column, rtol=tolerance, atol=tolerance, err_msg=name)
    assert many.certified.tolist() == (alone["T_max"] > many.T).tolist()
    np.testing.assert_allclose(many.J, alone["cost"].sum(axis=1), rtol=tolerance)


@given(st.integers(0, 1000), st.integers(2, 9), st.integers(1, 6), st.sampled_from([0.01, 0.013, 0.04]))
@settings(max_examples=15)
def test_a_batch_in_numpy_is_one_run_after_the_other(seed: int, n: int, count: int, T: float) -> None:
    starts = starts_of(seed, n, count)
    potentials = [POTENTIALS[1 + (seed + k) % 4] for k in range(count)]
    many = simulate_many(starts, potentials, weights=WEIGHTS, T=T, duration=50 * T, compiled=False)
    require_equal(many, one_by_one(starts, potentials, T, 50 * T), 1e-12)
    assert len(many) == count and many.potentials == tuple(potentials)


@pytest.mark.parametrize("potential", [V_OLD, BEST_FIXED], ids=["V_old", "V_new"])
@pytest.mark.parametrize("compiled", [False, True], ids=["numpy", "compiled"])
@pytest.mark.parametrize("n", [2, 7])
def test_both_engines_give_the_runs_of_simulate(n: int, compiled: bool, potential: Any) -> None:
    if compiled:
        pytest.importorskip("casadi")
        pytest.importorskip("ziglang")
    starts = starts_of(n, n, 9)
    many = simulate_many(starts, potential, weights=WEIGHTS, T=0.01, duration=4.0, compiled=compiled)
    require_equal(many, one_by_one(starts, [potential] * 9, 0.01, 4.0), 1e-9 if compiled else 1e-12)


def test_the_compiled_engine_takes_a_potential_for_each_start_and_other_constants() -> None:
    pytest.importorskip("casadi")
    pytest.importorskip("ziglang")
    constants = PlatoonParameters(L=4.5, v_star=29.0, mu=0.8, epsilon=0.3)
    starts = starts_of(5, 5, 5, constants)
    many = simulate_many(starts, POTENTIALS, weights=WEIGHTS, T=0.02, duration=3.0, compiled=True)
    require_equal(many, one_by_one(starts, POTENTIALS, 0.02, 3.0), 1e-9)


@dataclass(frozen=True)
class Inverse:
    """k / (s - L), a potential of somebody's own; its fields are arrays in a batch."""

    k: Any

    def value(self, s: Any, constants: PlatoonParameters) -> Any:
        return self.k / (s - constants.L)

    def slope(self, s: Any, constants: PlatoonParameters) -> Any:
        return -self.k / (s - constants.L) ** 2


@pytest.mark.parametrize("compiled", [None, False, True])
def test_a_potential_of_ones_own_runs_in_numpy_whatever_is_asked_for(compiled: bool | None) -> None:
    starts, own = starts_of(3, 4, 5), [Inverse(float(k)) for k in (10, 20, 30, 40, 50)]
    many = simulate_many(starts, own, weights=WEIGHTS, duration=0.8, compiled=compiled)
    require_equal(many, one_by_one(starts, own, 0.01, 0.8), 1e-12)
    together = simulate_many(starts, own[1], weights=WEIGHTS, duration=0.8)
    assert np.array_equal(together.s[1], many.s[1]) and not np.array_equal(together.s[0], many.s[0])


def test_a_run_of_no_time_is_its_start() -> None:
    starts = starts_of(1, 3, 2)
    many = simulate_many(starts, V_OLD, duration=0.0, compiled=False)
    assert np.array_equal(many.s, [start.s for start in starts]) and many.J.tolist() == [0.0, 0.0]
    assert many.certified.all() and np.isinf(many.T_max).all() and many.a_peak.tolist() == [0.0, 0.0]
    assert np.array_equal(many.s_min, [start.s.min() for start in starts])


def test_what_a_batch_gives_and_what_it_was_given_cannot_be_written_to_by_mistake() -> None:
    s, v = (part.T.copy() for part in StartDomain().draw(np.random.default_rng(1), 3, 4))
    kept = s.copy(), v.copy()
    many = simulate_many((s, v), V_OLD, duration=0.1, compiled=False)
    assert np.array_equal(s, kept[0]) and np.array_equal(v, kept[1]) and s.flags.writeable
    for column in (many.s, many.v, many.s_min, many.a_peak, many.T_max, many.cost):
        with pytest.raises(ValueError, match="read-only"):
            column[0] = 1.0


FINE = starts_of(2, 3, 2)
REFUSED: dict[str, tuple[Any, Any, dict[str, Any], str, str]] = {
    "none": ([], V_OLD, {}, "batch_empty", "at least one"),
    "another number of vehicles": ([*FINE, *starts_of(1, 4, 1)], V_OLD, {}, "batch_starts", "start 3, with 4 vehicles"),
    "a lone vehicle": ([PlatoonState([], [30.0])], V_OLD, {}, "batch_starts", "at least 2"),
    "other constants": (
        [FINE[0], PlatoonState(FINE[1].s, FINE[1].v, PlatoonParameters(mu=0.7))],
        V_OLD,
        {},
        "batch_starts",
        "same constants",
    ),
    "too few potentials": (FINE, [V_OLD], {}, "batch_potentials", "1 potentials do not fit 2 starts"),
    "too many": (FINE, [V_OLD] * 3, {}, "batch_potentials", "3 potentials"),
    "outside": ([FINE[0], PlatoonState([4.0, 9.0], [30.0] * 3)], V_OLD, {}, "spacing", "L = 5 m"),
    "no period": (FINE, V_OLD, {"T": 0.0}, "T", "above 0 s"),
    "a period without end": (FINE, V_OLD, {"T": np.inf}, "T", "above 0 s"),
    "backwards": (FINE, V_OLD, {"duration": -1.0}, "duration", "0 s or more"),
    "for ever": (FINE, V_OLD, {"duration": np.inf}, "duration", "finite"),
    "weights": (FINE, V_OLD, {"weights": ObjectiveWeights(w1=-1.0)}, "w1", "must not be negative"),
}


@pytest.mark.parametrize("case", REFUSED)
@pytest.mark.parametrize("compiled", [False, None])
def test_a_batch_that_does_not_go_together_is_one_sentence(case: str, compiled: bool | None) -> None:
    starts, potential, named, key, words = REFUSED[case]
    with pytest.raises(ModelError, match=words) as caught:
        simulate_many(starts, potential, compiled=compiled, **named)
    assert caught.value.key == key and caught.value.remedy


def test_the_table_of_a_batch_says_the_worst_and_the_mean() -> None:
    starts = starts_of(4, 5, 40)
    many = simulate_many(starts, BEST_FIXED, T=0.03, duration=2.0, compiled=False)
    lines = repr(many).splitlines()
    assert lines[0].startswith("40 runs of 5 vehicles") and str(many) == repr(many)
    shown = {
        line.split("  ")[1].strip(): line.split()[-2 if line[-1].isalpha() or line[-1] == "²" else -1]
        for line in lines[1:]
    }
    expected = {
        "smallest spacing, worst": many.s_min.min(),
        "peak |acceleration|, worst": many.a_peak.max(),
        "J, mean": many.J.mean(),
        "J, 95 %": np.quantile(many.J, 0.95),
        "smallest T_max, worst": many.T_max.min(),
        "certified throughout": many.certified.sum(),
    }
    assert shown.keys() == expected.keys()
    for name, value in expected.items():
        assert float(shown[name]) == pytest.approx(float(value), rel=1e-3), name
