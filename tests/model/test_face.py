"""The public face of the model: typed, lists and tuples, words for potentials, objects that show themselves."""

from __future__ import annotations

import inspect
import pickle
import re
import runpy
import typing
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.typing import ArrayLike

import psp_model
from psp_model import (
    BEST_FIXED,
    V_OLD,
    BestOfRollouts,
    Braking,
    Cooperation,
    Errors,
    Fixed,
    Lemma1Policy,
    Measurement,
    ModelError,
    PlatoonParameters,
    PlatoonState,
    PotentialParameters,
    Sampling,
    StartDomain,
    Traffic,
    project_networks,
    simulate,
    simulate_many,
)
from psp_model.analysis.certificate import certify

ROOT = Path(__file__).parents[2]
S, V = [9.0, 10.5, 11.0], (30.0, 31.0, 29.0, 30.5)
OUTSIDE = [9.0, 10.5, 13.0]  # of the training domain


# typed


def says_any(hint: Any) -> bool:
    """Whether a hint has Any in it; the shape inside NumPy's arrays does not count."""
    arrays = typing.get_origin(hint) is np.ndarray
    like = typing.get_args(hint)[:2] == typing.get_args(ArrayLike)[:2] != ()
    if arrays or like or isinstance(hint, str | int):
        return False
    return hint is Any or any(map(says_any, typing.get_args(hint)))


def hints_of(function: Callable[..., Any], name: str) -> Iterator[tuple[str, Any]]:
    wanted = set(inspect.signature(function).parameters) - {"self", "cls"} | {"return"}
    found = typing.get_type_hints(function)
    for parameter in wanted:
        yield f"{name}: {parameter}", found.get(parameter, Any)


def classes_in(hint: Any) -> Iterator[type]:
    for part in (hint, typing.get_origin(hint), *typing.get_args(hint)):
        if isinstance(part, type) and part.__module__.startswith("psp_model"):
            yield part
        elif part is not hint and not isinstance(part, str | int):
            yield from classes_in(part)


def members_of(one: type) -> Iterator[tuple[str, Any]]:
    """The hints of a class's attributes, and of its methods that we wrote."""
    name = f"{one.__module__}.{one.__qualname__}"
    yield from ((f"{name}.{field}", hint) for field, hint in typing.get_type_hints(one).items() if field[0] != "_")
    for member in dir(one):
        found = inspect.getattr_static(one, member)
        for wrapped in ("__func__", "fget", "func"):
            found = getattr(found, wrapped, None) or found
        if (member[0] != "_" or member == "__init__") and _ours(found):
            yield from hints_of(found, f"{name}.{member}")


def _ours(found: Any) -> bool:
    return inspect.isfunction(found) and found.__module__.startswith("psp_model")


def reachable() -> Iterator[tuple[str, Any]]:
    """All hints that one meets from `psp_model.__all__` on."""
    seen: set[type] = set()
    waiting = []
    for name in psp_model.__all__:
        one = getattr(psp_model, name)
        if inspect.isfunction(one):
            waiting += list(hints_of(one, name))
        else:
            waiting.append((name, one if isinstance(one, type) else type(one)))
    while waiting:
        where, hint = waiting.pop()
        yield where, hint
        for one in classes_in(hint):
            if one not in seen:
                seen.add(one)
                waiting += list(members_of(one))


def test_nothing_that_one_can_reach_is_any() -> None:
    found = list(reachable())
    assert len(found) > 300
    assert not sorted({where for where, hint in found if says_any(hint)})


def test_the_walk_finds_any() -> None:
    def careless(s: list[Any], v) -> dict[str, Any]:  # type: ignore[no-untyped-def]
        return {}

    assert sum(says_any(hint) for _, hint in hints_of(careless, "careless")) == 3


