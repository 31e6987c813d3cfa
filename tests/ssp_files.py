"""What the tests of .ssp archives ask of them; schemas: those that fmpy ships."""

from __future__ import annotations

import zipfile
from pathlib import Path

import fmpy
from lxml import etree

SCHEMAS = Path(fmpy.__file__).parent / "ssp" / "schema"
NAMESPACES = {
    "ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    "ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "oms": "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd",
    "mc": "com.avl.model.connect.ssp.task",
    "osp": "http://opensimulationplatform.com/SSP/OSPAnnotations",
}


def valid_files(ssp: Path) -> set[str]:
    """Names of the .ssd and .ssv files, each of which has been held against its schema."""
    kinds = {".ssd": "Description", ".ssv": "ParameterValues"}
    schemas = {end: etree.XMLSchema(file=str(SCHEMAS / f"SystemStructure{kind}.xsd")) for end, kind in kinds.items()}
    found = set()
    with zipfile.ZipFile(ssp) as archive:
        for name in archive.namelist():
            if name[-4:] in schemas:
                schemas[name[-4:]].assertValid(etree.fromstring(archive.read(name)))
                found.add(name)
    return found


def system_files(ssp: Path) -> dict[str, etree._Element]:
    """The roots of the .ssd files by name; all of them lie beside each other at the top."""
    with zipfile.ZipFile(ssp) as archive:
        return {name: etree.fromstring(archive.read(name)) for name in archive.namelist() if name.endswith(".ssd")}


def bound_parameters(root: etree._Element) -> dict[str, tuple[dict[str, float], dict[str, str]]]:
    """Values and types of what is bound, by component and parameter; nothing is bound twice."""
    found = {}
    for component in root.iterfind(".//ssd:Component", NAMESPACES):
        bound = component.findall(".//ssv:Parameter", NAMESPACES)
        values = {one.get("name"): float(one[0].get("value")) for one in bound}
        assert len(values) == len(bound)
        assert len(component.findall(".//ssd:ParameterBinding", NAMESPACES)) == 1
        types = {one.get("name"): etree.QName(one[0]).localname for one in bound}
        found[component.get("name")] = values, types
    return found


def steps_stated(root: etree._Element) -> list[float]:
    """The communication step as OMSimulator's Python, its command line, OpenMCx and libcosim read it [s]."""
    system, experiment = ("ssd:System/ssd:Annotations", "ssd:DefaultExperiment/ssd:Annotations")
    solver = f"{system}/ssc:Annotation[@type='org.openmodelica']/oms:Annotations/oms:SimulationInformation"
    paths = {
        solver: "fixedStepSize",
        f"{solver}/oms:FixedStepMaster": "stepSize",
        f"{experiment}/ssc:Annotation[@type='com.avl.model.connect.ssp.task']/mc:Task": "deltaTime",
        f"{experiment}/ssc:Annotation[@type='com.opensimulationplatform']/osp:Algorithm/*": "baseStepSize",
    }
    return [float(root.find(path, NAMESPACES).get(name)) for path, name in paths.items()]
