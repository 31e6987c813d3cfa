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
from class_examples import EXAMPLES, answers_of, future, hear, opened, plant, platoon, start_of
from psp_model import V_OLD, Lemma1Policy, ModelError, SampledPlatoon, Sampling
from psp_model.callbacks import silent
from psp_model.controller import ControllerSettings, SampledController
from psp_model.selection.network import ParameterNetwork
from psp_model.vehicles.leader import Wave
from road_examples import ROAD_LAW, SEEN, remembered

NETWORKS = Path(__file__).parents[2] / "onnx"
TRIPS: dict[str, Callable[[Any], Any]] = {"copy": copy, "deepcopy": deepcopy}
TRIPS |= {
    f"protocol {protocol}": lambda one, protocol=protocol: pickle.loads(pickle.dumps(one, protocol))
    for protocol in range(pickle.HIGHEST_PROTOCOL + 1)
}


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
    names = {one.__name__, ".".join(f"{one.__module__}.{one.__name__}".split(".")[-2:])}
    made = [make() for name, (make, _) in EXAMPLES.items() if name in names]
    assert any(isinstance(example, one) for example in made), "give an example of it above"


@pytest.mark.parametrize("trip", TRIPS)
@pytest.mark.parametrize("name", psp_model.__all__)
def test_every_public_name(name: str, trip: str) -> None:
    one = getattr(psp_model, name)
    made = TRIPS[trip](one)
    assert made is one if callable(one) else plain(made) == plain(one)
    abstract = getattr(one, "_is_protocol", False)
    assert not isinstance(one, type) or abstract or name in EXAMPLES, "give an example of it above"


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
        "plant": (plant(), "advanced_to", (7, np.array([1.0, 0.0, -1.0]))),
        "law for the road": (ROAD_LAW, "sample", (remembered(), SEEN)),
        "leader": (Wave(31.0, 22.0), "speed", (12.0,)),
    }
    work["platoon"][0].warn = lambda sentence: None
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        for one, name, arguments in work.values():
            there = pool.submit(getattr(one, name), *arguments).result(timeout=60)
            assert plain(there) == plain(getattr(one, name)(*arguments))