def test_a_typed_script_is_accepted_by_mypy_and_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    mypy = pytest.importorskip("mypy.api")
    monkeypatch.chdir(ROOT)
    monkeypatch.setenv("MYPYPATH", str(ROOT))
    script = Path(__file__).with_name("typed_use.py")
    text = script.read_text(encoding="utf-8")
    assert "ignore[" not in text and "cast(" not in text and "Any" not in text
    out, err, status = mypy.run(["--strict", "--follow-imports=silent", str(script)])
    assert status == 0, out + err
    space = runpy.run_path(str(script))
    assert all(np.isfinite(one).all() for one in space["functions"]()) and space["refused"]() == "L"
    assert space["runs"]()[0].J > 0 and np.isfinite(space["control"]()).all()


# lists and tuples

A = [0.1, -0.2, 0.0, 0.3]
CALLS: dict[str, tuple[tuple[Any, ...], dict[str, Any]]] = {
    "potential": ((S, BEST_FIXED), {}),
    "potential_slope": ((S, V_OLD), {}),
    "feedback": ((S, V, BEST_FIXED), {}),
    "cooperative_command": (
        (S, V, BEST_FIXED),
        {"cooperation": Cooperation(kappa=1.0, length=[4.0, 9.0, 5.0, 5.0]), "traffic": Traffic([0, 1, 1, 1], A)},
    ),
    "largest_period": ((S, V, A), {}),
    "exact_period": ((S, V, A), {}),
    "uncertain_period": ((S, V, A, Errors([0.1, 0.2, 0.1], 0.1)), {"a_before": A}),
    "brake_margin": (([4.0, 5.5, 6.0], Braking(V, A, 0.2, 0.1, [-6.0] * 4)), {"automated": [0, 1, 1, 1]}),
    "rollout_costs": (((S, V), [BEST_FIXED, V_OLD]), {"horizon": 0.1}),
    "simulate": (((S, V), "fixed"), {"duration": 0.1}),
    "simulate_many": (([(S, V), (S, V)], "fixed"), {"duration": 0.1}),
}
OF_NO_ARRAYS = {"max_slope", "project", "require_feasible", "project_networks", "read_profile", "validate"}


def as_arrays(one: Any) -> Any:
    """The same with arrays in the place of lists and tuples of numbers."""
    if hasattr(one, "_fields"):
        return type(one)(*map(as_arrays, one))
    if isinstance(one, Cooperation):
        return Cooperation(one.kappa, length=as_arrays(one.length))
    if isinstance(one, list | tuple):
        numbers = all(isinstance(item, int | float) for item in one)
        return np.array(one, dtype=float) if numbers else type(one)(map(as_arrays, one))
    return one


def as_lists(one: Any) -> Any:
    """The numbers in whatever came back."""
    if isinstance(one, tuple):
        return [as_lists(part) for part in one]
    return [one.J, one.s] if hasattr(one, "J") else one


def test_every_public_function_has_a_call_here() -> None:
    functions = {name for name in psp_model.__all__ if inspect.isfunction(getattr(psp_model, name))}
    assert functions == set(CALLS) | OF_NO_ARRAYS


@pytest.mark.parametrize("name", CALLS)
def test_lists_and_tuples_do_what_arrays_do(name: str) -> None:
    arguments, named = CALLS[name]
    function = getattr(psp_model, name)
    found = function(*arguments, **named)
    expected = function(*map(as_arrays, arguments), **{key: as_arrays(value) for key, value in named.items()})
    for one, other in zip(*(map(np.asarray, _flat(part)) for part in (found, expected)), strict=True):
        assert one.dtype in (np.float64, np.bool_) and np.array_equal(one, other)


def _flat(one: Any) -> list[Any]:
    parts = as_lists(one)
    return parts if isinstance(parts, list) else [parts]


@pytest.mark.parametrize("name", ["feedback", "largest_period", "exact_period", "cooperative_command"])
def test_spacings_that_do_not_fit_the_speeds_are_refused(name: str) -> None:
    rest = (BEST_FIXED,) if name in ("feedback", "cooperative_command") else (A,)
    with pytest.raises(ModelError, match="4 spacings and 4 speeds"):
        getattr(psp_model, name)([*S, 9.0], V, *rest)
    for wrong in (["nine"], [[9.0], [9.0, 10.0]], None):
        with pytest.raises(ModelError, match="not an array of numbers"):
            getattr(psp_model, name)(wrong, V, *rest)


