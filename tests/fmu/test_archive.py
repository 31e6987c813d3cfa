"""What is inside the FMU, and that building it twice gives the same bytes."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import PurePosixPath
from xml.etree import ElementTree

import fmpy
import pytest
from fmpy.validation import validate_fmu

from build_fmu import main as build
from fmu_src.interface.platoon import platoon_table
from fmu_src.python.packages import model_sources


@pytest.fixture(scope="module")
def archive(fmu) -> zipfile.ZipFile:
    return zipfile.ZipFile(fmu.path)


@pytest.fixture(scope="module")
def root(archive) -> ElementTree.Element:
    return ElementTree.fromstring(archive.read("modelDescription.xml"))


def test_fmpy_finds_nothing_to_report(fmu, fmu_of_three):
    assert validate_fmu(str(fmu.path)) == []
    assert validate_fmu(str(fmu_of_three.path)) == []


def test_two_builds_are_identical(fmu, tmp_path):
    assert build(["--output", str(tmp_path / "a"), "--vehicles", "7"]) == 0
    assert (tmp_path / "a" / "PspPlatoon.fmu").read_bytes() == fmu.path.read_bytes()


@pytest.mark.parametrize("component", ["PspPlatoon", "PspController", "PspPlant", "PspLeader"])
def test_the_packages_in_an_fmu_import_nothing_that_is_not_in_there(component):
    sources = model_sources(component)
    foreign = set()
    for place, content in sources.items():
        path = PurePosixPath(place)
        inside = path.parent if path.name == "__init__.py" else path.with_suffix("")
        assert (path.parent / "__init__.py").as_posix() in sources
        for name in _imported(content, inside.parts, path.name == "__init__.py"):
            if name[0] in ("psp_model", "fmu_src", "pythonfmu"):
                assert {"/".join(name) + ".py", "/".join((*name, "__init__.py"))} & set(sources), (place, name)
            elif name[0] not in sys.stdlib_module_names:
                foreign.add(name[0])
    # casadi_symbols.py is imported where an array is CasADi's only
    assert foreign <= {"numpy", "onnxruntime", "casadi"}


def _imported(content: bytes, inside: tuple[str, ...], is_package: bool) -> Iterator[tuple[str, ...]]:
    """Every module that a module imports from, as the parts of its name."""
    package = inside if is_package else inside[:-1]
    for node in ast.walk(ast.parse(content)):
        if isinstance(node, ast.Import):
            yield from (tuple(alias.name.split(".")) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) + 1 - node.level] if node.level else ()
            yield (*base, *(node.module.split(".") if node.module else ()))


@pytest.mark.parametrize("component", ["platoon", "controller", "plant", "leader"])
def test_a_slave_can_be_imported_with_nothing_but_what_is_in_its_fmu(component, tmp_path):
    assert build(["--component", component, "--vehicles", "3", "--output", str(tmp_path)]) == 0
    (path,) = tmp_path.glob("*.fmu")
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path / "unpacked")
        script = archive.read("resources/slavemodule.txt").decode()
        modules = [PurePosixPath(name) for name in archive.namelist() if name.startswith("resources/psp_model_")]
    names = [".".join(name.relative_to("resources").with_suffix("").parts) for name in modules]
    code = f"import sys; sys.path.insert(0, {str(tmp_path / 'unpacked' / 'resources')!r}); import {script}\n"
    code += "assert not {'psp_model', 'fmu_src', 'onnxruntime', 'casadi', 'jax'} & set(sys.modules)\n"
    code += "\n".join(f"import {name}" for name in names if "casadi_symbols" not in name)
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    ran = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr


def test_every_variable_has_description_unit_and_typical_size(root):
    variables = root.findall("ModelVariables/ScalarVariable")
    assert [variable.get("name") for variable in variables] == [row.name for row in platoon_table(7)]
    units = {unit.get("name") for unit in root.findall("UnitDefinitions/Unit")}
    assert all(unit.find("BaseUnit") is not None for unit in root.findall("UnitDefinitions/Unit"))
    for variable in variables:
        assert variable.get("description") and variable.get("variability")
        assert bool(variable.get("initial")) == (variable.get("causality") != "input")
        assert {"output": "Real"}.get(variable.get("causality"), variable[0].tag) == variable[0].tag
        if variable[0].tag == "Real":
            assert variable[0].get("unit") in units


def test_dependencies_are_those_of_the_model(root):
    names = [variable.get("name") for variable in root.findall("ModelVariables/ScalarVariable")]
    unknowns = {
        names[int(unknown.get("index")) - 1]: {names[int(i) - 1] for i in unknown.get("dependencies").split()}
        for unknown in root.findall("ModelStructure/InitialUnknowns/Unknown")
    }
    assert unknowns["v[3]"] == {"n_start", "v_start[3]"} and unknowns["s[2]"] == {"n_start", "s_start[2]"}
    assert unknowns["J"] == set() and unknowns["n_active"] == {"n_start"}
    assert unknowns["x[3]"] == {"n_start", "x_start", "s_start[2]", "s_start[3]"}
    assert {"T", "alpha_fixed", "v_start[1]"} <= unknowns["alpha"]
    outputs = [names[int(unknown.get("index")) - 1] for unknown in root.findall("ModelStructure/Outputs/Unknown")]
    assert outputs == [row.name for row in platoon_table(7) if row.causality == "output"]


def test_the_archive_holds_what_a_user_looks_for(archive):
    names = set(archive.namelist())
    assert {"model.png", "documentation/index.html", "documentation/licenses/license.txt"} <= names
    assert {"resources/platoon_7.onnx", "resources/requirements.txt", "binaries/linux64/PspPlatoon.so"} <= names
    page = archive.read("documentation/index.html").decode()
    for row in platoon_table(7):
        assert f"<code>{row.name}</code>" in page and row.unit in page


def test_a_size_without_a_network_says_so_and_starts_with_source_2(tmp_path, capsys):
    assert build(["--vehicles", "13", "--output", str(tmp_path)]) == 0
    assert "no network for 13 vehicles" in capsys.readouterr().out
    description = fmpy.read_model_description(str(tmp_path / "PspPlatoon.fmu"))
    assert [v.start for v in description.modelVariables if v.name == "parameter_source"] == ["2"]
    with zipfile.ZipFile(tmp_path / "PspPlatoon.fmu") as archive:
        assert "resources/platoon_any.onnx" in archive.namelist()  # for when vehicles have left
        assert "for 2, 3, 4, 5, 6, 8" in archive.read("documentation/index.html").decode()


BAD_ARGUMENTS = [
    ["--vehicles", "1"],
    ["--network", "missing.onnx"],
    ["--component", "controller", "--network", "missing.onnx"],
    ["--output", "/dev/null/x"],
    ["--component", "plant", "--network", "onnx/platoon_7.onnx"],
]


@pytest.mark.parametrize("arguments", BAD_ARGUMENTS, ids=" ".join)
def test_bad_arguments_are_one_sentence_and_exit_code_2(arguments, capsys):
    assert build(arguments) == 2
    error = capsys.readouterr().err
    assert error.startswith("build_fmu.py: ") and error.count("\n") == 1
