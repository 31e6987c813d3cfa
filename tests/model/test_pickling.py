"""The public objects of the model can be pickled and copied, and what they do afterwards is the same, bit for bit."""

from __future__ import annotations

import importlib
import pickle
import pkgutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from copy import copy, deepcopy
from dataclasses import fields, is_dataclass
from enum import Enum
from multiprocessing import get_context
from pathlib import Path
from shutil import copyfile
from typing import Any

import numpy as np
import pytest

import psp_model
from psp_model import (
    BEST_FIXED,
    V_OLD,
    Lemma1Policy,
    ModelError,
    ObjectiveWeights,
    PlatoonParameters,
    PlatoonState,
    PotentialParameters,
    PspError,
    SampledPlatoon,
    Sampling,
    StartDomain,
    simulate,
)
from psp_model.callbacks import silent
from psp_model.controller import BadMeasurement, ControllerSettings, Measurement, SampledController
from psp_model.membership import OpenPlatoon, Refusal
from psp_model.sampling.clock import Clock
from psp_model.sampling.hold import IDEAL
from psp_model.selection.network import ParameterNetwork, read_networks
from psp_model.selection.selectors import ParameterSource, Request
from psp_model.vehicles.ideal import IdealPlant
from psp_model.vehicles.leader import Profile, Wave

NETWORKS = Path(__file__).parents[2] / "onnx"
TRIPS: dict[str, Callable[[Any], Any]] = {"copy": copy, "deepcopy": deepcopy}
TRIPS |= {
    f"protocol {protocol}": lambda one, protocol=protocol: pickle.loads(pickle.dumps(one, protocol))
    for protocol in range(pickle.HIGHEST_PROTOCOL + 1)
}
HEARD: list[str] = []


def hear(sentence: str) -> None:
    HEARD.append(sentence)


def fixed(s: Any, v: Any) -> PotentialParameters:
    """The potential of an open platoon."""
    return BEST_FIXED


def plain(one: Any) -> Any:
    """What is equal for objects of the same content: numbers with all their bits, arrays with their shapes."""
    if isinstance(one, np.ndarray):
        return one.dtype.str, one.shape, one.tobytes()
    if isinstance(one, float):
        return type(one), float(one).hex()
    if isinstance(one, ParameterNetwork):
        return one.path, one._content
    if isinstance(one, Enum) or callable(one):
        return one
    if isinstance(one, BaseException):
        return type(one), str(one), plain(vars(one))
    if is_dataclass(one):
        return type(one), [plain(getattr(one, field.name)) for field in fields(one) if field.name != "warn"]
    if isinstance(one, Mapping):
        return {key: plain(value) for key, value in one.items()}
    return (type(one), [plain(item) for item in one]) if isinstance(one, Sequence) and not isinstance(one, str) else one


def start_of(vehicles: int, seed: int, constants: PlatoonParameters | None = None) -> PlatoonState:
    s, v = StartDomain().draw(np.random.default_rng(seed), vehicles, 1)
    return PlatoonState(s[:, 0], v[:, 0], constants or PlatoonParameters(), x_leader=-3.7)


def platoon(policy: Lemma1Policy = Lemma1Policy.ERROR, T: float = 0.01, warn: Any = hear) -> SampledPlatoon:
    """A platoon between two sampling instants; under policy 2 with T = 0.08 s it warns two periods later."""
    old = policy is Lemma1Policy.SHORTEN
    made = SampledPlatoon.begin(start_of(4, 3), V_OLD if old else BEST_FIXED, sampling=Sampling(T, policy), warn=warn)
    made.advance_to(7, 0.3)
    return made


def future(made: SampledPlatoon) -> list[Any]:
    """All that a platoon does in the next 40 periods and a bit."""
    seen: list[Any] = [made.observe(made.now.period, 0.9)]
    heard = len(HEARD)
    for period in range(made.now.period + 1, made.now.period + 40):
        made.advance_to(period, 0.37)
        seen += [made.observe(period, 0.37), made.now]
    return [*seen, HEARD[heard:]]


def controller(**settings: Any) -> SampledController:
    """A controller that has decided a few times, once on bad measurements."""
    networks = read_networks(NETWORKS, {7: "platoon_7_mse.onnx"})
    told = ControllerSettings(7, bad_input=BadMeasurement.SAFE_ACTION, a_max=3.0, **settings)
    made = SampledController.begin(told, networks, hear)
    decisions(made, range(3))
    return made