def test_a_measurement_takes_lists() -> None:
    assert Measurement([9], (30, 29), 2).s.dtype == np.float64


# words


@pytest.mark.parametrize("word", ["network", "fixed", "old", "rollouts"])
def test_a_word_is_the_selector_that_it_stands_for(word: str) -> None:
    start = PlatoonState(S, V)
    by_hand = {
        "network": psp_model.FromNetwork(project_networks(4)),
        "fixed": Fixed(),
        "old": psp_model.Old(),
        "rollouts": BestOfRollouts(project_networks(4), sampling=Sampling(0.05)),
    }
    sampling = Sampling(0.05, Lemma1Policy.WARN)
    run = simulate(start, word, sampling=sampling, duration=1.0)
    expected = by_hand[word].select(start.s, start.v, start.constants).potential
    assert run.potential == expected
    assert np.array_equal(run.s, simulate(start, by_hand[word], sampling=sampling, duration=1.0).s)
    assert np.array_equal(run.s, simulate((S, V), expected, sampling=sampling, duration=1.0).s)


def test_words_differ() -> None:
    found = {word: simulate((S, V), word, duration=0.1).potential for word in ("network", "fixed", "old")}
    assert found["fixed"] == BEST_FIXED and found["old"] == V_OLD and found["network"] not in (BEST_FIXED, V_OLD)


@pytest.mark.parametrize(
    ("start", "why"),
    [
        (PlatoonState(OUTSIDE, V), "outside the network's training domain"),
        (PlatoonState(S, V, PlatoonParameters(mu=0.6)), "other constants"),
        (PlatoonState([10.0] * 99, [30.0] * 100), "no network"),
    ],
)
@pytest.mark.parametrize("word", ["network", "rollouts"])
def test_where_no_network_holds_the_run_says_so(start: PlatoonState, why: str, word: str) -> None:
    run = simulate(start, word, duration=0.05)
    assert run.potential == BEST_FIXED
    (warning,) = run.warnings
    assert why in warning and warning in repr(run)


def test_the_warnings_of_policy_2_are_on_the_run() -> None:
    sampling = Sampling(0.12, Lemma1Policy.WARN)
    run = simulate((OUTSIDE, V), "network", sampling=sampling, duration=2.0)
    assert "training domain" in run.warnings[0] and run.violations > 0
    assert run.warnings[1:] == simulate((OUTSIDE, V), BEST_FIXED, sampling=sampling, duration=2.0).warnings
    assert all("(Lemma 1)" in one for one in run.warnings[1:]) and len(run.warnings) > 1
    assert f"and {len(run.warnings) - 1} more" in repr(run)
    assert pickle.loads(pickle.dumps(run)).warnings == run.warnings


@pytest.mark.parametrize("wrong", ["netwrk", "", 7, None, Fixed, [BEST_FIXED], 11.0])
def test_another_word_is_refused_with_the_words(wrong: Any) -> None:
    for call in (lambda: simulate((S, V), wrong), lambda: simulate_many([(S, V)] * 2, wrong)):
        with pytest.raises(ModelError) as caught:
            call()
        if isinstance(wrong, list) and caught.value.key == "batch_potentials":
            continue
        assert all(word in caught.value.remedy for word in ("network", "fixed", "old", "rollouts"))


@pytest.mark.parametrize("wrong", [7, None, "network", ([9.0],), ([9.0], [30.0], 1), (["a"], [30.0, 30.0])])
def test_what_is_no_start_is_refused(wrong: Any) -> None:
    for call in (lambda: simulate(wrong, "fixed"), lambda: simulate_many([(S, V), wrong, (S, V)], "fixed")):
        with pytest.raises(ModelError) as caught:
            call()
        assert caught.value.key == "start" and len(str(caught.value)) < 250


# batches


