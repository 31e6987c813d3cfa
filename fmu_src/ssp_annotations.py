"""What an .ssd says to single masters: the communication step, which SSP 1.0 has no place for, as each of them reads it."""

from __future__ import annotations

from collections.abc import Mapping
from decimal import Decimal
from xml.etree.ElementTree import Element, SubElement

_OMS = "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd"
_MCX = "com.avl.model.connect.ssp.task"  # both the type of the annotation and its namespace
_OSP = "http://opensimulationplatform.com/SSP/OSPAnnotations"
_SOLVER = "oms-ma"  # OMSimulator's master with a fixed step
_TOLERANCE = 1e-6  # OMSimulator asks for one; a master with a fixed step does not use it


def _decimal(value: float) -> str:
    """Digits without an exponent, as an xs:decimal has none."""
    return format(Decimal(repr(value)), "f")


def _add(parent: Element, contents: Mapping[str, Element]) -> None:
    listed = SubElement(parent, "ssd:Annotations")
    for kind, content in contents.items():
        SubElement(listed, "ssc:Annotation", type=kind).append(content)


def _openmodelica(attributes: Mapping[str, str]) -> tuple[Element, Element]:
    """The annotation's content, and the element in it that tells how to simulate."""
    content = Element("oms:Annotations", {"xmlns:oms": _OMS})
    return content, SubElement(content, "oms:SimulationInformation", dict(attributes))


def annotate_component(component: Element) -> None:
    """Name OMSimulator's solver for a component.

    Parameters
    ----------
    component : gets the annotation as its last element
    """
    content, _ = _openmodelica({"name": _SOLVER})
    _add(component, {"org.openmodelica": content})


def annotate_system(system: Element, step_size: float) -> None:
    """State the step for OMSimulator: attributes for its Python interface, an element for its older command line.

    Parameters
    ----------
    system : gets the annotation as its last element
    step_size : [s]
    """
    step = _decimal(step_size)
    content, information = _openmodelica({"name": _SOLVER, "method": "oms_ma", "fixedStepSize": step})
    master = {"description": _SOLVER, "stepSize": step, "relativeTolerance": _decimal(_TOLERANCE)}
    SubElement(information, "oms:FixedStepMaster", master)
    _add(system, {"org.openmodelica": content})


def annotate_experiment(experiment: Element, step_size: float) -> None:
    """State the step for OpenMCx, which would take 0.01 s, and for libcosim.

    Parameters
    ----------
    experiment : the default experiment; gets the annotations
    step_size : [s]
    """
    step = _decimal(step_size)
    task = Element("mc:Task", {"xmlns:mc": _MCX, "stepType": "sequential", "deltaTime": step})
    algorithm = Element("osp:Algorithm", {"xmlns:osp": _OSP})
    SubElement(algorithm, "osp:FixedStepAlgorithm", baseStepSize=step)
    _add(experiment, {_MCX: task, "com.opensimulationplatform": algorithm})
