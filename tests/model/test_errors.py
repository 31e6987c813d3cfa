"""Every error that a user can cause has one root, says problem and remedy, and survives being pickled and copied."""

from __future__ import annotations

import ast
import builtins
import importlib
import pickle
import pkgutil
import re
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from copy import copy, deepcopy
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import build_fmu
from fmu_src import errors as of_the_fmus
from psp_model import (
    BEST_FIXED,
    V_OLD,
    ModelError,
    PlatoonParameters,
    PlatoonState,
    PspError,
    Sampling,
    require_feasible,
    simulate,
    validate,
)
from psp_model.errors import SENTENCES, TableError, parts_of
from psp_model.offline.start_files import read_starts
from psp_model.selection.network import ParameterNetwork
from psp_model.vehicles.leader import read_profile

ROOT = Path(__file__).parents[2]
PACKAGES = ("psp_model", "fmu_src", "psp_cli", "psp_view", "psp_traffic")
FILES = [*(path for package in PACKAGES for path in (ROOT / package).rglob("*.py")), ROOT / "build_fmu.py"]
TRIPS: dict[str, Callable[[Any], Any]] = {"copy": copy, "deepcopy": deepcopy}
TRIPS |= {
    f"protocol {protocol}": lambda error, protocol=protocol: pickle.loads(pickle.dumps(error, protocol))
    for protocol in range(pickle.HIGHEST_PROTOCOL + 1)
}
TABLES = {ModelError: SENTENCES, of_the_fmus.FmiError: of_the_fmus.SENTENCES}
ROOTS = {PspError, TableError}  # not raised themselves


def _exceptions() -> Iterator[tuple[str, str]]:
    """Module and name of each exception class, by the text of the files: nothing is imported to find them."""
    for path in FILES:
        text = path.read_text(encoding="utf-8")
        for name in re.findall(
            r"^class (\w+)\(.*(?:Error|Exception|Interrupt|Exit|Warning)\b.*\):", text, re.MULTILINE
        ):
            yield ".".join(path.relative_to(ROOT).with_suffix("").parts), name


EARLY = {("fmu_src.python.surroundings", "Unsuitable")}
"""Raised before the model can be imported; pythonfmu passes on its text, and the launcher logs that."""

EXCEPTIONS = sorted(set(_exceptions()) - EARLY)


def examples(found: type[PspError]) -> list[PspError]:
    """Errors of a class; one that is made in a way of its own needs an example here."""
    if found in ROOTS:
        return [PspError("a problem: a remedy")]
    if issubclass(found, TableError):
        return [found(key, *values_for(sentence)) for key, sentence in found.sentences.items()]
    return [found("T = 1 s is long: take less"), found("a: b in {x}: %s", "do this: or that"), found("no remedy")]


def values_for(sentence: str) -> list[Any]:
    """What fills a sentence; numbers are NumPy's, as the model's are."""
    samples = {"%.10g": np.float64(0.1), "%d": np.int64(3), "%s": "a: b %d"}
    return [samples[conversion] for conversion in re.findall(r"%(?:\.10g|d|s)", sentence.replace("%%", ""))]


def test_every_exception_of_the_packages_is_among_them() -> None:
    walked = set()
    for package in PACKAGES:
        for module in pkgutil.walk_packages(importlib.import_module(package).__path__, f"{package}."):
            if module.name.endswith("__main__"):
                continue
            try:
                classes = vars(importlib.import_module(module.name)).values()
            except ModuleNotFoundError as error:  # of an extra that is not installed
                assert error.name and error.name.partition(".")[0] not in PACKAGES, module.name
                continue
            walked |= {
                (one.__module__, one.__qualname__)
                for one in classes
                if isinstance(one, type) and issubclass(one, BaseException) and one.__module__ == module.name
            }
    assert walked <= set(EXCEPTIONS) | EARLY, walked - set(EXCEPTIONS)
    assert len(EXCEPTIONS) >= 9


