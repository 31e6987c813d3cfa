"""The sources of the native FMUs in one program, and what other compilers and linkers ask of them."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from fmu_src.native import build
from fmu_src.native.components import NATIVE
from fmu_src.native.components import native_fmu as native_fmu_of
from fmu_src.networks import networks_up_to
from harness import OK, Instance, Unpacked

LONGEST_LINE = 4095  # C11, 5.2.4.1: what every compiler takes


def compiler() -> list[str]:
    """A C compiler for this machine: the one installed, or the one from PyPI."""
    found = shutil.which("gcc") or shutil.which("cc")
    return [found] if found else [sys.executable, "-m", "ziglang", "cc"]


def compiled(fmu: Unpacked, folder: Path, *options: str) -> list[str]:
    """Objects from the files that modelDescription.xml lists, as a tool with a C compiler makes them."""
    folder.mkdir()
    shutil.copytree(fmu.folder / "sources", folder, dirs_exist_ok=True)
    text = (fmu.folder / "modelDescription.xml").read_text(encoding="utf-8")
    listed = re.findall(r'<File name="([^"]+)"', text)
    assert sorted(listed) == sorted(path.name for path in folder.glob("*.c"))
    flags = ["-std=c11", "-O1", "-ffp-contract=off", "-fno-math-errno"]  # the numbers of the libraries
    subprocess.run([*compiler(), *flags, *options, "-c", *listed], cwd=folder, check=True)
    return [str(folder / name).removesuffix(".c") + ".o" for name in listed]


def outputs(fmu: Unpacked) -> tuple[int, int]:
    """Reference of the first output, and how many there are."""
    found = [v.valueReference for v in fmu.description.modelVariables if v.causality == "output"]
    return found[0], len(found)


@pytest.fixture(scope="module")
def all_of_them(native_fmu, native_controller_fmu, native_plant_fmu, native_leader_fmu) -> list[Unpacked]:
    """The native FMUs, in the order of all_in_one.c."""
    return [native_fmu, native_controller_fmu, native_plant_fmu, native_leader_fmu]


@pytest.fixture(scope="module")
def objects(all_of_them, tmp_path_factory) -> dict[str, list[str]]:
    """Of all FMUs, compiled with their prefixes."""
    folder = tmp_path_factory.mktemp("objects")
    return {
        fmu.path.stem: compiled(fmu, folder / fmu.path.stem, f"-DFMI2_FUNCTION_PREFIX={fmu.path.stem}_")
        for fmu in all_of_them
    }


def test_all_native_fmus_link_into_one_program(all_of_them, objects, tmp_path):
    host = Path(__file__).parent / "all_in_one.c"
    program, headers = tmp_path / "all_in_one", all_of_them[0].folder / "sources"
    files = [str(host), *(path for fmu in all_of_them for path in objects[fmu.path.stem])]
    subprocess.run([*compiler(), "-std=c11", "-I", str(headers), "-o", str(program), *files, "-lm"], check=True)
    words = [word for fmu in all_of_them for word in (fmu.description.guid, *map(str, outputs(fmu)))]
    ran = subprocess.run([str(program), *words], capture_output=True, text=True, check=True)
    assert ran.stderr == ""
    rows = [[float.fromhex(word) for word in line.split()] for line in ran.stdout.splitlines()]
    instances = [Instance(fmu) for fmu in all_of_them]
    assert all(instance.initialise() == OK for instance in instances) and len(rows) == 50
    for k, row in enumerate(rows):
        assert all(instance.step(0.01 * k, 0.01) == OK for instance in instances)
        expected = [value for instance in instances for value in instance.outputs()]
        assert row == pytest.approx(expected, rel=1e-9, abs=1e-9)
    for instance in instances:
        instance.close()


@pytest.mark.parametrize("prefixed", [True, False])
def test_every_external_symbol_is_of_the_model_or_of_fmi(each_native_fmu, objects, tmp_path, prefixed):
    nm = shutil.which("nm") or shutil.which("llvm-nm")
    if nm is None:
        pytest.skip("neither nm nor llvm-nm is on this machine: install binutils")
    name = each_native_fmu.path.stem
    files = objects[name] if prefixed else compiled(each_native_fmu, tmp_path / "plain")
    ran = subprocess.run([nm, "-g", "--defined-only", *files], capture_output=True, text=True, check=True)
    symbols = {words[2].lstrip("_") for line in ran.stdout.splitlines() if len(words := line.split()) == 3}
    others = {symbol for symbol in symbols if not symbol.startswith(f"{name}_")}
    assert len(symbols) > 50
    assert others == (set() if prefixed else {symbol for symbol in symbols if symbol.startswith("fmi2")})
    assert len({symbol for symbol in symbols if "fmi2" in symbol}) == 34


@pytest.mark.parametrize("definitions", [["-DFMI2_FUNCTION_PREFIX=A_", "-DFMI2_OVERRIDE_FUNCTION_PREFIX"], []])
def test_the_prefix_can_be_overridden(native_fmu, tmp_path, definitions):
    source = '#include "fmi2Functions.h"\nconst char *fmi2GetVersion(void) { return "2.0"; }\n'
    (tmp_path / "one.c").write_text(source)
    headers = ["-I", str(native_fmu.folder / "sources")]
    command = [*compiler(), *definitions, *headers, "-E", "-P", "one.c"]
    text = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    assert "*fmi2GetVersion(void)" in text.replace("* ", "*") and "A_" not in text


@pytest.mark.parametrize("vehicles", [2, 12, 400])
@pytest.mark.parametrize("component", NATIVE)
def test_no_line_is_longer_than_compilers_must_take(component, vehicles):
    for name, content in native_fmu_of(component, vehicles, networks_up_to(vehicles)).sources("{guid}").items():
        text = content.decode().replace("\\\n", "")  # a line that goes on counts as one
        assert max(map(len, text.splitlines())) <= LONGEST_LINE, name


def test_derivatives_are_promised_where_the_defaults_have_them():
    with_network = build.native_platoon(7, networks_up_to(7))
    assert "providesDirectionalDerivative" not in with_network.capabilities
    assert "providesDirectionalDerivative" in build.native_platoon(7, {}).capabilities
