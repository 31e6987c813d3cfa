"""The documentation: it builds, it is complete, and every command and snippet in it runs."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from typer.main import get_command

from fmu_src.errors import FmiError
from fmu_src.interface.platoon import platoon_table
from psp_cli.main import app
from psp_cli.scenario import read_scenario
from psp_model.errors import SENTENCES

ROOT = Path(__file__).parents[2]
PAGES = [*sorted((ROOT / "docs").glob("*.md")), ROOT / "CONTRIBUTING.md"]
BLOCK = re.compile(r"(?:<!-- (?P<mark>[^>]*) -->\n)?```(?P<language>sh|python|toml)\n(?P<code>.*?)```", re.DOTALL)

SYSTEM = {"psp sumo": "sumo", "libcosimpy": "libcosim", "ecospy": "ecos", "psp doctor": "libpython"}
"""What words in a block need of the system."""


def blocks(language: str):
    """Fenced blocks of a language, each as a test's parameters; those that a page marks are skipped with its reason."""
    for page in PAGES:
        for number, found in enumerate(BLOCK.finditer(page.read_text(encoding="utf-8")), start=1):
            if found["language"] != language:
                continue
            mark = found["mark"] or ""
            if found["code"].startswith("{{ file examples/"):
                continue  # an example, which tests/test_examples.py runs
            if "out/train.parquet" in found["code"] or "out/platoon_3.onnx" in found["code"]:
                continue  # run in order by test_the_training_page_from_top_to_bottom
            marks = [pytest.mark.skip(reason=mark)] if mark.startswith("not run here: ") else []
            marks += [pytest.mark.system(need) for word, need in SYSTEM.items() if word in found["code"]]
            yield pytest.param(found["code"], id=f"{page.stem}-{number}", marks=marks)


@pytest.fixture(scope="module")
def workplace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that looks to the commands like the project, with the quick start's scenario in it."""
    folder = tmp_path_factory.mktemp("workplace")
    for name in (
        "mkdocs.yml",
        "docs",
        "examples",
        "psp_model",
        "psp_view",
        "fmu_src",
        "onnx",
        "LICENSE",
        "CONTRIBUTING.md",
        "CHANGELOG.md",
    ):
        (folder / name).symlink_to(ROOT / name)
    (folder / "out").mkdir()
    subprocess.run(shell("psp build --output dist"), cwd=folder, env=environment(), check=True, capture_output=True)
    (toml,) = [found for found in BLOCK.finditer((ROOT / "docs/index.md").read_text()) if found["language"] == "toml"]
    (folder / "scenario.toml").write_text(toml["code"], encoding="utf-8")
    return folder


def environment() -> dict[str, str]:
    """This process's, with the commands of this Python first."""
    here = str(Path(sys.executable).parent)
    path = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    return os.environ | {"PATH": here + os.pathsep + os.environ["PATH"], "PYTHONPATH": path, "NO_MKDOCS_2_WARNING": "1"}


def shell(code: str) -> list[str]:
    """A shell that stops at the first command that fails and finds `psp` whether it is installed or not."""
    psp = f'psp() {{ "{sys.executable}" -m psp_cli "$@"; }}; python() {{ "{sys.executable}" "$@"; }}'
    return ["bash", "-euc", f"{psp}\n{code}"]


@pytest.mark.parametrize("code", list(blocks("sh")))
def test_a_command_of_the_documentation(code, workplace):
    ran = subprocess.run(shell(code), cwd=workplace, env=environment(), capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stdout + ran.stderr


@pytest.mark.parametrize("code", list(blocks("python")))
def test_a_python_snippet_of_the_documentation(code, workplace):
    command = [sys.executable, "-c", code]
    ran = subprocess.run(command, cwd=workplace, env=environment(), capture_output=True, text=True, check=False)
    assert ran.returncode == 0 and ran.stdout, ran.stdout + ran.stderr


def test_the_training_page_from_top_to_bottom(workplace):
    """Its commands build on one another, so they run as one script."""
    pytest.importorskip("jax")
    pytest.importorskip("casadi")
    page = (ROOT / "docs/training.md").read_text(encoding="utf-8")
    code = "\n".join(found["code"] for found in BLOCK.finditer(page) if found["language"] == "sh")
    assert code.count("psp ") == 6
    ran = subprocess.run(shell(code), cwd=workplace, env=environment(), capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert "V_new, network" in ran.stdout


def test_the_scenario_of_the_quick_start_is_read(workplace):
    assert set(read_scenario(workplace / "scenario.toml").runs) == {"gentle", "V_old"}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("material")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)]
    ran = subprocess.run(command, cwd=ROOT, env=environment(), capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    return folder


def test_every_variable_is_on_the_interface_page(site):
    page = (site / "interface/index.html").read_text(encoding="utf-8")
    for name in {re.sub(r"\[\d+\]", "[i]", row.name) for row in platoon_table(7)}:
        assert f"<code>{name}</code>" in page


def test_every_message_is_on_the_page_of_messages(site):
    page = (site / "faq/index.html").read_text(encoding="utf-8")
    for key in SENTENCES | FmiError.sentences:
        assert f'id="{key}"' in page
    assert "%.10g" not in page and "{{" not in page


def test_every_command_is_on_the_command_line_page(site):
    page = (site / "command-line/index.html").read_text(encoding="utf-8")
    for name in get_command(app).commands:
        assert f"psp {name}" in page
    assert page.count("Usage: psp") == len(get_command(app).commands)


def test_the_site_asks_nobody_else_for_anything(site):
    for page in site.rglob("*.html"):
        outside = re.findall(r"<(?:script|link|img)[^>]*(?:src|href)=[\"']?(https?://[^\"'> ]+)", page.read_text())
        assert not [one for one in outside if "fonts" in one or one.endswith((".js", ".css"))], page


def test_mathematics_is_set(site):
    page = (site / "theory/index.html").read_text(encoding="utf-8")
    assert page.count("<math") > 40 and "\\frac" not in page


def test_the_citation_names_paper_and_version():
    yaml = pytest.importorskip("yaml")
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert cited["version"] == project["version"] and cited["license"] == project["license"]
    names = [author["family-names"] for author in cited["preferred-citation"]["authors"]]
    assert names == ["Tzortzoglou", "Theodosis", "Dave", "Malikopoulos"]
    assert f"## {project['version']}" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