@pytest.mark.parametrize("trip", TRIPS)
@pytest.mark.parametrize(("module", "name"), EXCEPTIONS)
def test_an_exception_arrives_as_what_it_is(module: str, name: str, trip: str) -> None:
    found = getattr(importlib.import_module(module), name)
    assert issubclass(found, PspError), "what a user can cause derives from the one root"
    for error in examples(found):
        error.add_note("a note")
        error.seen = [1, 2]  # type: ignore[attr-defined]
        made = TRIPS[trip](error)
        assert made is not error and type(made) is type(error)
        assert (str(made), repr(made), made.args) == (str(error), repr(error), error.args)
        assert vars(made) == vars(error) and {"problem", "remedy"} <= vars(made).keys()
        assert (made.key, made.values) == (error.key, error.values)


@pytest.mark.parametrize("trip", TRIPS)
def test_an_error_inside_an_error_arrives_too(trip: str) -> None:
    cause = ModelError("stale", 0.3, 0.25)
    error = ModelError("safe_action", 1.5, cause)
    made = TRIPS[trip](error)
    assert str(made) == str(error) == f"the fail-safe command is given at t = 1.5 s: {cause}"
    assert made.remedy == cause.remedy and made.problem.endswith(cause.problem)
    assert made.values[1].key == "stale" and made.values[1].values == (0.3, 0.25)


def test_subclasses_of_what_they_were_before() -> None:
    from psp_model.offline.errors import OfflineError
    from psp_traffic.results import ResultsError

    assert all(issubclass(one, ValueError) for one in (ModelError, OfflineError, ResultsError))
    assert issubclass(of_the_fmus.BuildError, RuntimeError)


@pytest.mark.parametrize(("table", "key"), [(table, key) for table, keys in TABLES.items() for key in keys])
def test_every_sentence_has_one_problem_and_one_remedy(table: type[TableError], key: str) -> None:
    sentence = TABLES[table][key]
    assert sentence.count(": ") == 1 and "; " not in sentence, "problem: remedy, and nothing else"
    problem, remedy = parts_of(sentence)
    assert problem.strip() == problem != "" and remedy.strip() == remedy != ""
    error = table(key, *values_for(sentence))
    assert (error.key, f"{error.problem}: {error.remedy}") == (key, str(error))
    assert "%" not in sentence.replace("%%", "") or error.values
    assert {type(value) for value in error.values} <= {int, float, str}


def test_tables_share_no_key() -> None:
    keys = [key for sentences in TABLES.values() for key in sentences]
    assert len(keys) == len(set(keys))


def test_a_value_with_a_colon_does_not_move_the_remedy() -> None:
    error = ModelError("network_missing", "a: b.onnx", "no: such file")
    assert error.problem == "the network file a: b.onnx cannot be read (no: such file)"
    assert error.remedy == "put it back, or use parameter_source 2"
    assert of_the_fmus.BuildError("x: y is bad", "do: this").remedy == "do: this"


@pytest.mark.parametrize("excess", [1e-12, float(np.spacing(35.0))])
def test_values_are_the_numbers_not_their_text(excess: float) -> None:
    with pytest.raises(PspError) as caught:
        validate(PlatoonState(np.array([9.0]), np.array([30.0, 35.0 + excess])))
    assert caught.value.values == (2, 35.0 + excess, 35.0, 2) and "35.0000" in caught.value.problem


CAUGHT = {
    ("network.py", "ValueError"): "becomes network_metadata",
    ("whole_file.py", "ValueError"): "whoever reads the file says which one it is",
    ("fit.py", "ValueError"): "becomes an OfflineError in the same function",
    ("doctor.py", "ValueError"): "becomes a line of the doctor's",
    ("onnx_graph.py", "ValueError"): "becomes a BuildError in tables.py",
    ("tables.py", "ValueError"): "a defect of the table of variables, not of a user",
    ("public.py", "TypeError"): "becomes numbers in the same function",
    ("table_slave.py", "NotImplementedError"): "a defect of a subclass",
    ("state_check.py", "ValueError"): "becomes the FMU's sentence on states that no run can come to",
    ("results.py", "KeyError"): "becomes an InputError in psp simulate",
}
"""Built-in exceptions that are raised, by file, and why no user sees them."""


