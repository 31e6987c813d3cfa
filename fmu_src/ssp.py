"""A system of FMUs as one flat .ssp file: connectors on components, connections between them (SSP 1.0)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from .packing import write_fmu

_SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
_SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
_SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"

Connector = tuple[str, str]  # component, variable


def _component(
    parent: Element, name: str, fmu: Path, connectors: Mapping[str, str], values: Mapping[str, float]
) -> None:
    source = f"resources/{fmu.name}"
    attributes = {"name": name, "type": "application/x-fmu-sharedlibrary", "source": source}
    component = SubElement(parent, "ssd:Component", attributes)
    listed = SubElement(component, "ssd:Connectors")
    for variable, kind in connectors.items():
        SubElement(SubElement(listed, "ssd:Connector", name=variable, kind=kind), "ssc:Real")
    if values:
        binding = SubElement(SubElement(component, "ssd:ParameterBindings"), "ssd:ParameterBinding")
        found = SubElement(SubElement(binding, "ssd:ParameterValues"), "ssv:ParameterSet", version="1.0", name=name)
        parameters = SubElement(found, "ssv:Parameters")
        for parameter, value in values.items():
            kind = "Integer" if isinstance(value, int) else "Real"
            SubElement(SubElement(parameters, "ssv:Parameter", name=parameter), f"ssv:{kind}", value=repr(value))


def write_ssp(
    path: Path,
    fmus: Mapping[str, Path],
    connections: Sequence[tuple[Connector, Connector]],
    values: Mapping[str, Mapping[str, float]] | None = None,
    stop_time: float = 20.0,
) -> Path:
    """Write the archive; the same arguments give the same bytes.

    Parameters
    ----------
    path : of the .ssp file
    fmus : by name of the component
    connections : from an output to an input each
    values : parameters of the components, inline (some masters do not read them)
    stop_time : of the default experiment [s]

    Returns
    -------
    path
    """
    names = {"xmlns:ssd": _SSD, "xmlns:ssc": _SSC, "xmlns:ssv": _SSV, "version": "1.0", "name": path.stem}
    root = Element("ssd:SystemStructureDescription", names)
    system = SubElement(root, "ssd:System", name=path.stem)
    elements = SubElement(system, "ssd:Elements")
    for name, fmu in fmus.items():
        outputs = {variable: "output" for (owner, variable), _ in connections if owner == name}
        inputs = {variable: "input" for _, (owner, variable) in connections if owner == name}
        _component(elements, name, fmu, inputs | outputs, (values or {}).get(name, {}))
    listed = SubElement(system, "ssd:Connections")
    for (one, output), (other, target) in connections:
        ends = {"startElement": one, "startConnector": output, "endElement": other, "endConnector": target}
        SubElement(listed, "ssd:Connection", ends)
    SubElement(root, "ssd:DefaultExperiment", startTime="0.0", stopTime=repr(stop_time))
    indent(root)
    description = b'<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="utf-8") + b"\n"
    files = {"SystemStructure.ssd": description} | {f"resources/{f.name}": f.read_bytes() for f in fmus.values()}
    write_fmu(path, files)
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
    return write_ssp(path, fmus, connections, settings)