def decisions(made: SampledController, rows: range = range(3, 12)) -> list[Any]:
    seen: list[Any] = []
    for row in rows:
        s, v = StartDomain().draw(np.random.default_rng(row), 7, 1)
        n = (7, 4, 9)[row % 3]  # for 4 there is no network, and 9 are more than there are
        made.sample(0.01 * row, Measurement(s[:, 0], v[:, 0], n, resolve=row % 2, v_desired=(None, 25.0)[row % 2]))
        seen.append(made.now)
    return seen


def opened(name: str) -> ParameterNetwork:
    network = ParameterNetwork(NETWORKS / name)
    answers_of(network)
    return network


def answers_of(network: ParameterNetwork) -> list[Any]:
    n = max(network.vehicles)
    s, v = StartDomain().draw(np.random.default_rng(n), n, 1)
    asked = [network.evaluate(s[:, 0], v[:, 0]), network.candidates(s[:, 0], v[:, 0], 5)]
    return [*asked, network.domain, network.constants, network.trained_on, network.ranks, list(network.vehicles)]


def driven(plant: IdealPlant) -> Any:
    plant.advance_to(plant.period + 5, np.array([0.3, -1.0, 0.7]))
    return plant.now, plant.now.positions(), plant.period


def plant() -> IdealPlant:
    made = IdealPlant.begin(start_of(3, 8), 0.05)
    made.advance_to(3, np.array([-0.1, 0.2, 0.0]))
    return made


def open_platoon() -> OpenPlatoon:
    made, refused = OpenPlatoon.begin(platoon(), 6, fixed).insert(4, 12.0, 30.0, 7, 0.3)
    assert refused is None
    return made


def changes(made: OpenPlatoon) -> list[Any]:
    _, refused = made.insert(1, 0.5, 30.0, 7, 0.3)
    made.platoon.advance_to(20, 0.0)
    after, left = made.remove(2, 20, 0.0)
    return [refused, left, after.vehicles, future(after.platoon)]


def speeds(leader: Any) -> list[float]:
    return [leader.speed(time) for time in np.linspace(-1.0, 60.0, 50)]


def refused() -> ModelError:
    with pytest.raises(ModelError) as caught:
        platoon(T=0.5)
    return caught.value


Example = tuple[Callable[[], Any], Callable[[Any], Any]]
ITSELF: Callable[[Any], Any] = plain
EXAMPLES: dict[str, Example] = {
    "PlatoonParameters": (lambda: PlatoonParameters(L=4.1, lam=17.3), ITSELF),
    "ObjectiveWeights": (lambda: ObjectiveWeights(w1=0.1, s_ref=7.0), ITSELF),
    "PotentialParameters": (lambda: PotentialParameters(0.002, 9.7, 5.1), ITSELF),
    "PlatoonState": (lambda: start_of(7, 2), lambda made: simulate(made, BEST_FIXED, duration=0.3)),
    "StartDomain": (lambda: StartDomain(gap_min=9.0), lambda made: made.draw(np.random.default_rng(1), 4, 3)),
    "Sampling": (lambda: Sampling(0.02, Lemma1Policy.SHORTEN, 7), ITSELF),
    "Lemma1Policy": (lambda: Lemma1Policy.WARN, ITSELF),
    "ParameterSource": (lambda: ParameterSource.ROLLOUT, ITSELF),
    "BadMeasurement": (lambda: BadMeasurement.SAFE_ACTION, ITSELF),
    "ModelError": (refused, ITSELF),
    "PspError": (lambda: PspError("T = 1 s is long", "take less"), ITSELF),
    "Run": (lambda: simulate(start_of(3, 1), V_OLD, duration=0.4, output_step=0.03), lambda made: (made.J, made)),
    "SampledPlatoon": (platoon, future),
    "SampledPlatoon, policy 2": (lambda: platoon(Lemma1Policy.WARN, 0.08), future),
    "SampledPlatoon, policy 3": (lambda: platoon(Lemma1Policy.SHORTEN, 0.06), future),
    "Instant": (lambda: platoon().now, ITSELF),
    "Observation": (lambda: platoon().observe(7, 0.5), ITSELF),
    "OpenPlatoon": (open_platoon, changes),
    "Refusal": (lambda: Refusal("too near: stay away", 12.5), ITSELF),
    "Request": (lambda: Request(source=ParameterSource.ROLLOUT, rollouts=3), ITSELF),
    "ControllerSettings": (lambda: ControllerSettings(5, a_safe=-1.5), ITSELF),
    "Measurement": (lambda: Measurement(np.array([9.0]), np.array([30.0, 29.0]), 2.0), ITSELF),
    "Command": (lambda: controller().now, ITSELF),
    "SampledController": (controller, decisions),
    "SampledController, rollouts": (
        lambda: controller(request=Request(source=ParameterSource.ROLLOUT, rollouts=2, horizon=0.1)),
        decisions,
    ),
    "ParameterNetwork": (lambda: opened("platoon_any.onnx"), answers_of),
    "ParameterNetwork, not yet read": (lambda: ParameterNetwork(NETWORKS / "platoon_7_mse.onnx"), answers_of),
    "networks": (
        lambda: {7: opened("platoon_7.onnx"), 4: ParameterNetwork(NETWORKS / "platoon_4_alone.onnx")},
        lambda made: {n: answers_of(network) for n, network in made.items()},
    ),
    "Wave": (lambda: Wave(31.0, 22.0, 4.0, 30.0), speeds),
    "Profile": (lambda: Profile([0.0, 4.0, 50.0], [30.0, 21.5, 33.0], "mine"), speeds),
    "Clock": (
        lambda: Clock.begin(3.5, 0.002, 0.01).after(3.5, 0.037, 0.01),
        lambda made: made.after(3.537, 0.02, 0.01),
    ),
    "IdealPlant": (plant, driven),
    "Motion": (lambda: plant().now, lambda made: IDEAL.advance(made, np.array([1.0, 0.0, -1.0]), 0.3)),
}
"""For each public class of the model an object, and what that object does."""


