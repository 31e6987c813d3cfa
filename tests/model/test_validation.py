"""Every value outside the model's domain is refused at once, in one sentence with value, unit, limit and remedy."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fmu_src.errors import FmiError
from psp_model import (
    BEST_FIXED,
    Lemma1Policy,
    ModelError,
    ObjectiveWeights,
    PlatoonParameters,
    PlatoonState,
    Sampling,
    simulate,
)
from psp_model.errors import SENTENCES, TableError
from psp_model.law.potential import V_OLD
from psp_model.validate import validate

NAN, INF, TINY = float("nan"), float("inf"), 5e-324
GAPS, SPEEDS = [9.0, 9.0], [30.0, 30.0, 30.0]


def refused(make: Callable[[], Any]) -> ModelError:
    with pytest.raises(ModelError) as caught:
        validate(make())
    sentence = str(caught.value)
    assert "\n" not in sentence and ": " in sentence and not sentence.endswith("."), sentence
    return caught.value


CONSTANTS = [
    ({"L": 0.0}, "L", ["L = 0 m", "positive", "above 0 m"]),
    ({"L": -5.0}, "L", ["L = -5 m", "positive"]),
    ({"lam": 8.0}, "lambda", ["lambda = 8 m", "L + 3 m = 8 m", "raise lambda or lower L"]),
    ({"lam": -1.0}, "lambda", ["lambda = -1 m", "8 m"]),
    ({"v_max": 0.0}, "v_max", ["v_max = 0 m/s", "positive"]),
    ({"v_max": -1.0}, "v_max", ["v_max = -1 m/s"]),
    ({"v_star": 0.0}, "v_star_backwards", ["v_star = 0 m/s", "v_max = 35 m/s", "above 0 m/s"]),
    ({"v_star": 35.0}, "v_star", ["v_star = 35 m/s", "strictly", "v_max = 35 m/s", "lower v_star or raise v_max"]),
    ({"v_star": -1.0}, "v_star_backwards", ["v_star = -1 m/s", "above 0 m/s"]),
    ({"epsilon": 0.0}, "epsilon", ["epsilon = 0 m/s2", "positive"]),
    ({"mu": 0.0}, "mu", ["mu = 0 1/s", "positive"]),
    ({"mu": -0.5}, "mu", ["mu = -0.5 1/s"]),
    ({"z": 0.0}, "z", ["z = 0 m/s2", "positive"]),
]


@pytest.mark.parametrize(("values", "key", "words"), CONSTANTS)
def test_constants(values: dict[str, float], key: str, words: list[str]) -> None:
    error = refused(lambda: PlatoonParameters(**values))
    assert error.key == key
    assert all(word in str(error) for word in words), str(error)


UNITS = {"L": "m", "lam": "m", "v_star": "m/s", "v_max": "m/s", "epsilon": "m/s2", "mu": "1/s", "z": "m/s2"}
WEIGHT_UNITS = {"w1": "1", "w2": "1", "a_ref": "m/s2", "s_ref": "m"}
SHAPE_UNITS = {"alpha": "1", "r": "m", "p": "1"}
FIELDS: list[tuple[Callable[..., Any], str, str]] = [
    *((PlatoonParameters, name, unit) for name, unit in UNITS.items()),
    *((ObjectiveWeights, name, unit) for name, unit in WEIGHT_UNITS.items()),
    *((partial(replace, BEST_FIXED), name, unit) for name, unit in SHAPE_UNITS.items()),
    (Sampling, "T", "s"),
]


@pytest.mark.parametrize("value", [NAN, INF, -INF])
@pytest.mark.parametrize(("make", "name", "unit"), FIELDS, ids=[name for _, name, _ in FIELDS])
def test_not_a_finite_number(make: Callable[..., Any], name: str, unit: str, value: float) -> None:
    error = refused(lambda: make(**{name: value}))
    shown = {"lam": "lambda"}.get(name, name)
    assert error.key == "finite"
    assert str(error) == f"{shown} must be a finite number, not {value:g}: give it a value in {unit}"


def test_the_smallest_values_that_hold() -> None:
    validate(PlatoonParameters(L=TINY, epsilon=TINY, mu=TINY, z=TINY))
    validate(PlatoonParameters(lam=float(np.nextafter(8.0, 9.0)), v_star=float(np.nextafter(35.0, 0.0))))
    validate(PlatoonParameters(v_star=TINY))
    validate(ObjectiveWeights(w1=0.0, w2=0.0, a_ref=TINY, s_ref=TINY))
    validate(Sampling(T=TINY, max_short_periods=1))
    validate(PlatoonState(np.array([np.nextafter(5.0, 6.0)]), np.array([0.0, 35.0])))
    validate(PlatoonState(np.array([]), np.array([30.0])))


@pytest.mark.parametrize(
    ("values", "key", "words"),
    [
        ({"w1": -0.1}, "w1", ["w1 = -0.1", "negative", "0 or more"]),
        ({"w2": -TINY}, "w2", ["w2 = ", "negative"]),
        ({"a_ref": 0.0}, "a_ref", ["a_ref = 0 m/s2", "positive"]),
        ({"s_ref": -2.0}, "s_ref", ["s_ref = -2 m ", "positive"]),
    ],
)
def test_weights(values: dict[str, float], key: str, words: list[str]) -> None:
    error = refused(lambda: ObjectiveWeights(**values))
    assert error.key == key
    assert all(word in str(error) for word in words), str(error)


@pytest.mark.parametrize(
    ("values", "key", "words"),
    [
        ({"T": 0.0}, "T", ["T = 0 s", "positive", "above 0 s"]),
        ({"T": -0.01}, "T", ["T = -0.01 s"]),
        ({"policy": 0}, "choice", ["lemma1_policy = 0", "1 to 3"]),
        ({"policy": 4}, "choice", ["lemma1_policy = 4", "1 to 3"]),
        ({"certificate": 0}, "choice", ["certificate = 0", "1 to 2"]),
        ({"certificate": 3}, "choice", ["certificate = 3", "1 to 2"]),
        ({"max_short_periods": 0}, "count", ["max_short_periods = 0", "at least 1"]),
    ],
)
def test_sampling(values: dict[str, Any], key: str, words: list[str]) -> None:
    error = refused(lambda: Sampling(**values))
    assert error.key == key
    assert all(word in str(error) for word in words), str(error)


def test_a_policy_may_be_given_by_its_number() -> None:
    assert validate(Sampling(policy=3)).policy == Lemma1Policy.SHORTEN
    short = simulate(PlatoonState([5.02, 9.0], SPEEDS), V_OLD, sampling=Sampling(policy=3), duration=0.1)
    assert short.violations > 0


STATES = [
    ([5.0, 9.0], SPEEDS, "spacing", ["s[2] = 5 m", "exceed L = 5 m", "lower L"]),
    ([9.0, -3.0], SPEEDS, "spacing_order", ["s[3] = -3 m", "vehicle 3 behind vehicle 2"]),
    (GAPS, [30.0, 35.5, 30.0], "speed", ["v[2] = 35.5 m/s", "[0, 35] m/s", "vehicle 2"]),
    (GAPS, [-0.1, 30.0, 30.0], "speed_backwards", ["v[1] = -0.1 m/s", "[0, 35] m/s", "vehicle 1 at 0 m/s or more"]),
    (GAPS, [30.0, 30.0, NAN], "finite", ["v_start[3]", "not nan", "m/s"]),
    ([NAN, 9.0], SPEEDS, "finite", ["s_start[2]", "not nan", "in m"]),
    ([9.0, INF], SPEEDS, "finite", ["s_start[3]", "not inf"]),
    (GAPS, [30.0, 30.0], "shape", ["2 spacings", "2 speeds", "n - 1"]),
    ([[9.0, 9.0]], SPEEDS, "shape", ["2 spacings", "3 speeds"]),
    ([], [], "shape", ["0 spacings", "0 speeds"]),
]


@pytest.mark.parametrize(("s", "v", "key", "words"), STATES)
def test_states(s: list[float], v: list[float], key: str, words: list[str]) -> None:
    error = refused(lambda: PlatoonState(np.array(s), np.array(v)))
    assert error.key == key
    assert all(word in str(error) for word in words), str(error)


@pytest.mark.parametrize("x", [NAN, INF])
def test_position_of_the_leader(x: float) -> None:
    assert "x_start" in str(refused(lambda: PlatoonState(np.array(GAPS), np.array(SPEEDS), x_leader=x)))


def test_limits_follow_the_constants() -> None:
    wide = PlatoonParameters(L=2.0, v_max=50.0)
    validate(PlatoonState(np.array([2.5]), np.array([40.0, 50.0]), wide))
    assert "L = 2 m" in str(refused(lambda: PlatoonState(np.array([2.0]), np.array([1.0, 1.0]), wide)))
    assert "[0, 50] m/s" in str(refused(lambda: PlatoonState(np.array([3.0]), np.array([1.0, 51.0]), wide)))


@pytest.mark.parametrize(
    ("arguments", "key"),
    [
        *(({"duration": value}, "duration") for value in (NAN, INF, -1.0)),
        *(({"output_step": value}, "output_step") for value in (NAN, INF, -0.1, 0.0)),
    ],
)
def test_length_and_output_step_of_a_run(arguments: dict[str, float], key: str) -> None:
    start = PlatoonState(np.array(GAPS), np.array(SPEEDS))
    assert refused(lambda: simulate(start, BEST_FIXED, **arguments)).key == key  # type: ignore[arg-type]


def test_a_run_of_0_s_shows_the_start() -> None:
    run = simulate(PlatoonState(np.array(GAPS), np.array(SPEEDS)), BEST_FIXED, duration=0.0)
    assert run.time.tolist() == [0.0] and run.J == 0.0 and run.s[0].tolist() == GAPS


def test_frozen_values_cannot_be_changed_afterwards() -> None:
    frozen = [(PlatoonParameters(), "L"), (ObjectiveWeights(), "w1"), (BEST_FIXED, "p"), (Sampling(), "T")]
    for instance, name in frozen:
        with pytest.raises(AttributeError):
            setattr(instance, name, -1.0)
    spacings = np.array(GAPS)
    start = PlatoonState(spacings, np.array(SPEEDS))
    spacings[0] = 0.0
    assert start.s[0] == GAPS[0]
    for array in (start.s, start.v):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


@pytest.mark.parametrize("kind", [list, tuple, np.array])
def test_a_state_takes_lists_tuples_and_arrays(kind: Callable[[list[float]], Any]) -> None:
    start = validate(PlatoonState(kind(GAPS), kind(SPEEDS)))
    assert start.s.tolist() == GAPS and start.v.dtype == np.float64


@pytest.mark.parametrize("excess", [1e-10, 1e-12, float(np.spacing(35.0))])
def test_numbers_that_differ_never_look_alike(excess: float) -> None:
    """Without care the sentence would say that 35 m/s does not lie in [0, 35] m/s."""
    sentence = str(refused(lambda: PlatoonState(np.array(GAPS), np.array([30.0, 35.0 + excess, 30.0]))))
    shown = re.search(r"v\[2\] = (\S+) m/s must lie in \[0, (\S+)\]", sentence)
    assert shown and float(shown[1]) == 35.0 + excess and float(shown[2]) == 35.0, sentence


def test_numbers_are_rounded_where_that_hides_nothing() -> None:
    sentence = str(refused(lambda: PlatoonState(np.array([4.1, 9.0]), np.array(SPEEDS))))
    assert sentence.startswith("spacing s[2] = 4.1 m must exceed L = 5 m")
    assert str(ModelError("finite", "T", NAN, "s")) == "T must be a finite number, not nan: give it a value in s"


ROOT = Path(__file__).parents[2]
FORMAT = re.compile(r"%(?:\.10g|d|s|%)")
TABLES: tuple[type[TableError], ...] = (ModelError, FmiError)


@pytest.mark.parametrize(("table", "key"), [(table, key) for table in TABLES for key in table.sentences])
def test_every_sentence_formats_in_python_and_in_c(table: type[TableError], key: str) -> None:
    sentence = table.sentences[key]
    assert re.findall("%", FORMAT.sub("", sentence)) == [], "only %.10g, %d, %s and %% mean the same in both"
    samples: dict[str, Any] = {"%.10g": 1.5, "%d": 3, "%s": "name"}
    values = [samples[conversion] for conversion in FORMAT.findall(sentence) if conversion != "%%"]
    text = str(table(key, *values))
    assert "%" not in text and "\n" not in text
    assert re.search(r"[:,(] ?\S", text) and not text.endswith("."), text


@pytest.mark.parametrize("key", SENTENCES | FmiError.sentences)
def test_every_sentence_is_used(key: str) -> None:
    python = [path for folder in ("psp_model", "fmu_src") for path in (ROOT / folder).rglob("*.py")]
    sources = {path: path.read_text(encoding="utf-8") for path in python if path.name != "errors.py"}
    in_python = any(f'"{key}"' in text for text in sources.values())
    c_files = [path for pattern in ("*.c", "*.h") for path in (ROOT / "fmu_src").rglob(pattern)]
    in_c = any(re.search(rf"\bPSP_SENTENCE_{key}\b", path.read_text(encoding="utf-8")) for path in c_files)
    assert in_python or in_c
