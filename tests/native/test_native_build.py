"""The native FMU as a build: reproducible, compilable by others, right for every platform, sound under sanitizers."""

from __future__ import annotations

import os
import re
import shutil
import struct
import subprocess
import sys
from pathlib import Path
from zipfile import ZipFile

import pytest

from build_fmu import main as build
from fmu_src.native.components import NATIVE
from fmu_src.toolchain.compile import compile_library
from harness import OK, Instance, Unpacked
from native.fuzz import run as fuzzing
from native.hosting import host_arguments
from system_packages import WINES

FUNCTIONS = {  # FMI 2.0 for co-simulation
    *("GetTypesPlatform", "GetVersion", "SetDebugLogging", "Instantiate", "FreeInstance", "SetupExperiment"),
    *("EnterInitializationMode", "ExitInitializationMode", "Terminate", "Reset", "GetReal", "GetInteger", "GetBoolean"),
    *("GetString", "SetReal", "SetInteger", "SetBoolean", "SetString", "GetFMUstate", "SetFMUstate", "FreeFMUstate"),
    *("SerializedFMUstateSize", "SerializeFMUstate", "DeSerializeFMUstate", "GetDirectionalDerivative", "DoStep"),
    *("SetRealInputDerivatives", "GetRealOutputDerivatives", "CancelStep", "GetStatus", "GetRealStatus"),
    *("GetIntegerStatus", "GetBooleanStatus", "GetStringStatus"),
}


@pytest.fixture(scope="module", params=NATIVE)
def everywhere(request, tmp_path_factory) -> Path:
    """Each native FMU for all platforms."""
    folder = tmp_path_factory.mktemp("all")
    options = ["--component", request.param, "--runtime", "native", "--platforms", "all"]
    assert build([*options, "--output", str(folder)]) == 0
    return next(folder.glob("*.fmu"))


def component_of(path: Path) -> str:
    """Of a native FMU, as build_fmu.py calls it."""
    return path.name.removeprefix("Psp").removesuffix("Native.fmu").lower()


def _sources(fmu: Unpacked) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (fmu.folder / "sources").iterdir()}


def test_two_builds_are_the_same_bytes(everywhere, tmp_path):
    component = component_of(everywhere)
    platforms = "all" if component == "platoon" else "host"  # to save time: the compilers are the same
    options = ["--component", component, "--runtime", "native", "--platforms", platforms]
    assert build([*options, "--output", str(tmp_path)]) == 0
    with ZipFile(tmp_path / everywhere.name) as again, ZipFile(everywhere) as first:
        assert all(again.read(name) == first.read(name) for name in again.namelist())
    if platforms == "all":
        assert (tmp_path / everywhere.name).read_bytes() == everywhere.read_bytes()


