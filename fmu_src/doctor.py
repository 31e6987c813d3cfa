"""What on this machine would prevent an FMU of this project from loading, and how to fix it."""

from __future__ import annotations

import json
import os
import re
import subprocess
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from platform import libc_ver, machine, system
from shutil import which
from typing import Any
from xml.etree import ElementTree
from zipfile import ZipFile

from .python import surroundings

_OLDEST_GLIBC = (2, 17)  # what the linux64 libraries are linked for
_MOST_PACKAGES = 50  # that are asked for
_LARGEST = 1 << 26  # [bytes] of a file inside an FMU that is read
# nothing is imported from the folder in which doctor is run
_QUESTION = "import sys\nsys.path[:] = filter(None, sys.path)\nexec(sys.argv.pop(1))"
_MARK = "psp-doctor:"
_MISLEADING = ("PYTHONHOME", "PYTHONPATH", "PYTHONPLATLIBDIR")  # environment variables


@dataclass(frozen=True)
class Finding:
    """The result of one check.

    Attributes
    ----------
    good : no problem found
    text : what was found
    remedy : how to fix it, empty if there is no problem
    """

    good: bool
    text: str
    remedy: str = ""


def _platform() -> str:
    name = {"Linux": "linux64", "Windows": "win64", "Darwin": "darwin64"}.get(system(), system())
    return name if name == "darwin64" or machine() in ("x86_64", "AMD64") else f"{name} on {machine()}"


def examine(fmu: Path) -> Iterator[Finding]:
    """Check an FMU and this machine.

    Parameters
    ----------
    fmu : the file

    Yields
    ------
    Finding
    """
    try:
        names, root, requirements = _read(fmu)
    except Exception as error:  # zipfile, its decompressors and the XML reader raise exceptions of any kind
        yield Finding(False, f"{fmu} is not a readable FMU ({error})", "build it again: python build_fmu.py")
        return
    name = root.get("modelName", "")
    yield Finding(True, f"{fmu.name}: {name} {root.get('version', '')}, {root.get('guid', '')}")
    yield from _libraries(names, name)
    yield from _glibc()
    if "resources/slavemodule.txt" in names:
        named = re.findall(r"^([A-Za-z0-9_-]{1,80})(?:>=([0-9.]{1,20}))?", requirements, re.MULTILINE)
        yield from _python({name: needed or "0" for name, needed in named[:_MOST_PACKAGES]})
        yield _home()
    yield from _temporary_folder()


def _read(fmu: Path) -> tuple[set[str], ElementTree.Element, str]:
    """Names of the files in an FMU, its model description and its requirements."""
    needed = "resources/requirements.txt"
    with ZipFile(fmu) as archive:
        names = set(archive.namelist())
        for name in {"modelDescription.xml", needed} & names:
            if archive.getinfo(name).file_size > _LARGEST:
                raise ValueError(f"{name} has more than {_LARGEST >> 20} MB")
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
        return names, root, archive.read(needed).decode() if needed in names else ""


def _libraries(names: set[str], model: str) -> Iterator[Finding]:
    platform = _platform()
    has = sorted({part.split("/")[1] for part in names if part.startswith("binaries/") and part.count("/") > 1})
    if platform in has:
        yield Finding(True, f"there is a library for this machine ({platform})")
    elif any(part.startswith("sources/") for part in names):
        remedy = f"run `fmpy compile {model}.fmu` here, or build it for all platforms"
        yield Finding(False, f"there are libraries for {', '.join(has)} and none for {platform}", remedy)
    else:
        remedy = "use the native FMU, whose sources can be compiled here"
        yield Finding(False, f"there are libraries for {', '.join(has)} and none for {platform}", remedy)


def _glibc() -> Iterator[Finding]:
    library, version = libc_ver()
    if system() != "Linux":
        return
    if library != "glibc":
        remedy = "run in a distribution with glibc, such as Debian, or compile the native FMU's sources here"
        yield Finding(False, "the C library of this Linux is not glibc", remedy)
        return
    numbers = tuple(map(int, version.split(".")[:2]))
    remedy = "" if numbers >= _OLDEST_GLIBC else "use a distribution of 2014 or later, or compile the sources here"
    yield Finding(not remedy, f"glibc {version}, and 2.17 or later is needed", remedy)