@pytest.mark.parametrize("trip", TRIPS)
@pytest.mark.parametrize("name", EXAMPLES)
def test_what_arrives_does_the_same_and_leaves_the_original_alone(name: str, trip: str) -> None:
    make, does = EXAMPLES[name]
    expected = plain(does(make()))
    original = make()
    made = TRIPS[trip](original)
    assert type(made) is type(original) and plain(made) == plain(original)
    assert plain(does(made)) == expected
    if trip != "copy" or is_dataclass(original):  # a shallow copy of a dict holds the same objects
        assert plain(does(original)) == expected


OF_AN_EXTRA = ("psp_model.offline", "psp_model.selection.search", "psp_model.namespaces.casadi_symbols")


def _public_classes() -> Iterator[type]:
    """The classes that the modules of the model define, but for protocols, exceptions and what is inherited only."""
    for module in pkgutil.walk_packages(psp_model.__path__, "psp_model."):
        if module.name.startswith(OF_AN_EXTRA):
            continue
        for name, one in vars(importlib.import_module(module.name)).items():
            if isinstance(one, type) and one.__module__ == module.name and not name.startswith("_"):
                abstract = getattr(one, "_is_protocol", False) or one.__name__ == "Warns"
                if not abstract and not issubclass(one, BaseException):
                    yield one


@pytest.mark.parametrize("one", list(_public_classes()), ids=lambda one: one.__name__)
def test_every_public_class_has_an_example(one: type) -> None:
    assert one.__name__ in EXAMPLES, "give an example of it above"
    assert isinstance(EXAMPLES[one.__name__][0](), one)


@pytest.mark.parametrize("trip", TRIPS)
@pytest.mark.parametrize("name", psp_model.__all__)
def test_every_public_name(name: str, trip: str) -> None:
    one = getattr(psp_model, name)
    made = TRIPS[trip](one)
    assert made is one if callable(one) else plain(made) == plain(one)
    assert not isinstance(one, type) or name in EXAMPLES, "give an example of it above"


@pytest.mark.parametrize("seed", range(8))
def test_a_run_goes_on_bit_for_bit_wherever_it_was_interrupted(seed: int) -> None:
    rng = np.random.default_rng(seed)
    start = start_of(int(rng.integers(2, 10)), seed)
    sampling = Sampling(float(rng.uniform(0.002, 0.03)), Lemma1Policy.SHORTEN)
    interrupted, whole = (SampledPlatoon.begin(start, V_OLD, sampling=sampling) for _ in range(2))
    for period in np.cumsum(rng.integers(0, 20, 12)).tolist():
        at = (period, float(rng.uniform(0.0, 1.0)))
        trip = list(TRIPS.values())[int(rng.integers(len(TRIPS)))]
        interrupted = trip(interrupted)
        interrupted.advance_to(*at)
        whole.advance_to(*at)
        assert plain(interrupted.observe(*at)) == plain(whole.observe(*at))
        assert plain(interrupted.now) == plain(whole.now)


