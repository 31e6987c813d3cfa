"""Native FMUs: sources from the model, compiled for the platforms asked for, packed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib.metadata import version
from pathlib import Path

from psp_model.installed.files import licence

from ..interface import controller, platoon
from ..interface.documentation import index_page
from ..interface.model_description import Component, model_description
from ..interface.variables import Variable
from ..networks import NetworkFile, notes_on_networks
from ..pack.archive import content_digest, guid_of, write_fmu
from ..pack.ecosystem import layered_standard, reference_results
from ..toolchain.compile import ENDINGS, FRONT, SOURCES, compile_library, fmi_headers, host_platform, prefix_header
from .kernels import kernels_header
from .tables import model_header, network_header, table_header

PLATFORMS = ("linux64", "win64", "darwin64")
ALONE = "needs nothing but itself"
NEEDS = "Needs nothing from outside.  sources/ holds the C sources; `fmpy compile` builds them for other platforms."
_CAPABILITIES = ("canNotUseMemoryManagementFunctions", "canGetAndSetFMUstate", "canSerializeFMUstate")
_HERE = Path(__file__).parent
_OF_THE_LAW = (
    "braking.c",
    "braking.h",
    "certificate.c",
    "certificate.h",
    "choice.c",
    "cooperation.c",
    "cooperation.h",
    "feasible.c",
    "motion.c",
    "network.c",
    "parameters.c",
    "slope.h",
    "speeds.h",
)
_OF_ACTUATORS = ("actuation.c", "actuation.h", "actuators.c", "pieces.h", "ride.c", "ride.h")
_OWN_SOURCES = {  # of each component, by the header that defines an instance; all have what is not listed
    "platoon_model.h": (
        *_OF_THE_LAW,
        *_OF_ACTUATORS,
        "platoon.h",
        "platoon_backend.c",
        "platoon_clock.c",
        "platoon_derivatives.c",
        "platoon_law.c",
        "platoon_lemma1.c",
        "platoon_membership.c",
        "platoon_restore.c",
        "platoon_start.c",
        "platoon_trial.c",
        "platoon_trial.h",
    ),
    "controller_model.h": (
        *_OF_THE_LAW,
        *_OF_ACTUATORS,
        "controller.h",
        "controller_backend.c",
        "controller_law.c",
        "controller_margin.c",
        "controller_measurement.c",
        "controller_members.c",
        "controller_restore.c",
        "controller_sample.c",
        "controller_settings.c",
        "prediction.c",
        "prediction.h",
        "uncertain.c",
        "uncertain.h",
    ),
    "plant_model.h": (
        *_OF_ACTUATORS,
        "plant.h",
        "plant_backend.c",
        "plant_motion.c",
        "plant_restore.c",
        "plant_settings.c",
    ),
    "leader_model.h": ("leader_backend.c",),
}


@dataclass(frozen=True)
class NativeFmu:
    """What a native FMU is made from.

    Attributes
    ----------
    name, description : of the FMU
    header : in c/, defines an instance
    vehicles : n
    table : its variables
    networks : that go into it, by number of vehicles; none into a plant or a leader
    notes : paragraphs of its page
    capabilities : attributes of CoSimulation that are true
    more : further files, content by name
    headers : further C headers that only this component has, text by name
    """

    name: str
    description: str
    header: str
    vehicles: int
    table: tuple[Variable, ...]
    networks: Mapping[int, NetworkFile]
    notes: tuple[str, ...]
    capabilities: tuple[str, ...] = _CAPABILITIES
    more: Mapping[str, bytes] = field(default_factory=dict)
    headers: Mapping[str, str] = field(default_factory=dict)

    def sources(self, guid: str) -> dict[str, bytes]:
        """All files that a C compiler needs besides FMI's headers, by file name.

        Parameters
        ----------
        guid : of the FMU
        """
        mine = {self.header, *_OWN_SOURCES[self.header]}  # several components may share a file
        others = {name for own in _OWN_SOURCES for name in (own, *_OWN_SOURCES[own])} - mine
        found = {name: (SOURCES / name).read_bytes() for name in FRONT}
        found |= {p.name: p.read_bytes() for p in sorted((_HERE / "c").glob("*.[ch]")) if p.name not in others}
        generated = {
            "psp_kernels.h": kernels_header(),
            "psp_model.h": model_header(self.table, self.vehicles, guid, self.networks, self.header),
            "psp_prefix.h": prefix_header(self.name),
            "psp_table.h": table_header(self.table),
        }
        generated |= {"psp_network.h": network_header(self.networks)} if "network.c" in found else self.headers
        return found | {name: text.encode() for name, text in generated.items()}


def chosen_platforms(platforms: str) -> tuple[str, ...]:
    """The platforms meant by `host` or `all`."""
    return PLATFORMS if platforms == "all" else (host_platform(),)


def native_platoon(vehicles: int, networks: Mapping[int, NetworkFile]) -> NativeFmu:
    """The closed loop.

    Parameters
    ----------
    vehicles : largest number of vehicles N, at least 2
    networks : from `networks_up_to`; without one for N parameter_source defaults to 2
    """
    table = platoon.platoon_table(vehicles, 1 if vehicles in networks else 2)
    reader = networks[vehicles].reader if vehicles in networks else None
    return NativeFmu(
        name="PspPlatoonNative",
        description=f"{platoon.DESCRIPTION}; {ALONE}",
        header="platoon_model.h",
        vehicles=vehicles,
        table=table,
        networks=networks,
        notes=(*notes_on_networks(networks), NEEDS),
        # the output of a network has no derivative here: declared only if alpha, r, p are fixed by default
        capabilities=_CAPABILITIES if vehicles in networks else (*_CAPABILITIES, "providesDirectionalDerivative"),
        more=layered_standard(table, reference_results(table, reader)),
    )


def native_controller(capacity: int, networks: Mapping[int, NetworkFile]) -> NativeFmu:
    """The controller of measured vehicles.

    Parameters
    ----------
    capacity : largest number of vehicles N, at least 2
    networks : from `networks_up_to`; without any parameter_source defaults to 2
    """
    return NativeFmu(
        name="PspControllerNative",
        description=f"{controller.DESCRIPTION}; {ALONE}",
        header="controller_model.h",
        vehicles=capacity,
        table=controller.controller_table(capacity, 1 if networks else 2),
        networks=networks,
        notes=(*notes_on_networks(networks), NEEDS),
    )


def build_native_fmu(fmu: NativeFmu, output: Path, platforms: Sequence[str] | None = None) -> Path:
    """Write a native FMU; the same tree and the same tools give the same bytes.

    Parameters
    ----------
    fmu : what it is made from
    output : folder
    platforms : of PLATFORMS; this machine's without

    Returns
    -------
    path of the FMU
    """
    component = Component(fmu.name, fmu.description, version("psp-platoon"), "", capabilities=fmu.capabilities)
    packed = {
        "documentation/index.html": index_page(component, fmu.vehicles, fmu.table, fmu.notes),
        "documentation/licenses/license.txt": licence(),
        "model.png": (_HERE.parent / "model.png").read_bytes(),
    }
    packed |= fmu.more
    guid = guid_of(content_digest(packed | fmu.sources("") | {"table": model_description(component, fmu.table)}))
    sources = fmu.sources(guid)
    names = tuple(sorted(name for name in sources if name.endswith(".c")))
    packed["modelDescription.xml"] = model_description(replace(component, guid=guid, source_files=names), fmu.table)
    packed |= {f"sources/{name}": content for name, content in (fmi_headers() | sources).items()}
    for platform in platforms or (host_platform(),):
        packed[f"binaries/{platform}/{fmu.name}.{ENDINGS[platform]}"] = compile_library(platform, fmu.name, sources)
    path = output / f"{fmu.name}.fmu"
    write_fmu(path, packed)
    return path
