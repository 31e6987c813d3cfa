"""Everything public in psp_model says what it is, what goes in, and where it comes from."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2] / "psp_model"
SOURCED = r"law\.\w+|sampling\.\w+|selection\.feasible|objective|parameters|platoon|state"
Function = ast.FunctionDef | ast.AsyncFunctionDef


def public(body: list[ast.stmt], prefix: str) -> Iterator[tuple[str, Function | ast.ClassDef]]:
    """Public functions and classes of a body, and the public methods of its public classes."""
    for node in body:
        if isinstance(node, Function | ast.ClassDef) and not node.name.startswith("_"):
            yield f"{prefix}.{node.name}", node
            if isinstance(node, ast.ClassDef):
                yield from public(node.body, f"{prefix}.{node.name}")


def protocol(node: Function | ast.ClassDef) -> bool:
    bases = node.bases if isinstance(node, ast.ClassDef) else []
    return any(isinstance(base, ast.Name) and base.id == "Protocol" for base in bases)


def collect() -> dict[str, Function | ast.ClassDef]:
    found: dict[str, Function | ast.ClassDef] = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        module = ".".join(path.relative_to(PACKAGE).with_suffix("").parts)
        found |= dict(public(ast.parse(path.read_text(encoding="utf-8")).body, module))
    of_protocols = [name for name, node in found.items() if protocol(node)]
    return {name: node for name, node in found.items() if not name.startswith(tuple(f"{one}." for one in of_protocols))}


THINGS = collect()
CLASSES = {node.name for node in THINGS.values() if isinstance(node, ast.ClassDef)}
FUNCTIONS = [name for name, node in THINGS.items() if not isinstance(node, ast.ClassDef)]


def fields_of(node: ast.ClassDef) -> list[str]:
    """Annotated attributes of a class body, a dataclass's fields."""
    targets = [item.target for item in node.body if isinstance(item, ast.AnnAssign)]
    return [target.id for target in targets if isinstance(target, ast.Name) and not target.id.startswith("_")]


def names_a_class_of_ours(annotation: ast.expr | None) -> bool:
    return annotation is not None and any(
        isinstance(part, ast.Name) and part.id in CLASSES for part in ast.walk(annotation)
    )


def mentions(text: str, name: str) -> bool:
    return re.search(rf"(?<!\w){re.escape(name)}(?!\w)", text) is not None


def test_there_is_something_to_check() -> None:
    assert {"law.potential.potential", "platoon.SampledPlatoon.advance_to", "simulate.simulate"} <= set(THINGS)


@pytest.mark.parametrize("name", THINGS)
def test_has_a_docstring_that_opens_with_one_sentence(name: str) -> None:
    text = ast.get_docstring(THINGS[name])
    assert text, "no docstring"
    assert text.split("\n\n")[0].rstrip().endswith((".", ":", "]", ")")) or "=" in text.split("\n\n")[0], text


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_parameter_is_documented(name: str) -> None:
    """By name in the docstring; a parameter whose type is a class of ours is documented there."""
    node = THINGS[name]
    assert isinstance(node, Function)
    text = ast.get_docstring(node) or ""
    if re.fullmatch(r"See `\w+\.\w+`\.", text):  # a method of a protocol, documented there
        assert text.split(".")[-2].strip("`") == node.name
        return
    arguments = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
    arguments += [extra for extra in (node.args.vararg, node.args.kwarg) if extra]
    missing = [
        one.arg
        for one in arguments
        if one.arg not in ("self", "cls") and not names_a_class_of_ours(one.annotation) and not mentions(text, one.arg)
    ]
    assert not missing, f"undocumented: {missing}"


@pytest.mark.parametrize("name", [name for name, node in THINGS.items() if isinstance(node, ast.ClassDef)])
def test_every_field_is_documented(name: str) -> None:
    node = THINGS[name]
    assert isinstance(node, ast.ClassDef)
    text = ast.get_docstring(node) or ""
    missing = [field for field in fields_of(node) if not mentions(text, field)]
    assert not missing, f"undocumented: {missing}"


@pytest.mark.parametrize("name", [name for name in FUNCTIONS if re.fullmatch(rf"({SOURCED})\.\w+", name)])
def test_model_functions_say_where_they_come_from(name: str) -> None:
    text = ast.get_docstring(THINGS[name]) or ""
    if text.startswith("See `"):
        return
    assert re.search(r"\b(paper|ours)\b", text, re.IGNORECASE), "neither 'paper, ...' nor 'ours'"
