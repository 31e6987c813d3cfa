"""What on this machine would keep an FMU of ours from loading, and how to mend it."""

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
from xml.etree import ElementTree
from zipfile import ZipFile

_OLDEST_PYTHON = (3, 11)
_OLDEST_GLIBC = (2, 17)  # what the linux64 libraries are linked for
_MOST_PACKAGES = 50  # that are asked for
_LARGEST = 1 << 26  # [bytes] of a file inside an FMU that is read
_QUESTION = (
    "import sys\n"
    "sys.path[:]=filter(None,sys.path)\n"  # nothing from the folder in which doctor is run
    "import importlib.metadata as m,json,os,sysconfig as s\n"
    "def found(name):\n"
    "    try:\n        version=m.version(name)\n"  # nothing that an archive may name is imported but these two
    "        return __import__(name).__version__ if name in ('numpy','onnxruntime') else version\n"
    "    except Exception as e:\n        return None\n"
    "g=s.get_config_var\n"
    "c=[os.path.join(a,b) for a in (g('LIBDIR') or '',os.path.join(g('LIBDIR') or '',g('MULTIARCH') or ''),"
    "os.path.join(sys.base_prefix,'lib'),sys.base_prefix) for b in (g('INSTSONAME') or '',"
    "'libpython%d.%d.so.1.0'%sys.version_info[:2],'python3.dll') if b.endswith('.dll') or '.so' in b]\n"
    "print(json.dumps({'executable':sys.executable,'version':list(sys.version_info[:3]),"
    "'library':next(filter(os.path.isfile,c),None),'packages':{n:found(n) for n in sys.argv[1:]}}))\n"
)


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at.

    Attributes
    ----------
    good : nothing to mend
    text : what was found
    remedy : how to mend it, empty where there is nothing to mend
    """

    good: bool
    text: str
    remedy: str = ""


def _platform() -> str:
    name = {"Linux": "linux64", "Windows": "win64", "Darwin": "darwin64"}.get(system(), system())
    return name if name == "darwin64" or machine() in ("x86_64", "AMD64") else f"{name} on {machine()}"


def examine(fmu: Path) -> Iterator[Finding]:
    """Look at an FMU and at this machine.

    Parameters
    ----------
    fmu : the file

    Yields
    ------
    Finding
    """
    try:
        names, root, requirements = _read(fmu)
    except Exception as error:  # zipfile, its decompressors and the XML reader raise whatever they like
        yield Finding(False, f"{fmu} is not a readable FMU ({error})", "build it again: python build_fmu.py")
        return
    name = root.get("modelName", "")
    yield Finding(True, f"{fmu.name}: {name} {root.get('version', '')}, {root.get('guid', '')}")
    yield from _libraries(names, name)
    yield from _glibc()
    if "resources/slavemodule.txt" in names:
        named = re.findall(r"^[A-Za-z0-9_-]{1,80}", requirements, re.MULTILINE)
        yield from _python(named[:_MOST_PACKAGES])
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
        remedy = f"run `fmpy compile {model}.fmu` here, or build with --platforms all"
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


def _python(packages: list[str]) -> Iterator[Finding]:
    """The Python that a host without one would load: the first on PATH."""
    program = which("python" if system() == "Windows" else "python3")
    if program is None:
        yield Finding(False, "there is no Python on PATH", "install Python 3.11 or later, or use the native FMU")
        return
    command = [program, "-c", _QUESTION, *packages]
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    try:
        answer = json.loads(ran.stdout.splitlines()[-1])
    except (ValueError, IndexError):
        said = ran.stderr.strip().splitlines()[-1:] or ["nothing"]
        yield Finding(False, f"{program} does not run ({said[0]})", "put a working Python first on PATH")
        return
    version = ".".join(map(str, answer["version"]))
    new = tuple(answer["version"][:2]) >= _OLDEST_PYTHON
    remedy = "" if new else "put a Python 3.11 or later first on PATH, or use the native FMU"
    yield Finding(new, f"Python {version} on PATH: {answer['executable']}", remedy)
    yield from _packages(answer)
    yield from _libpython(answer["library"])


def _packages(answer: dict[str, object]) -> Iterator[Finding]:
    packages = answer["packages"]
    assert isinstance(packages, dict)
    for package, version in packages.items():
        if version is None:
            remedy = f"{answer['executable']} -m pip install {package}"
            yield Finding(False, f"this Python cannot import {package}", remedy)
        else:
            yield Finding(True, f"it has {package} {version}")


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


def _temporary_folder() -> Iterator[Finding]:
    """Hosts extract FMUs there; some of them do not encode what a URI must encode."""
    folder = tempfile.gettempdir()
    awkward = sorted({character for character in folder if not re.match(r"[A-Za-z0-9/\\:._~-]", character)})
    if not awkward:
        yield Finding(True, f"FMUs are extracted to {folder}")
        return
    remedy = "set TMPDIR (Windows: TEMP) to a path of letters, digits, - and _ if a host fails to load the FMU"
    yield Finding(False, f"FMUs are extracted to {folder}, which holds {' '.join(map(repr, awkward))}", remedy)
