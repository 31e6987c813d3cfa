"""modelDescription.xml from the table of variables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from .variables import Variable

MOST_LISTED = 400  # knowns of one output

BASE_UNITS: dict[str, dict[str, int]] = {
    "1": {"m": 0},  # an element without exponents is valid, but not read by all importers
    "m": {"m": 1},
    "s": {"s": 1},
    "m/s": {"m": 1, "s": -1},
    "m/s2": {"m": 1, "s": -2},
    "1/s": {"s": -1},
}

LOG_CATEGORIES = {
    "logStatusWarning": "Messages that come with fmi2Warning",
    "logStatusDiscard": "Messages that come with fmi2Discard",
    "logStatusError": "Messages that come with fmi2Error",
    "logStatusFatal": "Messages that come with fmi2Fatal",
    "logAll": "All messages",
}


@dataclass(frozen=True)
class Component:
    """The content of modelDescription.xml besides its variables.

    Attributes
    ----------
    name : model name and model identifier
    description : one sentence
    version : of the project
    guid : identifies the content of the FMU
    generation_tool : the tool that made it
    capabilities : attributes of CoSimulation that are true
    source_files : C sources to compile, relative to sources/
    stop_time, step_size : of the default experiment [s]
    tolerance : of the default experiment, relative; for importers that ask for one, as the FMUs integrate exactly
    """

    name: str
    description: str
    version: str
    guid: str
    generation_tool: str = "psp-platoon"
    capabilities: tuple[str, ...] = ()
    source_files: tuple[str, ...] = ()
    stop_time: float = 20.0
    step_size: float = 0.01
    tolerance: float = 1e-6


def _number(value: float, integer: bool) -> str:
    """The shortest text that reads back as the same number."""
    return str(int(value)) if integer else repr(float(value))


def _unit_definitions(root: Element, table: Sequence[Variable]) -> None:
    definitions = SubElement(root, "UnitDefinitions")
    for unit in dict.fromkeys(variable.unit for variable in table if not variable.integer):
        exponents = {base: str(power) for base, power in BASE_UNITS[unit].items()}
        SubElement(SubElement(definitions, "Unit", name=unit), "BaseUnit", exponents)


def _scalar_variable(parent: Element, reference: int, variable: Variable) -> None:
    attributes = {
        "name": variable.name,
        "valueReference": str(reference),
        "description": variable.description,
        "causality": variable.causality,
        "variability": variable.variability,
    }
    if variable.initial is not None:
        attributes["initial"] = variable.initial
    kind = {} if variable.integer else {"unit": variable.unit}
    bounds = {"min": variable.minimum, "max": variable.maximum, "nominal": variable.nominal, "start": variable.start}
    kind |= {name: _number(value, variable.integer) for name, value in bounds.items() if value is not None}
    SubElement(SubElement(parent, "ScalarVariable", attributes), variable.fmi_type, kind)


def _model_structure(root: Element, table: Sequence[Variable]) -> None:
    """Outputs depend on the inputs that the table names, their initial values also on the parameters that it names.

    No list means that an output depends on all: a long one that says so is left out, as the file would grow with N^2.
    """
    structure = SubElement(root, "ModelStructure")
    outputs, unknowns = SubElement(structure, "Outputs"), SubElement(structure, "InitialUnknowns")
    index = {variable.name: place for place, variable in enumerate(table, start=1)}
    parameters = [name for name, place in index.items() if table[place - 1].causality == "parameter"]
    knowns = len(parameters) + sum(variable.input for variable in table)
    made: dict[tuple[int, int], tuple[dict[str, str], dict[str, str]]] = {}  # many outputs share a tuple of names

    def listed(places: Sequence[int], every: int) -> dict[str, str]:
        return {} if len(places) == every > MOST_LISTED else {"dependencies": " ".join(map(str, places))}

    for variable in table:
        if variable.causality != "output":
            continue
        shared = id(variable.dependencies), id(variable.initial_dependencies)
        if shared not in made:
            known = parameters if variable.initial_dependencies is None else variable.initial_dependencies
            inputs = sorted(index[name] for name in variable.dependencies)
            at_start = sorted({*inputs, *(index[name] for name in known)})
            made[shared] = listed(inputs, knowns - len(parameters)), listed(at_start, knowns)
        place = {"index": str(index[variable.name])}
        SubElement(outputs, "Unknown", place | made[shared][0])
        SubElement(unknowns, "Unknown", place | made[shared][1])


def model_description(component: Component, table: Sequence[Variable]) -> bytes:
    """modelDescription.xml, FMI 2.0 co-simulation.

    Parameters
    ----------
    component : names, versions and capabilities
    table : the variables; value references are places in the table

    Returns
    -------
    the file's content, UTF-8; the same for the same arguments
    """
    root = Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=component.name,
        guid=component.guid,
        description=component.description,
        author="The psp-platoon authors",
        version=component.version,
        copyright="Copyright (c) 2026 The psp-platoon authors",
        license="MIT",
        generationTool=f"{component.generation_tool} {component.version}",
        variableNamingConvention="structured",
    )
    capabilities = {"canHandleVariableCommunicationStepSize": "true"} | dict.fromkeys(component.capabilities, "true")
    simulation = SubElement(root, "CoSimulation", {"modelIdentifier": component.name} | capabilities)
    if component.source_files:
        files = SubElement(simulation, "SourceFiles")
        for name in component.source_files:
            SubElement(files, "File", name=name)
    _unit_definitions(root, table)
    categories = SubElement(root, "LogCategories")
    for name, description in LOG_CATEGORIES.items():
        SubElement(categories, "Category", name=name, description=description)
    experiment = {"stopTime": component.stop_time, "tolerance": component.tolerance, "stepSize": component.step_size}
    numbers = {name: repr(value) for name, value in experiment.items()}
    SubElement(root, "DefaultExperiment", {"startTime": "0.0"} | numbers)
    variables = SubElement(root, "ModelVariables")
    for reference, variable in enumerate(table):
        _scalar_variable(variables, reference, variable)
    _model_structure(root, table)
    indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="utf-8") + b"\n"
