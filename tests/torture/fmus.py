"""The FMUs that the trials abuse: one line each."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from build_fmu import main as build
from harness import Unpacked


@dataclass(frozen=True)
class Build:
    """An FMU of ours.

    Attributes
    ----------
    name : in summaries and of its folder
    arguments : of build_fmu.py
    running : parameters with which a fresh instance takes steps without a warning
    """

    name: str
    arguments: tuple[str, ...]
    running: tuple[tuple[str, float], ...] = ()

    @property
    def native(self) -> bool:
        """Whether it runs without Python."""
        return "native" in self.arguments


SEVEN = ("--vehicles", "7")
PLATOONS = (
    Build("native platoon", (*SEVEN, "--runtime", "native")),
    Build("python platoon", SEVEN),
)
LATE = (("actuation_delay", 0.05), ("actuator_lag[2]", 0.2), ("a_min[3]", -4.0))
BUILDS = (
    *PLATOONS,
    Build("native controller", (*SEVEN, "--component", "controller", "--runtime", "native")),
    Build("python controller", (*SEVEN, "--component", "controller")),
    Build("native plant", (*SEVEN, "--component", "plant", "--runtime", "native"), LATE),
    Build("python plant", (*SEVEN, "--component", "plant"), LATE),
    Build("native leader", (*SEVEN, "--component", "leader", "--runtime", "native")),
    Build("python leader", (*SEVEN, "--component", "leader")),
)


def path_of(one: Build, folder: Path) -> Path:
    """The FMU, built where it is not there yet.

    Parameters
    ----------
    one : which
    folder : in which FMUs are kept
    """
    place = folder / one.name.replace(" ", "_")
    if not list(place.glob("*.fmu")) and build([*one.arguments, "--output", str(place)]) != 0:
        raise RuntimeError(f"{one.name} could not be built")
    (path,) = place.glob("*.fmu")
    return path


def unpacked(one: Build, folder: Path, to: Path) -> Unpacked:
    """The FMU, ready for instances.

    Parameters
    ----------
    one : which
    folder : in which FMUs are kept
    to : folder to unpack into
    """
    return Unpacked(path_of(one, folder), to / one.name.replace(" ", "_"))
