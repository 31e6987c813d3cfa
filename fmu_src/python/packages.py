"""The Python packages that go into an FMU, under names of its own.

Two FMUs in one process share Python's table of modules: were the packages called alike, the second FMU would run the
first one's code.  Other people's FMUs bring pythonfmu, too, of any version.
"""

from __future__ import annotations

import ast
from importlib.resources import files
from pathlib import Path

import psp_model

PACKAGES = ("psp_model", "fmu_src", "pythonfmu")
_NOT_NEEDED = ("offline/", "analysis/", "installed/", "selection/search/")  # rooms of the model that no FMU enters
_COMMON = (
    "__init__.py",
    "errors.py",
    "interface/__init__.py",
    "interface/meaning.py",
    "interface/variables.py",
    "python/__init__.py",
    "python/state_check.py",
    "python/surroundings.py",
    "python/table_slave.py",
)
_CONTROLLER = "interface/controller_variables.py"
_OWN = {
    "PspPlatoon": ("python/slave_state.py", "python/platoon_slave.py"),
    "PspController": (_CONTROLLER, "python/controller_slave.py"),
    "PspLeader": (_CONTROLLER, "python/leader_slave.py"),
    "PspPlant": (_CONTROLLER, "python/plant_slave.py"),
}


def slave_module(name: str) -> str:
    """Name, inside the package `fmu_src`, of the module that holds a slave.

    Parameters
    ----------
    name : of the slave's class
    """
    return _OWN[name][-1].removesuffix(".py").replace("/", ".")


def model_sources(name: str) -> dict[str, bytes]:
    """The Python files of the model, of a slave and of pythonfmu, by name.

    Parameters
    ----------
    name : of the slave's class
    """
    model, ours = Path(psp_model.__file__).parent, Path(__file__).parents[1]
    modules = {path.relative_to(model).as_posix(): path for path in sorted(model.rglob("*.py"))}
    found = {
        f"psp_model/{place}": path.read_bytes() for place, path in modules.items() if not place.startswith(_NOT_NEEDED)
    }
    found |= {f"pythonfmu/{f.name}": f.read_bytes() for f in files("pythonfmu").iterdir() if f.name.endswith(".py")}
    return found | {f"fmu_src/{place}": (ours / place).read_bytes() for place in (*_COMMON, *_OWN[name])}


def renamed(sources: dict[str, bytes], suffix: str) -> dict[str, bytes]:
    """The same files as packages of their own name, where they go in the FMU.

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
