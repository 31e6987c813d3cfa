"""Compiles C for every desktop platform with the compiler that comes in the wheel `ziglang`."""

from __future__ import annotations

import struct
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from platform import machine, system
from tempfile import TemporaryDirectory

import fmpy

from ..errors import BuildError

FMI_HEADERS = Path(fmpy.__file__).parent / "c-code"
SOURCES = Path(__file__).parents[1] / "c"  # what all FMUs share
FRONT = (
    "front.h",
    "backend.h",
    "busy.h",
    "names.h",
    "fmi2Functions.h",
    "fmi2_front.c",
    "front_check.c",
    "front_log.c",
    "front_state.c",
    "front_text.c",
    "resource_path.c",
)
ENDINGS = {"linux64": "so", "win64": "dll", "darwin64": "dylib"}
WARNINGS = ("-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror")
# without fused multiply-add x86-64 and arm64 agree; a library must not contain paths, clocks or host settings
FLAGS = ("-O3", "-g0", "-fPIC", "-fvisibility=hidden", "-ffp-contract=off", "-fno-math-errno", "-shared", "-s")
_TARGETS = {
    "linux64": ("x86_64-linux-gnu.2.17",),
    "win64": ("x86_64-windows-gnu",),
    "darwin64": ("x86_64-macos.11.0", "aarch64-macos.11.0"),
}
_PAGE = 1 << 14  # the alignment that arm64 macOS wants of each part


def host_platform() -> str:
    """FMI's name for this machine's platform.

    Raises
    ------
    BuildError : on a machine of none of these platforms
    """
    name = {"Linux": "linux64", "Windows": "win64", "Darwin": "darwin64"}.get(system())
    if name is None or (name != "darwin64" and machine() not in ("x86_64", "AMD64")):
        raise BuildError(f"there is no native FMU for {system()} on {machine()}: build for all platforms elsewhere")
    return name


def fmi_headers() -> dict[str, bytes]:
    """FMI's headers of types, content by name; `fmi2Functions.h` is our own, which knows FMI2_FUNCTION_PREFIX."""
    return {name: (FMI_HEADERS / name).read_bytes() for name in ("fmi2FunctionTypes.h", "fmi2TypesPlatform.h")}


def prefix_header(name: str) -> str:
    """psp_prefix.h: the prefix of every external name except FMI's functions.

    Parameters
    ----------
    name : of the library
    """
    lines = ["#ifndef PSP_PREFIX_H", "#define PSP_PREFIX_H", "", f"#define PSP_PREFIX {name}_", "", "#endif", ""]
    return "/* Written by fmu_src/toolchain/compile.py. */\n" + "\n".join(lines)


def universal_binary(parts: Sequence[bytes]) -> bytes:
    """macOS libraries of several architectures in one file (the format of Apple's lipo).

    Parameters
    ----------
    parts : one Mach-O library per architecture
    """
    offset, entries, body = _PAGE, b"", b""
    for part in parts:
        cpu, subtype = struct.unpack_from("<ii", part, 4)  # from the header of the Mach-O file
        entries += struct.pack(">iiIII", cpu, subtype, offset, len(part), _PAGE.bit_length() - 1)
        padded = part + bytes(-len(part) % _PAGE)
        offset, body = offset + len(padded), body + padded
    header = struct.pack(">II", 0xCAFEBABE, len(parts)) + entries
    return header + bytes(_PAGE - len(header)) + body


def _compile_one(target: str, folder: Path, sources: Sequence[str], name: str, extra: Sequence[str]) -> bytes:
    """The library for one target; messages of the compiler go to stderr."""
    ending = next(ENDINGS[platform] for platform, targets in _TARGETS.items() if target in targets)
    library = folder / target / f"{name}.{ending}"
    library.parent.mkdir()
    command = [sys.executable, "-m", "ziglang", "cc", "-target", target, *WARNINGS, *FLAGS, *extra]
    command += [f"-Wl,-install_name,@rpath/{library.name}"] if ending == "dylib" else []
    command += ["-o", str(library.relative_to(folder)), *sources]
    command += ["-flto", "-lm", "-ldl", "-Wl,--as-needed"] if ending == "so" else []
    if not run_compiler(command, folder):
        raise BuildError(f"the C compiler failed for {target}, its messages are above: mend what they name")
    return library.read_bytes()


def run_compiler(command: Sequence[str], folder: Path) -> bool:
    """Run a compiler; its messages go to stderr once it has ended.

    They do not go there directly: Ctrl-C reaches all processes of the terminal, and one that is just starting prints
    a traceback of its own.

    Parameters
    ----------
    command : program and arguments
    folder : to run it in

    Returns
    -------
    whether it succeeded
    """
    ran = subprocess.run(command, cwd=folder, stderr=subprocess.PIPE, check=False)
    sys.stderr.write(ran.stderr.decode(errors="replace"))
    return ran.returncode == 0


def compile_library(platform: str, name: str, files: Mapping[str, bytes], extra: Sequence[str] = ()) -> bytes:
    """A shared library from C sources; the same sources give the same bytes.

    Parameters
    ----------
    platform : linux64, win64 or darwin64 (x86-64 and arm64 in one)
    name : of the library, without ending
    files : sources and headers by name; FMI's headers are added
    extra : further arguments of the compiler

    Returns
    -------
    content of the library
    """
    sources = sorted(file for file in files if file.endswith(".c"))
    with TemporaryDirectory(prefix="psp_native_") as temporary:
        folder = Path(temporary)
        for file, content in (fmi_headers() | dict(files)).items():
            (folder / file).write_bytes(content)
        parts = [_compile_one(target, folder, sources, name, extra) for target in _TARGETS[platform]]
    return parts[0] if len(parts) == 1 else universal_binary(parts)