def _ask(program: str, packages: list[str], without: str = "") -> tuple[dict[str, Any] | None, str]:
    """What a Python reports about itself, None if it does not answer, and its last other output.

    A sitecustomize or a wrapper may print text around the answer, which is therefore marked.
    """
    text = Path(surroundings.__file__).read_text(encoding="utf-8")
    environment = {name: value for name, value in os.environ.items() if name != without}
    try:
        ran = subprocess.run(
            [program, "-c", _QUESTION, text, *packages],
            stdin=subprocess.DEVNULL,  # PYTHONINSPECT makes Python wait for input
            capture_output=True,
            env=environment,
            check=False,
        )
    except OSError as error:
        return None, str(error)
    for line in reversed(ran.stdout.decode(errors="replace").splitlines()):
        if line.startswith(_MARK):
            answer: dict[str, Any] = json.loads(line.removeprefix(_MARK))
            return answer, ""
    said = [line for line in ran.stderr.decode(errors="replace").splitlines() if line.strip()]
    return None, ([line for line in said if "rror" in line] or said or ["it said nothing"])[-1].strip()


def _python(requirements: dict[str, str]) -> Iterator[Finding]:
    """The Python that a host without one would load: the first on PATH."""
    program = which("python" if system() == "Windows" else "python3")
    if program is None:
        yield Finding(False, "there is no Python on PATH", "install Python 3.11 or later, or use the native FMU")
        return
    answer, said = _ask(program, list(requirements))
    if answer is None:
        yield _does_not_start(program, said)
        return
    version = ".".join(map(str, answer["version"]))
    yield _judged(
        surroundings.python_problem(answer["executable"], answer["version"], answer["bits"]),
        f"Python {version} on PATH: {answer['executable']}",
    )
    for package, found in answer["packages"].items():
        needed = requirements[package]
        problem = surroundings.package_problem(package, needed, found, answer["executable"])
        yield _judged(problem, f"it has {package} {found[0]}, and {needed} or newer is needed")
    yield from _libpython(answer["library"])


def _judged(problem: str | None, good: str) -> Finding:
    """A finding from a sentence on what is wrong and, after a colon, how to fix it."""
    if problem is None:
        return Finding(True, good)
    text, _, remedy = problem.rpartition(": ")
    return Finding(False, text, remedy)


def _does_not_start(program: str, said: str) -> Finding:
    for name in _MISLEADING:
        if os.environ.get(name) and _ask(program, [], without=name)[0]:
            text = f"{program} does not start with the environment variable {name} = {os.environ[name]} ({said})"
            return Finding(False, text, f"unset {name}, or use the native FMU")
    return Finding(False, f"{program} does not start ({said})", "put a working Python first on PATH")


def _libpython(library: str | None) -> Iterator[Finding]:
    chosen = os.environ.get("PSP_LIBPYTHON")
    if chosen:
        there = Path(chosen).is_file()
        remedy = "" if there else "name a file that is there, or unset PSP_LIBPYTHON"
        yield Finding(there, f"PSP_LIBPYTHON names {chosen}", remedy)
    elif library:
        yield Finding(True, f"hosts without Python will load {library}")
    else:
        remedy = "needed in hosts without Python only: install libpython3.x, or use a Python built with --enable-shared"
        yield Finding(False, "this Python has no shared library", remedy)


def _home() -> Finding:
    """HOME, which no FMU needs; reported for information."""
    home = os.environ.get("HOME") or os.environ.get("USERPROFILE")
    if not home:
        return Finding(True, "HOME is not set, and not needed")
    state = "is writable" if os.access(home, os.W_OK) else "cannot be written"
    return Finding(True, f"HOME = {home} {state}, and nothing is written there")


def _temporary_folder() -> Iterator[Finding]:
    """Hosts extract FMUs there; some of them do not encode what a URI must encode."""
    try:
        folder = tempfile.gettempdir()
    except FileNotFoundError as error:
        yield Finding(
            False, f"there is no folder to extract FMUs to ({error.strerror})", "set TMPDIR to a writable one"
        )
        return
    awkward = sorted({character for character in folder if not re.match(r"[A-Za-z0-9/\\:._~-]", character)})
    if mounted_noexec(folder):
        remedy = "set TMPDIR to a folder on another file system"
        text = (
            f"FMUs are extracted to {folder}, whose file system is mounted noexec: no library can be loaded from there"
        )
        yield Finding(False, text, remedy)
    if awkward:
        remedy = "set TMPDIR (Windows: TEMP) to a path of letters, digits, - and _ if a host fails to load the FMU"
        yield Finding(False, f"FMUs are extracted to {folder}, which holds {' '.join(map(repr, awkward))}", remedy)
    elif not mounted_noexec(folder):
        yield Finding(True, f"FMUs are extracted to {folder}")


def mounted_noexec(folder: str) -> bool:
    """Whether the system refuses to run programs, and to load libraries, from a folder.

    Parameters
    ----------
    folder : its path
    """
    if not hasattr(os, "statvfs"):
        return False
    try:
        return bool(os.statvfs(folder).f_flag & os.ST_NOEXEC)
    except OSError:
        return False
