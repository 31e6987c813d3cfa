"""The Python packages that go into an FMU, under names of its own: only what its slave imports.

Two FMUs in one process share Python's table of modules: if the packages had equal names, the second FMU would run the
first one's code.  Other FMUs may also contain pythonfmu, in any version.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path

PACKAGES = ("psp_model", "fmu_src", "pythonfmu")
_SURROUNDINGS = "fmu_src.python.surroundings"  # the script of the FMU imports it
_FACES = ("psp_model", "pythonfmu")  # packages that import everything for their users, of whom an FMU has none
_SLAVES = {
    "PspPlatoon": "python.platoon_slave",
    "PspController": "python.controller_slave",
    "PspLeader": "python.leader_slave",
    "PspPlant": "python.plant_slave",
}


def slave_module(name: str) -> str:
    """Name, inside the package `fmu_src`, of the module that holds a slave.

    Parameters
    ----------
    name : of the slave's class
    """
    return _SLAVES[name]


def model_sources(name: str) -> dict[str, bytes]:
    """The Python files of a slave, and of all that it imports of this project and of pythonfmu, by name.

    Parameters
    ----------
    name : of the slave's class
    """
    found: dict[str, bytes] = {}
    waiting = [f"fmu_src.{slave_module(name)}", _SURROUNDINGS]
    while waiting:
        module = waiting.pop()
        path = _path_of(module)
        place = path.relative_to(_root_of(module)).as_posix()
        if place in found:
            continue
        content = _docstring_of(path.read_bytes()) if module in _FACES else path.read_bytes()
        found[place] = content
        waiting += imported_modules(content, module, path.name == "__init__.py")
        if "." in module:
            waiting.append(module.rpartition(".")[0])
    return dict(sorted(found.items()))


def imported_modules(content: bytes, module: str, is_package: bool) -> Iterator[str]:
    """The modules of PACKAGES that a module imports, wherever in it, by absolute name.

    Parameters
    ----------
    content : of its file
    module, is_package : its absolute name, and whether the file is that of a package
    """
    package = module.split(".") if is_package else module.split(".")[:-1]
    for node in ast.walk(ast.parse(content)):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            parts = package[: len(package) + 1 - node.level] if node.level else []
            base = ".".join([*parts, *([node.module] if node.module else [])])
            inner = [f"{base}.{alias.name}" for alias in node.names]
            names = [base, *(name for name in inner if _is_module(name))]
        else:
            continue
        yield from (name for name in names if name.partition(".")[0] in PACKAGES)


def _root_of(module: str) -> Path:
    """The folder that the package of a module is in."""
    return Path(str(files("pythonfmu"))).parent if module.startswith("pythonfmu") else Path(__file__).parents[2]


def _path_of(module: str) -> Path:
    """The file of a module of PACKAGES."""
    place = _root_of(module).joinpath(*module.split("."))
    return place / "__init__.py" if place.is_dir() else place.with_suffix(".py")


def _is_module(name: str) -> bool:
    return name.partition(".")[0] in PACKAGES and _path_of(name).exists()


def _docstring_of(content: bytes) -> bytes:
    """A module reduced to its docstring."""
    text = ast.get_docstring(ast.parse(content))
    return f'"""{text}"""\n'.encode() if text else b""


def renamed(sources: dict[str, bytes], suffix: str) -> dict[str, bytes]:
    """The same files as packages of their own name, by their paths in the FMU.

    Parameters
    ----------
    sources : from `model_sources`
    suffix : of the packages' names
    """
    found = {}
    for name, content in sources.items():
        package, _, place = name.partition("/")
        found[f"resources/{package}_{suffix}/{place}"] = _with_renamed_imports(content, suffix)
    return found


def _with_renamed_imports(content: bytes, suffix: str) -> bytes:
    """A module that imports the packages by their names in the FMU."""
    lines = content.decode().splitlines(keepends=True)
    for node in ast.walk(ast.parse(content)):
        if isinstance(node, ast.ImportFrom) and node.level == 0:
            top = (node.module or "").partition(".")[0]
        elif isinstance(node, ast.Import):
            top = node.names[0].name.partition(".")[0]
        else:
            continue
        if top in PACKAGES:
            at = node.lineno - 1
            lines[at] = lines[at].replace(top, f"{top}_{suffix}", 1)
    return "".join(lines).encode()
