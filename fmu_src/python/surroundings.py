"""Requirements of a Python FMU on its interpreter; what is missing is reported in one sentence.

Any Python from 3.7 on must be able to read this file, and it imports nothing but the standard library: it runs before
anything that could be missing is imported, in the FMU and, as a program, in the Python that `psp doctor` asks.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import Any

OLDEST_PYTHON = (3, 11)
REMEDY = "or use the native FMU, which needs no Python"
NOEXEC = "failed to map segment"  # the dynamic linker's message for a file system mounted noexec


class Unsuitable(Exception):
    """What is missing; pythonfmu passes on its `repr`, and the launcher takes the sentence after the mark."""

    def __repr__(self) -> str:
        return "psp: " + str(self.args[0])


def python_problem(executable: str, version: Sequence[int], bits: int) -> str | None:
    """What is wrong with a Python, None if nothing is.

    Parameters
    ----------
    executable : its path
    version : at least its major and minor number
    bits : of an address
    """
    needed = ".".join(map(str, OLDEST_PYTHON))
    if tuple(version[:2]) < OLDEST_PYTHON:
        found = ".".join(map(str, version))
        return f"the Python {executable} is {found}, and {needed} or newer is needed: use a newer Python, {REMEDY}"
    if bits != 64:
        return f"the Python {executable} has {bits} bits, and 64 are needed: use a 64-bit Python, {REMEDY}"
    return None


def _first_number(version: str) -> int:
    found = re.match(r"\d+", version)
    return int(found.group()) if found else 0


def package_problem(package: str, needed: str, found: Sequence[str], executable: str) -> str | None:
    """What is wrong with a package, None if nothing is.

    Parameters
    ----------
    package : its name
    needed : the oldest sufficient version
    found : from `look_at`
    executable : the Python that was asked
    """
    version, place, error = found
    has = f"the Python {executable} has {package} {version}" + (f" (in {place})" if place else "")
    install = f"run {executable} -m pip install '{package}>={needed}'"
    if not version and not error:
        return f"the Python {executable} has no {package}, and {needed} or newer is needed: {install}, {REMEDY}"
    if version and _first_number(version) < _first_number(needed):
        return f"{has}, and {needed} or newer is needed: {install}, {REMEDY}"
    if NOEXEC in error:
        return (
            f"{has} and cannot load it ({error}), because its folder is on a file system mounted noexec: install it on "
            f"another one, {REMEDY}"
        )
    if error:
        again = f"{executable} -m pip install --force-reinstall '{package}>={needed}'"
        return f"{has} and cannot import it ({error}): run {again}, {REMEDY}"
    return None


def look_at(package: str) -> tuple[str, str, str]:
    """A package's version, empty if it is not installed, its folder, and why it cannot be imported, empty if it can.

    Parameters
    ----------
    package : its name
    """
    try:
        module = import_module(package)
    except ModuleNotFoundError as error:
        return ("", "", "") if error.name == package else (_installed(package), "", one_line(error))
    except Exception as error:  # a package of another build may raise any exception
        return _installed(package), "", one_line(error)
    version = getattr(module, "__version__", "")  # not in a folder of that name, which an uninstallation left
    return str(version), os.path.dirname(getattr(module, "__file__", None) or ""), ""


def _installed(package: str) -> str:
    from importlib import metadata  # not in every Python 3, and slow

    try:
        return metadata.version(package)
    except Exception:
        return ""


def one_line(error: BaseException) -> str:
    """An exception as one short line.

    Parameters
    ----------
    error : the exception
    """
    text = " ".join(f"{type(error).__name__}: {error}".split())
    return text if len(text) <= 300 else text[:150] + " ... " + text[-150:]


def load(module: str, name: str, numpy: str) -> Any:
    """The class of the slave.

    Parameters
    ----------
    module : in which it is
    name : of the class
    numpy : the oldest sufficient version of numpy

    Raises
    ------
    Unsuitable : where this Python cannot run it
    """
    executable = sys.executable or os.path.join(
        sys.prefix, "bin", "python3"
    )  # in a host that has started Python itself
    problem = python_problem(executable, sys.version_info[:3], 64 if sys.maxsize > 2**32 else 32)
    problem = problem or package_problem("numpy", numpy, look_at("numpy"), executable)
    if problem:
        raise Unsuitable(problem)
    try:
        return getattr(import_module(module), name)
    except Exception as error:
        raise Unsuitable(
            f"the Python part of this FMU cannot be imported by the Python {executable} ({one_line(error)}): extract "
            f"the whole FMU again, {REMEDY}"
        ) from error


def keep(script: dict[str, Any]) -> None:
    """Add a reference to the globals of the script in which pythonfmu looks for the slave.

    pythonfmu runs that script once more for every instance, and each time releases a reference that it does not own;
    without one to spare the globals would be freed while in use.

    Parameters
    ----------
    script : its globals

    Raises
    ------
    Unsuitable : where this Python cannot do that
    """
    try:
        import ctypes
    except ImportError as error:
        raise Unsuitable(
            f"the Python {sys.executable} was built without ctypes ({one_line(error)}): install libffi and build it "
            f"again, use another one, {REMEDY}"
        ) from error
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(script))


def main(packages: Sequence[str]) -> None:
    """Print the answer for `psp doctor`, a line of JSON after a mark.

    Parameters
    ----------
    packages : names; only numpy and onnxruntime are imported, regardless of the names in an archive
    """
    import json
    import sysconfig

    read = sysconfig.get_config_var
    folder, prefix = read("LIBDIR") or "", sys.base_prefix
    names = [read("INSTSONAME") or "", "libpython{}.{}.so.1.0".format(*sys.version_info), "python3.dll"]
    folders = [folder, os.path.join(folder, read("MULTIARCH") or ""), os.path.join(prefix, "lib"), prefix]
    there = [os.path.join(a, b) for a in folders for b in names if b.endswith(".dll") or ".so" in b]
    known = ("numpy", "onnxruntime")
    answer = {
        "executable": sys.executable,
        "version": list(sys.version_info[:3]),
        "bits": 64 if sys.maxsize > 2**32 else 32,
        "library": next(filter(os.path.isfile, there), None),
        "packages": {name: look_at(name) if name in known else (_installed(name), "", "") for name in packages},
    }
    os.write(1, ("\npsp-doctor:" + json.dumps(answer) + "\n").encode("ascii"))


if __name__ == "__main__":
    main(sys.argv[1:])
