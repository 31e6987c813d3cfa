"""The assurance page names tests that exist, and the explained mutants are lines that exist."""

from __future__ import annotations

import ast
import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "assurance.md").read_text(encoding="utf-8")
NAMED = sorted(set(re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", PAGE)))
PROMISES = re.findall(r"^\| P(\d+) \| (.+) \|$", PAGE, re.MULTILINE)
MUTANTS = tomllib.loads((ROOT / "tests/assurance/equivalent_mutants.toml").read_text(encoding="utf-8"))["mutant"]


@pytest.mark.parametrize(("path", "test"), NAMED)
def test_a_test_that_the_page_names_exists(path: str, test: str) -> None:
    tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
    functions = [node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == test]
    assert len(functions) == 1
    assert not any("skip" in ast.unparse(decorator) for decorator in functions[0].decorator_list)


def test_every_promise_has_a_test() -> None:
    assert [int(number) for number, _ in PROMISES] == list(range(1, len(PROMISES) + 1))
    assert len(PROMISES) > 10
    for number, row in PROMISES:
        assert row.count("|") == 2 and "::test_" in row.rpartition("|")[2], f"P{number} has no test"


def test_every_assumption_that_a_promise_needs_is_listed() -> None:
    listed = {int(number) for number in re.findall(r"^\| A(\d+) \|", PAGE, re.MULTILINE)}
    assert {int(number) for _, row in PROMISES for number in re.findall(r"\bA(\d+)\b", row)} <= listed


@pytest.mark.parametrize("path", sorted(set(re.findall(r"`((?:tests|fmu_src|psp_model)/[\w./]+)`", PAGE))))
def test_a_file_that_the_page_names_exists(path: str) -> None:
    assert (ROOT / path).exists()


@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: f"{mutant['function']}-{mutant['after']}")
def test_an_explained_mutant_is_a_change_of_the_present_code(mutant: dict[str, str]) -> None:
    module = mutant["function"].rpartition(".")[0].replace(".", "/") + ".py"
    lines = [line.strip() for line in (ROOT / module).read_text(encoding="utf-8").splitlines()]
    assert mutant["before"] in lines and mutant["after"] not in lines and mutant["why"]
