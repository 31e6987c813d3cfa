"""`PspPlatoonNative.fmu`: sources from the model, compiled for the platforms asked for, packed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

from ..documentation import index_page
from ..ecosystem import layered_standard, reference_results
from ..model_description import Component, model_description
from ..packing import content_digest, guid_of, write_fmu
from ..python_runtime import NetworkFile
from ..variables import Variable, platoon_table
from .compile import ENDINGS, FMI_HEADERS, FRONT, SOURCES, compile_library, host_platform
from .kernels import kernels_header
from .tables import model_header, network_header

NAME = "PspPlatoonNative"
PLATFORMS = ("linux64", "win64", "darwin64")
DESCRIPTION = (
    "A platoon of automated vehicles on one lane, under sampled feedback from performance-sensitive potentials; needs "
    "nothing but itself"
)
_CAPABILITIES = (
    "canNotUseMemoryManagementFunctions",
    "canGetAndSetFMUstate",
    "canSerializeFMUstate",
    "providesDirectionalDerivative",
)
_HERE = Path(__file__).parent


def chosen_platforms(platforms: str) -> tuple[str, ...]:
    """The platforms that `host` or `all` stands for."""
    return PLATFORMS if platforms == "all" else (host_platform(),)


def native_sources(
    table: Sequence[Variable], vehicles: int, guid: str, network: NetworkFile | None
) -> dict[str, bytes]:
    """Everything that a C compiler needs beside FMI's headers, by file name.

    Parameters
    ----------
    table : the variables
    vehicles : n
    guid : of the FMU
    network : that goes into it, None without one
    """
    found = {name: (SOURCES / name).read_bytes() for name in FRONT}
    found |= {path.name: path.read_bytes() for path in sorted((_HERE / "c").glob("*.[ch]"))}
    generated = {
        "psp_kernels.h": kernels_header(),
        "psp_model.h": model_header(table, vehicles, guid, network),
        "psp_network.h": network_header(network),
    }
    return found | {name: text.encode() for name, text in generated.items()}


def _notes(vehicles: int, network: NetworkFile | None) -> list[str]:
    needs = "Needs nothing from outside.  sources/ holds the C sources; `fmpy compile` builds them for other platforms."
    if network is None:
        return [f"There is no network for {vehicles} vehicles in this FMU, so parameter_source starts at 2.", needs]
    bounds = ", ".join(f"{name} = {value:.10g}" for name, value in network.domain.items())
    return [f"Its network, {network.name}, was trained on starts with {bounds} (m, m/s, s).", needs]


def build_native_fmu(
    vehicles: int, output: Path, platforms: Sequence[str] | None = None, network: NetworkFile | None = None
) -> Path:
    """Write PspPlatoonNative.fmu; the same tree and the same tools give the same bytes.

    Parameters
    ----------
    vehicles : n, at least 2
    output : folder
    platforms : of PLATFORMS; this machine's without
    network : from `network_for`; without one parameter_source starts at 2

    Returns
    -------
    path of the FMU
    """
    table = platoon_table(vehicles, default_source=1 if network else 2)
    component = Component(NAME, DESCRIPTION, version("psp-platoon"), "", capabilities=_CAPABILITIES)
    packed = {
        "documentation/index.html": index_page(component, vehicles, table, _notes(vehicles, network)),
        "documentation/licenses/license.txt": (_HERE.parents[1] / "LICENSE").read_bytes(),
        "model.png": (_HERE.parent / "model.png").read_bytes(),
    }
    packed |= layered_standard(table, reference_results(table, network.reader if network else None))
    without_guid = native_sources(table, vehicles, "", network)
    guid = guid_of(content_digest(packed | without_guid | {"table": repr((component, table)).encode()}))
    sources = native_sources(table, vehicles, guid, network)
    names = tuple(sorted(name for name in sources if name.endswith(".c")))
    packed["modelDescription.xml"] = model_description(replace(component, guid=guid, source_files=names), table)
    packed |= {f"sources/{name}": content for name, content in sources.items()}
    packed |= {f"sources/{header.name}": header.read_bytes() for header in FMI_HEADERS.glob("fmi2*.h")}
    for platform in platforms or (host_platform(),):
        packed[f"binaries/{platform}/{NAME}.{ENDINGS[platform]}"] = compile_library(platform, NAME, sources)
    path = output / f"{NAME}.fmu"
    write_fmu(path, packed)
    return path
