"""Build the platoon FMU: `python build_fmu.py --vehicles 7 --output dist`."""

from __future__ import annotations

if __name__ == "__main__":  # before the imports that take time
    from psp_cli.interrupt import install

    install("build_fmu.py")

import argparse
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from fmu_src.errors import BuildError
from fmu_src.networks import NetworkFile, networks_up_to
from fmu_src.python.build import build_python_fmu
from psp_model import ModelError, PspError
from psp_model.installed.extras import BRINGS, require

MOST_VEHICLES = 10_000
COMPONENTS = ["platoon", "controller", "plant", "leader"]
CONTROLLED = ("platoon", "controller")  # components with networks


@dataclass(frozen=True)
class Options:
    """What to build.

    Attributes
    ----------
    vehicles : most vehicles
    component : one of COMPONENTS
    output : folder to write to
    runtime : python or native
    platforms : of the native runtime: host or all
    network : file to use instead of onnx/platoon_N.onnx
    profile : file with the speed that the leader drives
    """

    vehicles: int = 7
    component: str = "platoon"
    output: Path = Path("dist")
    runtime: str = "python"
    platforms: str = "host"
    network: Path | None = None
    profile: Path | None = None


def parse(arguments: list[str] | None) -> Options:
    """The command line.

    Parameters
    ----------
    arguments : without the program's name; None for those of the process
    """
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--vehicles", type=int, default=7, metavar="N", help="most vehicles, at least 2 (7)")
    text = "platoon: the closed loop, whose vehicles may join and leave; controller: for other vehicles; "
    text += "plant: vehicles to control; leader: a speed profile (platoon)"
    parser.add_argument("--component", choices=COMPONENTS, default="platoon", help=text)
    parser.add_argument("--output", type=Path, default=Path("dist"), metavar="DIR", help="folder to write to (dist)")
    parser.add_argument("--runtime", choices=["python", "native"], default="python", help="of the FMU (python)")
    text = "native: libraries for this machine, or for Linux, Windows and macOS (host)"
    parser.add_argument("--platforms", choices=["host", "all"], default="host", help=text)
    parser.add_argument("--network", type=Path, metavar="FILE", help="network instead of onnx/platoon_N.onnx")
    text = "leader: drives this speed profile, a CSV file with time [s] and speed [m/s], instead of a wave"
    parser.add_argument("--profile", type=Path, metavar="FILE", help=text)
    return Options(**vars(parser.parse_args(arguments)))


def networks_for(options: Options) -> dict[int, NetworkFile]:
    """The networks that go into the FMU asked for, by number of vehicles.

    Parameters
    ----------
    options : what to build

    Raises
    ------
    ModelError : where a file is unreadable or made for another number of vehicles
    """
    return networks_up_to(options.vehicles, options.network) if options.component in CONTROLLED else {}


def build_native(options: Options, networks: Mapping[int, NetworkFile]) -> Path:
    """Build the native FMU asked for.

    Parameters
    ----------
    options : what to build
    networks : from `networks_for`

    Raises
    ------
    MissingExtra : where what builds the native FMU is missing
    """
    require("a native FMU", "native", BRINGS["native"])
    from fmu_src.native.build import build_native_fmu, chosen_platforms
    from fmu_src.native.components import native_fmu

    fmu = native_fmu(options.component, options.vehicles, networks, options.profile)
    return build_native_fmu(fmu, options.output, chosen_platforms(options.platforms))


def build(options: Options, networks: Mapping[int, NetworkFile]) -> Path:
    """Build the FMU asked for.

    Parameters
    ----------
    options : what to build
    networks : from `networks_for`

    Raises
    ------
    MissingExtra : where what builds the native FMU is missing
    BuildError : where an option does not apply
    """
    if options.component not in CONTROLLED and options.network:
        raise BuildError(f"--component {options.component} has no network: leave --network out")
    if options.component != "leader" and options.profile:
        raise BuildError(f"--component {options.component} takes no --profile: leave it out, or build the leader")
    if options.runtime == "native":
        return build_native(options, networks)
    if options.component == "platoon":
        return build_python_fmu(options.vehicles, options.output, networks)
    from fmu_src.python import components as traffic

    makers: dict[str, Callable[[int, Path], Path]] = {
        "controller": partial(traffic.build_controller_fmu, networks=networks),
        "plant": traffic.build_plant_fmu,
        "leader": partial(traffic.build_leader_fmu, profile=options.profile),
    }
    return makers[options.component](options.vehicles, options.output)


def make(options: Options) -> tuple[Path, str]:
    """Check what is asked for, and build it.

    Parameters
    ----------
    options : what to build

    Returns
    -------
    the FMU, and a sentence on what it lacks, empty where it lacks nothing

    Raises
    ------
    PspError, OSError : where an option or a file is at fault, or what builds the FMU is missing
    """
    if options.vehicles < 2:
        raise ModelError("vehicles", options.vehicles)
    if options.vehicles > MOST_VEHICLES:
        raise BuildError(f"{options.vehicles} vehicles are too many for one FMU: choose at most {MOST_VEHICLES}")
    networks = networks_for(options)
    path = build(options, networks)
    if options.component != "platoon" or options.vehicles in networks:
        return path, ""
    lack = f"There is no network for {options.vehicles} vehicles: parameter_source starts at 2, a fixed alpha, r, p."
    return path, lack


def main(arguments: list[str] | None = None) -> int:
    """Build what the command line asks for and say what was built.

    Returns
    -------
    exit code: 0, or 2 where the command line or a file is at fault
    """
    options = parse(arguments)
    try:
        path, lack = make(options)
    except (PspError, OSError) as error:
        print(f"build_fmu.py: {error}", file=sys.stderr)
        return 2
    print(said_of(path, options))
    if lack:
        print(lack)
    return 0


def said_of(path: Path, options: Options) -> str:
    """The line that says what was built.

    Parameters
    ----------
    path, options : the FMU, and what was asked for
    """
    return f"{path}: {options.vehicles} vehicles, {path.stat().st_size / 1024:.0f} KiB"


if __name__ == "__main__":
    from psp_cli.interrupt import run

    run("build_fmu.py", main)
