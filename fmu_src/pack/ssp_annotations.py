"""Annotations in an .ssd for single masters: the communication step, undefined in SSP 1.0, as each reads it."""

from __future__ import annotations

from collections.abc import Mapping
from decimal import Decimal
from xml.etree.ElementTree import Element, SubElement

_OMS = "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd"
_MCX = "com.avl.model.connect.ssp.task"  # both the type of the annotation and its namespace
_OSP = "http://opensimulationplatform.com/SSP/OSPAnnotations"
_SOLVER = "oms_ma_default"  # OMSimulator's Python name for the solver of an FMU that names none
_TOLERANCE = 1e-6  # OMSimulator requires one; a master with a fixed step does not use it


def _decimal(value: float) -> str:
    """Digits without an exponent, as an xs:decimal has none."""
    return format(Decimal(repr(value)), "f")


def _add(parent: Element, contents: Mapping[str, tuple[str, Element]]) -> None:
    """Add annotations: namespace and content by type.

    The namespace is declared outside the content: libcosim takes attributes of osp:Algorithm for algorithms.
    """
    listed = SubElement(parent, "ssd:Annotations")
    for kind, (namespace, content) in contents.items():
        prefix = content.tag.split(":")[0]
        SubElement(listed, "ssc:Annotation", {"type": kind, f"xmlns:{prefix}": namespace}).append(content)


def annotate_system(system: Element, step_size: float) -> None:
    """State the step for OMSimulator: attributes for its Python interface, an element for its command line.

    A component cannot name its solver: the command line rejects annotations there.

    Parameters
    ----------
    system : gets the annotation as its last element
    step_size : [s]
    """
    step = _decimal(step_size)
    content = Element("oms:Annotations")
    solver = {"name": _SOLVER, "method": "oms_ma", "fixedStepSize": step}
    information = SubElement(content, "oms:SimulationInformation", solver)
    master = {"description": "oms-ma", "stepSize": step, "relativeTolerance": _decimal(_TOLERANCE)}
    SubElement(information, "oms:FixedStepMaster", master)
    _add(system, {"org.openmodelica": (_OMS, content)})


def annotate_experiment(experiment: Element, step_size: float) -> None:
    """State the step for OpenMCx, which would take 0.01 s, and for libcosim.

    Parameters
    ----------
    experiment : the default experiment; gets the annotations
    step_size : [s]
    """
    step = _decimal(step_size)
    task = Element("mc:Task", stepType="sequential", deltaTime=step)
    algorithm = Element("osp:Algorithm")
    SubElement(algorithm, "osp:FixedStepAlgorithm", baseStepSize=step)
    _add(experiment, {_MCX: (_MCX, task), "com.opensimulationplatform": (_OSP, algorithm)})
