"""Imports point down: the picture of the architecture page is true (docs/rooms.toml)."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
FLOORS = tomllib.loads((ROOT / "docs" / "rooms.toml").read_text(encoding="utf-8"))["floors"]
ROOMS: dict[str, tuple[int, Any]] = {
    room["path"]: (floor, room) for floor, level in enumerate(FLOORS) for room in level["rooms"]
}
PROGRAMS = {"psp_cli", "psp_cli/interrupt", "build_fmu"}
"""Rooms that have options on a command line."""

OURS = ("psp_model", "fmu_src", "psp_view", "psp_traffic", "psp_cli", "build_fmu")
FILES = [
    path.relative_to(ROOT)
    for package in OURS
    for path in ([ROOT / f"{package}.py"] if package == "build_fmu" else sorted((ROOT / package).rglob("*.py")))
]


def room_of(module: str) -> str:
    """The room of a module, by the longest path that fits."""
    path = module.replace(".", "/")
    return max((room for room in ROOMS if path == room or path.startswith(room + "/")), key=len)


def module_of(path: Path) -> str:
    return ".".join(path.with_suffix("").parts).removesuffix(".__init__")


def imports(path: Path) -> Iterator[tuple[int, str]]:
    """Line and absolute name of every module imported, wherever in the file."""
    package = module_of(path) if path.name == "__init__.py" else module_of(path).rpartition(".")[0]
    for node in ast.walk(ast.parse((ROOT / path).read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            parts = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            base = ".".join([*parts, *([node.module] if node.module else [])])
            for alias in node.names:
                inner = ROOT / f"{base}.{alias.name}".replace(".", "/")
                is_module = inner.is_dir() or inner.with_suffix(".py").exists()
                yield node.lineno, f"{base}.{alias.name}" if base.split(".")[0] in OURS and is_module else base


@pytest.mark.parametrize("path", FILES, ids=str)
def test_imports_point_down(path: Path) -> None:
    floor, room = ROOMS[room_of(module_of(path))]
    for line, name in imports(path):
        top = name.split(".")[0]
        if top in OURS:
            if name == "psp_model" and floor > ROOMS["psp_model"][0]:
                continue
            below, other = ROOMS[room_of(name)]
            assert below < floor or other is room, f"{path}:{line} imports {name}, which is not below it"
        elif top not in sys.stdlib_module_names:
            allowed = {"numpy", "typing_extensions", *room.get("foreign", [])}
            assert top in allowed, f"{path}:{line} imports {top}, which its room knows nothing of"


def test_every_room_has_something_in_it() -> None:
    inhabited = {room_of(module_of(path)) for path in FILES}
    assert inhabited == set(ROOMS)


def test_every_room_uses_the_packages_that_it_is_said_to_know() -> None:
    used: dict[str, set[str]] = {room: set() for room in ROOMS}
    for path in FILES:
        used[room_of(module_of(path))] |= {name.split(".")[0] for _, name in imports(path)}
    idle = {path: set(room.get("foreign", [])) - used[path] for path, (_, room) in ROOMS.items()}
    assert not {path: packages for path, packages in idle.items() if packages}


@cache
def options() -> set[str]:
    """Every option of `psp` and of the build script."""
    from typer.main import get_command

    from psp_cli.main import app

    commands: Any = get_command(app)
    return {word for one in commands.commands.values() for option in one.params for word in option.opts if "--" in word}


@pytest.mark.parametrize("path", [path for path in FILES if room_of(module_of(path)) not in PROGRAMS], ids=str)
def test_a_library_names_no_option_of_the_command_line(path: Path) -> None:
    """What to do with an option is said by the program that has it (psp_cli/remedies.py)."""
    words = re.compile(rf"(?<![\w-])(?:{'|'.join(sorted(options(), key=len, reverse=True))})(?![\w-])")
    for node in ast.walk(ast.parse((ROOT / path).read_text(encoding="utf-8"))):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value.strip():
            found = words.search(node.value)
            assert found is None, f"{path}:{node.lineno} speaks of {found[0] if found else ''}: {node.value!r}"