def starts(count: int, vehicles: int = 4) -> tuple[Any, Any]:
    s, v = StartDomain().draw(np.random.default_rng(count), vehicles, count)
    return s.T, v.T


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("vehicles", [2, 3, 4])
def test_all_ways_to_write_a_batch_are_the_same(count: int, vehicles: int) -> None:
    s, v = starts(count, vehicles)
    ways = [
        (s, v),
        [s.tolist(), v.tolist()],
        [PlatoonState(*pair) for pair in zip(s, v, strict=True)],
        [(one.tolist(), tuple(other)) for one, other in zip(s, v, strict=True)],
        tuple(zip(s, v, strict=True)),
    ]
    first, *others = (simulate_many(way, "network", duration=0.5) for way in ways)
    assert len(first) == count
    for other in others:
        assert np.array_equal(other.s, first.s) and other.potentials == first.potentials
    single = simulate((s[0], v[0]), "network", duration=0.5)
    assert first.potentials[0] == single.potential
    np.testing.assert_allclose(first.s[0], single.s[-1], rtol=0, atol=1e-12)


def test_a_batch_counts_its_warnings() -> None:
    s, v = starts(3, 4)
    s[1, 2] = 13.0
    many = simulate_many((s, v), "network", duration=0.1)
    (warning,) = many.warnings
    assert warning.startswith("1 of 3 starts: ") and "training domain" in warning and warning in repr(many)
    assert many.potentials[1] == BEST_FIXED != many.potentials[0]


@pytest.mark.parametrize(
    ("row", "value", "key"), [(0, 5.0, "spacing"), (2, np.nan, "finite"), (1, -3.0, "spacing_order")]
)
def test_a_start_of_a_batch_that_is_outside_is_refused_like_a_single_one(row: int, value: float, key: str) -> None:
    s, v = starts(3, 4)
    s[row, 1] = value
    with pytest.raises(ModelError) as of_batch:
        simulate_many((s, v), "old")
    with pytest.raises(ModelError) as of_one:
        simulate((s[row], v[row]), "old")
    assert str(of_batch.value) == str(of_one.value) and of_batch.value.key == key


def test_a_named_tuple_is_one_potential_for_a_batch() -> None:
    class Inverse(typing.NamedTuple):
        k: Any
        j: Any

        def value(self, s: Any, constants: PlatoonParameters) -> Any:
            return self.k / (s - constants.L)

        def slope(self, s: Any, constants: PlatoonParameters) -> Any:
            return -self.k / (s - constants.L) ** 2

    own = Inverse(20.0, 0.0)
    many = simulate_many(starts(2), own, duration=0.2)
    assert many.potentials == (own, own)


# what objects show of themselves


def test_what_is_printed_is_short() -> None:
    run = simulate((S, V), "network", duration=1.0)
    certificate = certify(run, PlatoonParameters(), 0.01)
    shown = [
        repr(PlatoonState(S, V)),
        repr(certificate),
        str(BEST_FIXED),
        str(V_OLD),
        repr(Fixed().select(S, V, PlatoonParameters())),
    ]
    assert all(len(text) < 200 and "\n" not in text and "array(" not in text for text in shown)
    assert "9 10.5 11" in shown[0] and "certified" in shown[1] and shown[3] == "V_old"
    assert "r = 11 m" in shown[2] and str(run.potential) in repr(run).splitlines()[0]
    assert max(map(len, repr(run).splitlines())) < 100 and len(repr(run).splitlines()) < 15


def test_a_potential_of_symbols_can_be_printed() -> None:
    assert "PotentialParameters" in str(PotentialParameters(np.ones(3), np.ones(3), np.ones(3)))  # type: ignore[arg-type]


@pytest.mark.parametrize("vehicles", [1, 4, 12])
def test_the_picture_names_vehicles_and_quantities(vehicles: int) -> None:
    s, v = [10.0] * (vehicles - 1), [30.0] * vehicles
    svg = ElementTree.fromstring(simulate((s, v), "fixed", duration=1.0)._repr_html_())
    text = " ".join(svg.itertext())
    assert all(word in text for word in ("spacing", "acceleration", "speed", "time [s]"))
    assert re.search(rf"\b{vehicles}\b", text) and "nan" not in ElementTree.tostring(svg, "unicode")