class Messages:
    """Keeps sentences, and cannot be pickled if what it holds cannot."""

    def __init__(self, holds: Any = None) -> None:
        self.holds, self.sentences = holds, []

    def hear(self, sentence: str) -> None:
        self.sentences.append(sentence)


def test_copies_keep_any_callback() -> None:
    for warn in (lambda sentence: None, [].append, Messages(lambda: 0).hear, hear):
        for made in (platoon(warn=warn), SampledController.begin(ControllerSettings(3), {}, warn)):
            assert copy(made).warn is deepcopy(made).warn is made.warn


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
def test_a_pickle_keeps_the_callback_where_it_can(protocol: int) -> None:
    def again(one: Any) -> Any:
        return pickle.loads(pickle.dumps(one, protocol))

    assert again(platoon()).warn is hear and again(platoon(warn=silent)).warn is silent
    with Path(__file__).open() as file:
        for warn in (lambda sentence: None, Messages(file).hear, Messages(lambda: 0).hear):
            for made in (platoon(warn=warn), SampledController.begin(ControllerSettings(3), {}, warn)):
                assert again(made).warn is silent and made.warn is warn
    messages: list[str] = []
    original = platoon(Lemma1Policy.WARN, 0.08, messages.append)
    made, heard = again((original, messages))
    before = len(heard)
    made.advance_to(60, 0.0)
    assert len(heard) > before == len(messages) == 0
    original.advance_to(60, 0.0)
    assert heard == messages


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
def test_a_callback_may_hold_the_platoon_that_calls_it(protocol: int) -> None:
    messages = Messages()
    messages.holds = made = platoon(Lemma1Policy.WARN, 0.08, messages.hear)
    again = pickle.loads(pickle.dumps(made, protocol))
    assert again.warn.__self__.holds is again and again.warn.__self__ is not messages
    assert plain(future(again)) == plain(future(made))


def test_a_read_network_no_longer_needs_its_file(tmp_path: Path) -> None:
    path = tmp_path / "mine.onnx"
    copyfile(NETWORKS / "platoon_7_mse.onnx", path)
    read, unread = ParameterNetwork(path), ParameterNetwork(path)
    expected = plain(answers_of(read))
    kept = pickle.dumps([read, unread])
    path.write_bytes(b"something else")
    read_again, unread_again = pickle.loads(kept)
    assert plain(answers_of(read_again)) == plain(answers_of(read)) == expected
    for network in (unread, unread_again, copy(unread), deepcopy(unread)):
        with pytest.raises(ModelError, match=r"mine\.onnx is not a readable ONNX file"):
            network.vehicles  # noqa: B018


def test_a_damaged_file_that_was_replaced_is_read_anew(tmp_path: Path) -> None:
    path = tmp_path / "mine.onnx"
    path.write_bytes(b"damaged")
    network = ParameterNetwork(path)
    for made in (network, pickle.loads(pickle.dumps(network)), deepcopy(network)):
        with pytest.raises(ModelError, match="undamaged"):
            made.vehicles  # noqa: B018
    copyfile(NETWORKS / "platoon_7_mse.onnx", path)
    assert plain(answers_of(network)) == plain(answers_of(ParameterNetwork(path)))


def test_copies_of_a_network_share_its_session() -> None:
    network = opened("platoon_7_mse.onnx")
    assert copy(network)._session is deepcopy({7: network})[7]._session is network._session


def test_objects_work_in_a_process_pool() -> None:
    """In processes of their own, which have nothing of this one's."""
    work: dict[str, tuple[Any, str, tuple[Any, ...]]] = {
        "platoon": (platoon(), "observe", (7, 0.5)),
        "network": (opened("platoon_7_mse.onnx"), "evaluate", (start_of(7, 1).s, start_of(7, 1).v)),
        "plant": (plant().now, "after", (np.array([1.0, 0.0, -1.0]), 0.3)),
        "leader": (Wave(31.0, 22.0), "speed", (12.0,)),
    }
    work["platoon"][0].warn = lambda sentence: None
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        for one, name, arguments in work.values():
            there = pool.submit(getattr(one, name), *arguments).result(timeout=60)
            assert plain(there) == plain(getattr(one, name)(*arguments))
