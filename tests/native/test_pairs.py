"""pairs.toml is true: every C file of the native FMU and every function in it is listed, all that is named exists."""

from __future__ import annotations

import ast
import re
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = ROOT / "fmu_src" / "native" / "c"
FILES = tomllib.loads((Path(__file__).parent / "pairs.toml").read_text(encoding="utf-8"))["files"]
# A definition begins a line with its type and ends it, or a later one, with what is not a semicolon.
DEFINED = re.compile(r"^(?:static |inline |const )*\w+ \*?(\w+)\([^;{}]*\)\s*\{", re.MULTILINE)
PYTHON = re.compile(r"\b(?:psp_model|fmu_src)/[\w/]+\.py\b")


@cache
def names_in(path: str) -> set[str]:
    """Functions of a Python file, those of classes behind the name of the class."""
    found = set()
    for node in ast.parse((ROOT / path).read_text(encoding="utf-8")).body:
        inner = node.body if isinstance(node, ast.ClassDef) else []
        found |= {f"{node.name}.{one.name}" for one in inner if isinstance(one, ast.FunctionDef)}
        found |= {node.name} if isinstance(node, ast.FunctionDef | ast.ClassDef) else set()
    return found


def functions_in(name: str) -> set[str]:
    """Functions that a C file defines."""
    text = (SOURCES / name).read_text(encoding="utf-8")
    return set(DEFINED.findall(text))


def test_every_hand_written_c_file_is_listed_once():
    assert sorted(entry["c"] for entry in FILES) == sorted(path.name for path in SOURCES.glob("*.c"))


@pytest.mark.parametrize("entry", FILES, ids=lambda entry: entry["c"])
def test_every_function_is_listed_and_everything_that_is_named_exists(entry: dict[str, Any]):
    listed = [name for name, _ in entry.get("pairs", [])] + entry.get("own", [])
    assert len(set(listed)) == len(listed)
    assert set(listed) == functions_in(entry["c"])
    assert bool(entry.get("pairs")) != ("alone" in entry)
    for _, mirrored in entry.get("pairs", []):
        path, name = mirrored.split("::")
        assert name in names_in(path), mirrored
    path, name = entry["test"].split("::")
    assert name in names_in(path), entry["test"]


@pytest.mark.parametrize("path", sorted(SOURCES.iterdir()), ids=lambda path: path.name)
def test_the_python_that_a_c_file_says_it_mirrors_exists(path: Path):
    text = path.read_text(encoding="utf-8")
    for named in PYTHON.findall(text):
        assert (ROOT / named).exists(), f"{path.name} names {named}"
    pairs = [entry.get("pairs", []) for entry in FILES if entry["c"] == path.name]
    mirrored = {other.split("::")[0] for entry in pairs for _, other in entry}
    if mirrored:
        assert mirrored & set(PYTHON.findall(text.split("*/")[0])), "the head of the file names what it mirrors"
