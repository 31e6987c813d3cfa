"""A system of FMUs as one flat .ssp file: connectors on components, connections between them (SSP 1.0).

SystemStructure.ssd is what a master opens by default.  Each scenario is an .ssd file of its own, because
a master applies all parameters that one .ssd binds: of two values for a parameter, the last wins.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from fmpy import read_model_description

from ..errors import ParameterError
from .archive import write_fmu
from .ssp_annotations import annotate_experiment, annotate_system

_SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
_SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
_SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"

Connector = tuple[str, str]  # component, variable
Values = Mapping[str, float]  # an int means an Integer

STOP_TIME = 20.0  # [s]
SCENARIOS: Mapping[str, Values] = {  # the paper's, from the start values of the FMU
    "scenario1": {"potential": 1, "lemma1_policy": 1},
    "scenario2": {"potential": 2, "lemma1_policy": 1},
}


@dataclass(frozen=True)
class SystemComponent:
    """One FMU of a system.

    Attributes
    ----------
    fmu : the file
    connectors : kind (input, output, parameter) and type (Real, Integer) by name of the variable
    parameter_sets : values of all parameters by scenario; fmpy does not read them
    """

    fmu: Path
    connectors: Mapping[str, tuple[str, str]]
    parameter_sets: Mapping[str, Values] = field(default_factory=dict)


def parameters_of(fmu: Path) -> dict[str, float]:
    """Start values of an FMU's parameters by name; an int for an Integer.

    Parameters
    ----------
    fmu : the file
    """
    rows = read_model_description(str(fmu), validate=False).modelVariables
    found = {row.name: (row.type, row.start) for row in rows if row.causality == "parameter"}
    return {name: int(start) if kind == "Integer" else float(start) for name, (kind, start) in found.items()}


def with_values(parameters: Values, values: Values) -> dict[str, float]:
    """All parameters of an FMU, with the given values in place of their start values.

    Parameters
    ----------
    parameters : from `parameters_of`
    values : by name; names that are not parameters of this FMU are ignored

    Raises
    ------
    ParameterError : if a value is not finite, or a number for an Integer is not whole
    """
    found: dict[str, float] = {}
    for name, start in parameters.items():
        value = values.get(name, start)
        if not isfinite(value) or (isinstance(start, int) and value != int(value)):
            kind = "whole" if isinstance(start, int) else "finite"
            raise ParameterError(f"{name} = {value!r} must be a {kind} number", "give it one")
        found[name] = int(value) if isinstance(start, int) else float(value)
    return found


def parameter_connectors(parameters: Values) -> dict[str, tuple[str, str]]:
    """The connectors of a component's parameters.

    Parameters
    ----------
    parameters : from `parameters_of`
    """
    return {name: ("parameter", "Integer" if isinstance(start, int) else "Real") for name, start in parameters.items()}


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


def _write_component(parent: Element, name: str, component: SystemComponent, scenario: str) -> None:
    source = f"resources/{component.fmu.name}"
    attributes = {"name": name, "type": "application/x-fmu-sharedlibrary", "source": source}
    element = SubElement(parent, "ssd:Component", attributes)
    listed = SubElement(element, "ssd:Connectors")
    for variable, (kind, of_type) in component.connectors.items():
        SubElement(SubElement(listed, "ssd:Connector", name=variable, kind=kind), f"ssc:{of_type}")
    if component.parameter_sets:
        binding = SubElement(SubElement(element, "ssd:ParameterBindings"), "ssd:ParameterBinding")
        holder = SubElement(binding, "ssd:ParameterValues")
        holder.append(parameter_set(scenario, component.parameter_sets[scenario]))


@dataclass(frozen=True)
class System:
    """FMUs, their connections, and the duration and step of the run.

    Attributes
    ----------
    name : of the system
    components : by name
    connections : from an output to an input each
    stop_time, step_size : of the default experiment [s]
    """

    name: str
    components: Mapping[str, SystemComponent]
    connections: Sequence[tuple[Connector, Connector]] = ()
    stop_time: float = STOP_TIME
    step_size: float = 0.01


def system_description(system: System, title: str, scenario: str) -> bytes:
    """An .ssd file.

    Parameters
    ----------
    system : what it describes
    title : of the variant that it is
    scenario : whose parameters it binds
    """
    names = {"xmlns:ssd": _SSD, "xmlns:ssc": _SSC, "version": "1.0", "name": title}
    root = Element("ssd:SystemStructureDescription", names)
    inside = SubElement(root, "ssd:System", name=system.name)
    elements = SubElement(inside, "ssd:Elements")
    for name, component in system.components.items():
        _write_component(elements, name, component, scenario)
    if system.connections:
        listed = SubElement(inside, "ssd:Connections")
        for (one, output), (other, target) in system.connections:
            ends = {"startElement": one, "startConnector": output, "endElement": other, "endConnector": target}
            SubElement(listed, "ssd:Connection", ends)
    annotate_system(inside, system.step_size)
    experiment = SubElement(root, "ssd:DefaultExperiment", startTime="0.0", stopTime=repr(system.stop_time))
    annotate_experiment(experiment, system.step_size)
    return xml_file(root)


def write_ssp(
    path: Path, system: System, default: str, scenarios: Sequence[str] = (), more: Mapping[str, bytes] | None = None
) -> Path:
    """Write the archive; the same arguments give the same bytes.

    Parameters
    ----------
    path : of the .ssp file
    system : what is in it
    default : scenario of SystemStructure.ssd
    scenarios : those with an .ssd of their own, NAME.ssd
    more : further files in resources/, content by name

    Returns
    -------
    path
    """
    files = {"SystemStructure.ssd": system_description(system, system.name, default)}
    files |= {f"{scenario}.ssd": system_description(system, scenario, scenario) for scenario in scenarios}
    inside = {component.fmu.name: component.fmu.read_bytes() for component in system.components.values()}
    write_fmu(path, files | {f"resources/{name}": content for name, content in (inside | dict(more or {})).items()})
    return path
