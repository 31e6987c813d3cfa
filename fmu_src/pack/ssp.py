"""A system of FMUs as one flat .ssp file: connectors on components, connections between them (SSP 1.0)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from .archive import write_fmu

_SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
_SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
_SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"

Connector = tuple[str, str]  # component, variable
Values = Mapping[str, float]  # an int stands for an Integer


@dataclass(frozen=True)
class SystemComponent:
    """One FMU of a system.

    Attributes
    ----------
    fmu : the file
    connectors : kind (input, output, parameter) and type (Real, Integer) by name of the variable
    parameter_sets : by name; some masters do not read them
    """

    fmu: Path
    connectors: Mapping[str, tuple[str, str]]
    parameter_sets: Mapping[str, Values] = field(default_factory=dict)


def xml_file(root: Element) -> bytes:
    """An XML document, indented.

    Parameters
    ----------
    root : its root
    """
    indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="utf-8") + b"\n"


def parameter_set(name: str, values: Values) -> Element:
    """Parameter values, for a component or for a .ssv file.

    Parameters
    ----------
    name : of the set
    values : by name of the parameter
    """
    root = Element("ssv:ParameterSet", {"version": "1.0", "name": name, "xmlns:ssv": _SSV})
    parameters = SubElement(root, "ssv:Parameters")
    for parameter, value in values.items():
        kind = "Integer" if isinstance(value, int) else "Real"
        SubElement(SubElement(parameters, "ssv:Parameter", name=parameter), f"ssv:{kind}", value=repr(value))
    return root


def _write_component(parent: Element, name: str, component: SystemComponent) -> None:
    source = f"resources/{component.fmu.name}"
    attributes = {"name": name, "type": "application/x-fmu-sharedlibrary", "source": source}
    element = SubElement(parent, "ssd:Component", attributes)
    listed = SubElement(element, "ssd:Connectors")
    for variable, (kind, of_type) in component.connectors.items():
        SubElement(SubElement(listed, "ssd:Connector", name=variable, kind=kind), f"ssc:{of_type}")
    if component.parameter_sets:
        bindings = SubElement(element, "ssd:ParameterBindings")
        for title, values in component.parameter_sets.items():
            holder = SubElement(SubElement(bindings, "ssd:ParameterBinding"), "ssd:ParameterValues")
            holder.append(parameter_set(title, values))


def write_ssp(
    path: Path,
    components: Mapping[str, SystemComponent],
    connections: Sequence[tuple[Connector, Connector]] = (),
    more: Mapping[str, bytes] | None = None,
    stop_time: float = 20.0,
) -> Path:
    """Write the archive; the same arguments give the same bytes.

    Parameters
    ----------
    path : of the .ssp file
    components : by name
    connections : from an output to an input each
    more : further files in resources/, content by name
    stop_time : of the default experiment [s]

    Returns
    -------
    path
    """
    names = {"xmlns:ssd": _SSD, "xmlns:ssc": _SSC, "version": "1.0", "name": path.stem}
    root = Element("ssd:SystemStructureDescription", names)
    system = SubElement(root, "ssd:System", name=path.stem)
    elements = SubElement(system, "ssd:Elements")
    for name, component in components.items():
        _write_component(elements, name, component)
    if connections:
        listed = SubElement(system, "ssd:Connections")
        for (one, output), (other, target) in connections:
            ends = {"startElement": one, "startConnector": output, "endElement": other, "endConnector": target}
            SubElement(listed, "ssd:Connection", ends)
    SubElement(root, "ssd:DefaultExperiment", startTime="0.0", stopTime=repr(stop_time))
    files = {component.fmu.name: component.fmu.read_bytes() for component in components.values()} | dict(more or {})
    inside = {f"resources/{name}": content for name, content in files.items()}
    write_fmu(path, {"SystemStructure.ssd": xml_file(root)} | inside)
    return path


def loop_connections(vehicles: int) -> list[tuple[Connector, Connector]]:
    """Plant to controller and back.

    Parameters
    ----------
    vehicles : n
    """
    measured = [f"s[{i}]" for i in range(2, vehicles + 1)] + [f"v[{i}]" for i in range(1, vehicles + 1)]
    forth = [(("plant", name), ("controller", name)) for name in measured]
    return forth + [(("controller", f"a[{i}]"), ("plant", f"a[{i}]")) for i in range(1, vehicles + 1)]


def write_loop(
    path: Path, plant: Path, controller: Path, vehicles: int, values: Mapping[str, float], leader: Path | None = None
) -> Path:
    """A platoon of a plant, a controller and perhaps a leader FMU; run it with a communication step of T/4.

    Masters that pass values on between steps only hand the command over one step late: the controller samples in the
    middle of the plant's period what held at its beginning, and the plant counts what it gets for the whole period.

    Parameters
    ----------
    path : of the .ssp file
    plant, controller : the FMUs
    vehicles : n
    values : start values of the closed loop, by the names of `PspPlatoon`; each component takes its own
    leader : FMU whose speed is the desired speed of all

    Returns
    -------
    path
    """
    T = float(values.get("T", 0.01))
    of_plant = {name: value for name, value in values.items() if name in ("T", "x_start") or "_start[" in name}
    of_controller = {name: value for name, value in values.items() if name == "T" or name not in of_plant}
    settings = {"plant": of_plant, "controller": of_controller | {"phase": 0.5 * T}}
    fmus, connections = {"plant": plant, "controller": controller}, loop_connections(vehicles)
    if leader is not None:
        fmus |= {"leader": leader}
        connections.append((("leader", "v"), ("controller", "v_desired")))
    components = {}
    for name, fmu in fmus.items():
        inputs = {variable: ("input", "Real") for _, (owner, variable) in connections if owner == name}
        outputs = {variable: ("output", "Real") for (owner, variable), _ in connections if owner == name}
        sets = {name: settings[name]} if settings.get(name) else {}
        components[name] = SystemComponent(fmu, inputs | outputs, sets)
    return write_ssp(path, components, connections)
