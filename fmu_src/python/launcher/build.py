"""Compiles the launcher, the C library through which hosts drive the Python FMU.

The binaries stand in `binaries/`, so that building an FMU needs no compiler.  After a change to the C sources run
`python -m fmu_src.python.launcher.build`; a test compiles them again and compares byte for byte.
"""

from __future__ import annotations

from pathlib import Path

from ...toolchain.compile import ENDINGS, FRONT, SOURCES, compile_library, prefix_header

BINARIES = Path(__file__).parent / "binaries"
PLATFORMS = ("linux64", "win64")  # those that pythonfmu has libraries for
_OWN = ("python_library", "python_question", "python_host", "python_resources", "library")
_FILES = (*FRONT, "backend_python.c", *(f"{name}.{ending}" for name in _OWN for ending in "ch"))


def launcher(platform: str) -> bytes:
    """The launcher for one platform, compiled from its sources.

    Parameters
    ----------
    platform : one of PLATFORMS

    Returns
    -------
    content of the shared library
    """
    files = {name: (SOURCES / name).read_bytes() for name in _FILES}
    files["psp_prefix.h"] = prefix_header("PspLauncher").encode()
    return compile_library(platform, "psp_launcher", files)


def path_of(platform: str) -> Path:
    """The path of the compiled launcher for one platform."""
    return BINARIES / platform / f"psp_launcher.{ENDINGS[platform]}"


def main() -> None:
    """Compile the launcher for all platforms into `binaries/`."""
    for platform in PLATFORMS:
        path_of(platform).parent.mkdir(parents=True, exist_ok=True)
        path_of(platform).write_bytes(launcher(platform))
        print(path_of(platform))


if __name__ == "__main__":
    main()