def test_fmpy_finds_nothing_to_complain_about(each_native_fmu):
    ran = subprocess.run(
        [sys.executable, "-m", "fmpy", "validate", str(each_native_fmu.path)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0 and "No problems found" in ran.stdout


@pytest.mark.system("cc", "make")
def test_fmpy_compile_builds_the_sources(native_fmu, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")  # fmpy brings cmake
    from fmpy.build import build_platform_binary

    folder = tmp_path / "unpacked"
    shutil.copytree(native_fmu.folder, folder)
    library = folder / "binaries" / "linux64" / "PspPlatoonNative.so"
    original = library.read_bytes()
    library.unlink()
    build_platform_binary(folder)
    assert library.exists() and library.read_bytes() != original
    expected, seen = Instance(native_fmu), Instance(Unpacked(_packed(folder, tmp_path), tmp_path / "again"))
    for instance in (expected, seen):
        assert instance.initialise() == OK and instance.step(0.0, 2.0) == OK
    assert seen.outputs() == pytest.approx(expected.outputs(), rel=0, abs=1e-9)


def _packed(folder: Path, tmp_path: Path) -> Path:
    return Path(shutil.make_archive(str(tmp_path / "again"), "zip", folder)).rename(tmp_path / "again.fmu")


@pytest.mark.parametrize(
    "compiler",
    [pytest.param(compiler, marks=pytest.mark.system(compiler)) for compiler in ("gcc", "clang")],
)
def test_other_compilers_have_nothing_to_warn_about(each_native_fmu, tmp_path, compiler):
    for name, content in _sources(each_native_fmu).items():
        (tmp_path / name).write_bytes(content)
    flags = ["-std=c11", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fPIC", "-c"]
    subprocess.run([compiler, *flags, *(str(path) for path in tmp_path.glob("*.c"))], check=True, cwd=tmp_path)


def test_the_linux_library_needs_an_old_glibc_only(each_native_fmu):
    (library,) = (each_native_fmu.folder / "binaries" / "linux64").glob("*.so")
    content = library.read_bytes()
    versions = {tuple(map(int, found.split(b"."))) for found in re.findall(rb"GLIBC_([0-9.]+)", content)}
    assert versions and max(versions) <= (2, 17)


@pytest.mark.system("nm")
def test_the_linux_library_exports_fmi_only(each_native_fmu):
    (library,) = (each_native_fmu.folder / "binaries" / "linux64").glob("*.so")
    symbols = subprocess.run(["nm", "-D", "--defined-only", str(library)], capture_output=True, text=True, check=True)
    assert {line.split()[-1] for line in symbols.stdout.splitlines()} == {f"fmi2{name}" for name in FUNCTIONS}


def test_the_macos_library_holds_both_architectures_signed(everywhere):
    with ZipFile(everywhere) as archive:
        content = archive.read(f"binaries/darwin64/{everywhere.stem}.dylib")
    magic, count = struct.unpack_from(">II", content)
    assert (magic, count) == (0xCAFEBABE, 2)
    seen = set()
    for place in range(count):
        cpu, _, offset, size, _ = struct.unpack_from(">iiIII", content, 8 + 20 * place)
        part = content[offset : offset + size]
        assert part[:4] == bytes.fromhex("cffaedfe")  # Mach-O, 64 bit
        assert all(b"_fmi2" + name.encode() + b"\0" in part for name in FUNCTIONS)
        seen.add((cpu, 0x1D in _load_commands(part)))
    assert seen >= {(0x0100000C, True)}  # arm64 does not run without a signature (LC_CODE_SIGNATURE)
    assert {cpu for cpu, _ in seen} == {0x01000007, 0x0100000C}


def _load_commands(part: bytes) -> list[int]:
    (count,) = struct.unpack_from("<I", part, 16)
    offset, commands = 32, []
    for _ in range(count):
        command, size = struct.unpack_from("<II", part, offset)
        commands.append(command)
        offset += size
    return commands


@pytest.mark.system("wine", "cc")
def test_the_windows_library_gives_the_same_numbers_under_wine(everywhere, request, c_host, tmp_path):
    wine = next(str(path) for name in WINES if (path := shutil.which(name)))
    source = (Path(__file__).parent / "c_host.c").read_bytes()
    host = compile_executable(source, tmp_path)
    with ZipFile(everywhere) as archive:
        (tmp_path / "fmu.dll").write_bytes(archive.read(f"binaries/win64/{everywhere.stem}.dll"))
        guid = re.search(rb'guid="([^"]+)"', archive.read("modelDescription.xml"))[1].decode()
    component = component_of(everywhere)
    fmu = request.getfixturevalue("native_fmu" if component == "platoon" else f"native_{component}_fmu")
    wanted = ("s[2]", "s[7]", "v[3]", "a[4]", "T_max", "r", "x[7]", "J", "v", "a")
    names = [name for name in wanted if name in fmu.reference]
    arguments = host_arguments(fmu, 0.01, 500, *names)
    environment = os.environ | {"WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all", "DISPLAY": ""}
    environment["WINEDLLOVERRIDES"] = "mscoree,mshtml="  # no questions about packages that are not needed
    command = [wine, str(host), "fmu.dll", "file:///C:/x", guid, *arguments[3:]]
    ran = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    expected = subprocess.run([str(c_host), *arguments], capture_output=True, text=True, check=True).stdout
    of_wine = [[float(word) for word in line.split()] for line in ran.stdout.splitlines()]
    of_linux = [[float(word) for word in line.split()] for line in expected.splitlines()]
    assert len(of_wine) == 501
    for there, here in zip(of_wine, of_linux, strict=True):
        assert there == pytest.approx(here, rel=0, abs=1e-9)


def compile_executable(source: bytes, folder: Path) -> Path:
    """The C host for Windows."""
    from fmu_src.toolchain.compile import FMI_HEADERS

    (folder / "host.c").write_bytes(source)
    host = folder / "host.exe"
    command = [sys.executable, "-m", "ziglang", "cc", "-target", "x86_64-windows-gnu", "-O1", "-I", str(FMI_HEADERS)]
    subprocess.run([*command, "-o", str(host), "host.c"], check=True, cwd=folder)
    return host


@pytest.mark.system("sanitizers")
@pytest.mark.parametrize("component", NATIVE)
def test_a_short_run_of_the_fuzzer_finds_nothing(component):
    ran = fuzzing.fuzz(seconds=7, component=component)
    assert ran.returncode == 0, ran.stderr[-3000:]


def test_the_compiler_is_asked_for_one_library_per_platform_only():
    library = compile_library("linux64", "nothing", {"nothing.c": b"int nothing(void) { return 0; }\n"})
    assert library[:4] == b"\x7fELF"


def test_sources_that_do_not_compile_are_a_clear_error():
    with pytest.raises(RuntimeError, match="the C compiler failed for x86_64-linux-gnu"):
        compile_library("linux64", "nothing", {"nothing.c": b"not C"})