def _raised(path: Path) -> Iterator[tuple[ast.Raise, str, ast.Call | None]]:
    """Each `raise` with something new: the statement, the name of what is raised, and the call that makes it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Raise) and node.exc is not None:
            call = node.exc if isinstance(node.exc, ast.Call) else None
            yield node, ast.unparse(call.func if call else node.exc), call


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_what_is_raised_is_of_the_one_root_and_has_a_remedy(path: Path) -> None:
    known = {name for _, name in EXCEPTIONS} | {"BadInput"}
    early = {name for _, name in EARLY}
    for node, name, call in _raised(path):
        where = f"{path.relative_to(ROOT)}:{node.lineno}: raise {name}"
        if name in early:
            continue
        if isinstance(getattr(builtins, name, None), type):
            assert (path.name, name) in CAUGHT, f"{where}: a user's error derives from PspError; a caught one is listed"
        if call is None or name not in known or name in {one.__name__ for one in TABLES} or len(call.args) >= 2:
            continue
        text = "".join(
            part.value for part in ast.walk(call) if isinstance(part, ast.Constant) and isinstance(part.value, str)
        )
        assert ": " in text, f"{where} has no remedy"


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_keys_are_of_the_table_that_the_error_looks_into(path: Path) -> None:
    tables = {table.__name__: sentences for table, sentences in TABLES.items()}
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call) and ast.unparse(node.func) in tables and isinstance(node.args[0], ast.Constant):
            where = f"{path.relative_to(ROOT)}:{node.lineno}: {ast.unparse(node)}"
            assert node.args[0].value in tables[ast.unparse(node.func)], where


def local(call: Callable[..., Any], *args: Any, **kwargs: Any) -> PspError:
    with pytest.raises(PspError) as caught:
        call(*args, **kwargs)
    return caught.value


def test_a_refusal_in_a_process_pool_arrives_as_what_it_is(tmp_path: Path) -> None:
    start = PlatoonState(np.array([9.0, 8.0]), np.array([30.0, 31.0, 29.5]))
    network = tmp_path / "no: such.onnx"
    (tmp_path / "starts.csv").write_text("s_2,v_1,v_2\n4,30,30\n", encoding="utf-8")
    refused: list[tuple[Callable[..., Any], tuple[Any, ...], dict[str, Any]]] = [
        (simulate, (start, V_OLD), {"sampling": Sampling(T=0.5)}),
        (simulate, (start, BEST_FIXED), {"duration": -1.0}),
        (validate, (PlatoonState([9.0, np.nan], [30.0, 30.0, 30.0]),), {}),
        (validate, (PlatoonParameters(lam=7.5),), {}),
        (require_feasible, (V_OLD, PlatoonParameters()), {}),
        (ParameterNetwork(network).evaluate, (start.s, start.v), {}),
        (read_profile, (tmp_path / "none.csv",), {}),
        (read_starts, (tmp_path / "starts.csv",), {}),
        (build_fmu.build, (build_fmu.parse(["--component", "plant", "--profile", "a.csv"]), {}), {}),
    ]
    keys = set()
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        runs = [pool.submit(call, *args, **kwargs) for call, args, kwargs in refused]
        well = pool.submit(simulate, start, BEST_FIXED, duration=0.5)
        for run, (call, args, kwargs) in zip(runs, refused, strict=True):
            here, there = local(call, *args, **kwargs), run.exception(timeout=60)
            assert type(there) is type(here) and str(there) == str(here)
            assert isinstance(there, PspError) and repr(vars(there)) == repr(vars(here)) and repr(there) == repr(here)
            keys.add(there.key)
        assert well.result(timeout=60).J == simulate(start, BEST_FIXED, duration=0.5).J
    assert {"lemma1_fast", "duration", "finite", "lambda", "network_missing", "profile_file", None} <= keys
