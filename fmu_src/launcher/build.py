"""Compiles the launcher, the C library through which hosts drive the Python FMU.

The binaries stand in `binaries/`, so that building an FMU needs no compiler.  After a change to the C sources run
`python -m fmu_src.launcher.build`; a test compiles them again and compares byte for byte.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import fmpy

HERE = Path(__file__).parent
C_SOURCES = HERE.parent / "c"
BINARIES = HERE / "binaries"
HEADERS = Path(fmpy.__file__).parent / "c-code"  # fmpy ships the FMI 2.0 headers

FRONT = ["front_check.c", "front_log.c", "front_state.c", "fmi2_front.c", "resource_path.c"]
LAUNCHER = ["backend_python.c", "python_library.c", "library.c"]
WARNINGS = ["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]
# -ffp-contract=off: no fused multiply-add, so that all machines compute alike
COMMON = ["-O2", "-g0", "-fvisibility=hidden", "-ffp-contract=off", "-ffile-prefix-map=.=psp", "-shared", "-s"]
TARGETS = {"linux64": "x86_64-linux-gnu.2.17", "win64": "x86_64-windows-gnu"}
ENDINGS = {"linux64": "so", "win64": "dll", "darwin64": "dylib"}


def compile_launcher(platform: str, output: Path) -> Path:
    """Compile the launcher for one platform.

    Parameters
    ----------
    platform : "linux64" or "win64", the platforms that pythonfmu has libraries for
    output : folder for the result

    Returns
    -------
    the shared library
    """
    output.mkdir(parents=True, exist_ok=True)
    library = output / f"psp_launcher.{ENDINGS[platform]}"
    system = ["-ldl"] if platform == "linux64" else []
    command = [sys.executable, "-m", "ziglang", "cc", "-target", TARGETS[platform], *WARNINGS, *COMMON]
    command += ["-I", str(HEADERS), "-o", str(library.resolve()), *FRONT, *LAUNCHER, *system]
    subprocess.run(command, check=True, cwd=C_SOURCES)
    for extra in (*output.glob("*.lib"), *output.glob("*.pdb")):
        extra.unlink()
    return library


def main() -> None:
    """Compile the launcher for all platforms into `binaries/`."""
    for platform in TARGETS:
        print(compile_launcher(platform, BINARIES / platform))


if __name__ == "__main__":
    main()
