"""`PspPlatoon.fmu`: the model in Python, run by pythonfmu's library, loaded by our launcher."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib.metadata import distribution, version
from importlib.resources import files
from pathlib import Path
from typing import Any

from psp_model.installed.files import licence

from ..interface.documentation import index_page
from ..interface.model_description import Component, model_description
from ..interface.platoon import DESCRIPTION, platoon_table
from ..interface.variables import Variable
from ..networks import NetworkFile, noted_of, notes_on_networks
from ..pack.archive import content_digest, guid_of, write_fmu
from ..pack.ecosystem import layered_standard, reference_results
from .packages import model_sources, renamed, slave_module
from .table_slave import CONFIG

NAME = "PspPlatoon"
NEEDS = (
    "Needs from outside: a 64-bit Python 3.11 or later with numpy and onnxruntime (resources/requirements.txt), on "
    "Linux or Windows: a Python host lends its own, other hosts find the python3 that is first on PATH."
)
_LAUNCHERS = {"linux64": "psp_launcher.so", "win64": "psp_launcher.dll"}
_SCRIPT = '''"""Where pythonfmu finds the slave."""

from fmu_src_{suffix}.python.surroundings import keep, load

{name} = load("fmu_src_{suffix}.{module}", "{name}", "{numpy}")
keep(globals())
'''


def _pythonfmu_libraries() -> dict[str, bytes]:
    """pythonfmu's library for each platform that we have a launcher for."""
    package, found = files("pythonfmu"), {}
    for platform in _LAUNCHERS:
        for library in (package / "resources" / "binaries" / platform).iterdir():
            found[f"resources/binaries/{platform}/{library.name}"] = library.read_bytes()
    return found


def _licences() -> dict[str, bytes]:
    theirs = next(f for f in distribution("pythonfmu").files or [] if f.name == "LICENSE")
    folder = "documentation/licenses"
    return {f"{folder}/license.txt": licence(), f"{folder}/pythonfmu.txt": theirs.read_binary()}


def _requirements() -> str:
    """The requirements of the FMU, as pip reads them: the versions it was built with are known to work."""
    return "".join(f"{name}>={_oldest(name)}\n" for name in ("numpy", "onnxruntime"))


def _oldest(package: str) -> str:
    return f"{version(package).split('.')[0]}.0"


def build_python_fmu(vehicles: int, output: Path, networks: Mapping[int, NetworkFile]) -> Path:
    """Write PspPlatoon.fmu; the same tree gives the same bytes.

    Parameters
    ----------
    vehicles : largest number of vehicles N, at least 2
    output : folder
    networks : from `networks_up_to`; without one for N parameter_source defaults to 2

    Returns
    -------
    path of the FMU
    """
    source = 1 if vehicles in networks else 2
    table = platoon_table(vehicles, source)
    config = {"vehicles": vehicles, "default_source": source, "networks": noted_of(networks)}
    reader = networks[vehicles].reader if vehicles in networks else None
    more = layered_standard(table, reference_results(table, reader))
    notes = [*notes_on_networks(networks), NEEDS]
    return pack_slave(NAME, DESCRIPTION, table, config, [*networks.values()], notes, output, more)


def pack_slave(
    name: str,
    description: str,
    table: tuple[Variable, ...],
    config: dict[str, Any],
    networks: Sequence[NetworkFile],
    notes: Sequence[str],
    output: Path,
    more: Mapping[str, bytes] | None = None,
) -> Path:
    """Write an FMU whose slave is the class `name`; the same tree gives the same bytes.

    Parameters
    ----------
    name, description : of the FMU
    table : its variables
    config : what the slave reads from resources/
    networks : that go into resources/
    notes : paragraphs of its page
    output : folder
    more : further files, content by name

    Returns
    -------
    path of the FMU
    """
    component = Component(
        name,
        description,
        version("psp-platoon"),
        "",
        capabilities=("canGetAndSetFMUstate", "canSerializeFMUstate", "canNotUseMemoryManagementFunctions"),
    )
    packed = dict(more or {}) | _fixed_files(name, networks)
    packed |= {"documentation/index.html": index_page(component, config["vehicles"], table, notes)}
    sources = model_sources(name)
    digest = content_digest(packed | sources | {"table": model_description(component, table)})
    packed |= _generated_files(component, table, config, digest) | renamed(sources, digest[:12])
    path = output / f"{name}.fmu"
    write_fmu(path, packed)
    return path


def _fixed_files(name: str, networks: Sequence[NetworkFile]) -> dict[str, bytes]:
    """All files copied into the FMU unchanged."""
    here = Path(__file__).parent
    found = _pythonfmu_libraries() | _licences()
    for platform, library in _LAUNCHERS.items():
        found[f"binaries/{platform}/{name}{Path(library).suffix}"] = (
            here / "launcher" / "binaries" / platform / library
        ).read_bytes()
    found["model.png"] = (here.parent / "model.png").read_bytes()
    found["resources/requirements.txt"] = _requirements().encode()
    found["documentation/externalDependencies.txt"] = ("Python >= 3.11\n" + _requirements()).encode()
    return found | {f"resources/{network.name}": network.content for network in networks}


def _generated_files(
    component: Component, table: tuple[Variable, ...], config: dict[str, Any], digest: str
) -> dict[str, bytes]:
    """All files that describe the content of the FMU."""
    module = f"psp_platoon_{digest[:12]}"
    described = replace(component, guid=guid_of(digest))
    slave = slave_module(component.name)
    script = _SCRIPT.format(suffix=digest[:12], name=component.name, module=slave, numpy=_oldest("numpy"))
    return {
        "modelDescription.xml": model_description(described, table),
        "resources/slavemodule.txt": module.encode(),
        "resources/guid.txt": described.guid.encode(),
        f"resources/{module}.py": script.encode(),
        f"resources/{CONFIG}": json.dumps(config, indent=1).encode(),
    }
