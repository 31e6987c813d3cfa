"""What the tests need from the system, how to tell that it is there, and the Debian packages that bring it.

`python tests/system_packages.py` installs what is missing where that may be: as root on Debian.  `make test` begins
with it.  A test says what it needs by `@pytest.mark.system("chromium")`, or calls `require` where it needs it, and is
skipped where that is missing.  With PSP_SKIP_NOTHING=1, which `.ci/run` sets, nothing that could have been installed is
skipped: the test fails, and so does an installation.
"""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from shutil import which
from tempfile import TemporaryDirectory

STRICT = "PSP_SKIP_NOTHING"
CLANGS = ("clang", "clang-19", "clang-16", "clang-15", "clang-14")
X11 = ("libX11.so.6", "libXext.so.6", "libXrender.so.1", "libGL.so.1", "libatomic.so.1")  # libsumo links SUMO's window
WINES = ("wine64", "wine", "/usr/lib/wine/wine64")


@dataclass(frozen=True)
class Need:
    """Something that tests need from the system.

    Attributes
    ----------
    what : it is
    packages : of Debian that bring it; none where no package does
    found : whether it is there
    """

    what: str
    packages: tuple[str, ...]
    found: Callable[[], bool]


def _programs(*names: str) -> bool:
    return all(which(name) is not None for name in names)


def _libraries(*names: str) -> bool:
    """Whether the loader finds shared libraries; a process of its own is asked, so that this one stays without them."""
    code = "import ctypes, sys; [ctypes.CDLL(name) for name in sys.argv[1:]]"
    return subprocess.run([sys.executable, "-c", code, *names], capture_output=True, check=False).returncode == 0


def _compiles(compilers: Iterable[str], *flags: str, source: str = "int main(void) { return 0; }\n") -> bool:
    """Whether the first of the compilers that is there makes a program with these flags."""
    compiler = next((path for name in compilers if (path := which(name))), None)
    if compiler is None:
        return False
    with TemporaryDirectory() as folder:
        (Path(folder) / "a.c").write_text(f"#include <stdlib.h>\n{source}")
        command = [compiler, *flags, "-o", "a", "a.c"]
        return subprocess.run(command, cwd=folder, capture_output=True, check=False).returncode == 0


def _sanitizes() -> bool:
    fuzzed = "int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) { return data && size > 9; }\n"
    fuzzes = _compiles(CLANGS, "-fsanitize=fuzzer,address,undefined", source=fuzzed)
    return fuzzes and _compiles(CLANGS, "-fsanitize=thread")


def _libpython() -> Path:
    """The shared library of this Python, where it has one."""
    found = [str(sysconfig.get_config_var(name) or "") for name in ("LIBDIR", "INSTSONAME")]
    return Path(*found)


def _has_libpython() -> bool:
    return bool(sysconfig.get_config_var("Py_ENABLE_SHARED")) and _libpython().is_file()


# Debian's Python comes without its shared library; any other brings its own or has none
_LIBPYTHON = (f"libpython{sys.version_info[0]}.{sys.version_info[1]}",) if sys.base_prefix == "/usr" else ()
_C = ("gcc", "libc6-dev")
NEEDS = {
    "cc": Need("a C compiler", _C, partial(_compiles, ["cc"])),
    "gcc": Need("gcc", _C, partial(_compiles, ["gcc"])),
    "clang": Need("clang", ("clang",), partial(_compiles, ["clang"])),
    "sanitizers": Need("clang with its sanitizers", ("clang", "libclang-rt-dev"), _sanitizes),
    "make": Need("make", ("make",), partial(_programs, "make")),
    "nm": Need("nm", ("binutils",), partial(_programs, "nm")),
    "unzip": Need("unzip, which ecos calls", ("unzip",), partial(_programs, "unzip")),
    "wine": Need("wine", ("wine64",), lambda: any(map(_programs, WINES))),
    "chromium": Need(
        "chromium and its driver", ("chromium", "chromium-driver"), partial(_programs, "chromium", "chromedriver")
    ),
    "libpython": Need("the shared library of this Python", _LIBPYTHON, _has_libpython),
    "ecos": Need("libtbb, which ecos links", ("libtbb12",), partial(_libraries, "libtbb.so.12")),
    "libcosim": Need("libatomic, which libcosim links", ("libatomic1",), partial(_libraries, "libatomic.so.1")),
    "sumo": Need(
        "the libraries that SUMO links",
        ("libx11-6", "libxext6", "libxrender1", "libgl1", "libatomic1"),
        partial(_libraries, *X11),
    ),
}


@cache
def found(name: str) -> bool:
    """Whether a need is met.

    Parameters
    ----------
    name : in NEEDS
    """
    return NEEDS[name].found()


def may_install() -> bool:
    """Whether packages may be installed here: by root, where there is apt-get."""
    return hasattr(os, "geteuid") and os.geteuid() == 0 and which("apt-get") is not None


def strict() -> bool:
    """Whether a test fails instead of being skipped for want of something that could have been installed."""
    return os.environ.get(STRICT, "") not in ("", "0")


def require(*names: str) -> None:
    """Skip the test that runs, or fail it, where the system lacks something.

    Parameters
    ----------
    names : in NEEDS
    """
    import pytest

    for name in names:
        if found(name):
            continue
        need = NEEDS[name]
        remedy = f"install Debian's {' '.join(need.packages)}" if need.packages else "no package of Debian brings it"
        reason = f"needs {need.what}: {remedy}"
        if strict() and need.packages and may_install():
            pytest.fail(reason, pytrace=False)
        pytest.skip(reason)


def missing() -> list[str]:
    """Names of the needs that are not met and that packages would meet."""
    return [name for name, need in NEEDS.items() if need.packages and not found(name)]


def _apt_get(packages: list[str]) -> str:
    """Install packages; what went wrong, "" if nothing did."""
    environment = os.environ | {"DEBIAN_FRONTEND": "noninteractive"}
    said = ""
    for arguments in (["update"], ["install", "--yes", "--no-install-recommends", *packages]):
        command = ["apt-get", "-qq", *arguments]
        ran = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        if ran.returncode:
            said += (
                f"{' '.join(command)} ended with exit code {ran.returncode}:\n{ran.stdout[-2000:]}{ran.stderr[-2000:]}"
            )
    return said


def main() -> int:
    """Install what is missing; exit code 1 where that fails and nothing may be skipped."""
    wanted = missing()
    packages = sorted({package for name in wanted for package in NEEDS[name].packages})
    if not packages:
        return 0
    if not may_install():
        print(f"Tests are skipped for want of these packages (Debian's names): {' '.join(packages)}", flush=True)
        return 0
    print(f"Installing what the tests need from the system: {' '.join(packages)}", flush=True)
    said = _apt_get(packages)
    found.cache_clear()
    left = missing()
    if not left:
        return 0
    print(said, end="", file=sys.stderr)
    names = "; ".join(NEEDS[name].what for name in left)
    print(f"Tests {'fail' if strict() else 'are skipped'} for want of {names}", file=sys.stderr)
    return 1 if strict() else 0


if __name__ == "__main__":
    sys.exit(main())
