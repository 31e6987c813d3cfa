"""Build the platoon FMU: `python build_fmu.py --vehicles 7 --output dist`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from fmu_src.errors import BuildError
from fmu_src.python_runtime import NetworkFile, build_python_fmu, networks_up_to
from psp_model import ModelError, PspError

MOST_VEHICLES = 10_000
COMPONENTS = ["platoon", "controller", "plant", "leader"]
CONTROLLED = ("platoon", "controller")  # components with networks, and with a native runtime


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """The command line.

    Parameters
    ----------
    arguments : without the program's name; None for those of the process
    """
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--vehicles", type=int, default=7, metavar="N", help="most vehicles, at least 2 (7)")
    text = "platoon: the closed loop, whose vehicles may join and leave; controller: for other vehicles; "
    text += "plant: ideal vehicles; leader: a speed profile (platoon)"
    parser.add_argument("--component", choices=COMPONENTS, default="platoon", help=text)
    parser.add_argument("--output", type=Path, default=Path("dist"), metavar="DIR", help="folder to write to (dist)")
    parser.add_argument("--runtime", choices=["python", "native"], default="python", help="of the FMU (python)")
    text = "native: libraries for this machine, or for Linux, Windows and macOS (host)"
    parser.add_argument("--platforms", choices=["host", "all"], default="host", help=text)
    parser.add_argument("--network", type=Path, metavar="FILE", help="network instead of onnx/platoon_N.onnx")
    text = "leader: drives this speed profile, a CSV file with time [s] and speed [m/s], instead of a wave"
    parser.add_argument("--profile", type=Path, metavar="FILE", help=text)
    return parser.parse_args(arguments)


def networks_for(options: argparse.Namespace) -> dict[int, NetworkFile]:
    """The networks that go into the FMU asked for, by number of vehicles.

    Parameters
    ----------
    options : from `parse`

    Raises
    ------
    ModelError : where a file is unreadable or made for another number of vehicles
    """
    return networks_up_to(options.vehicles, options.network) if options.component in CONTROLLED else {}


def build_native(options: argparse.Namespace, networks: Mapping[int, NetworkFile]) -> Path:
    """Build the native FMU asked for.

    Parameters
    ----------
    options : from `parse`
    networks : from `networks_for`

    Raises
    ------
    BuildError : where what builds the native FMU is missing, or there is none
    """
    if options.component not in CONTROLLED:
        raise BuildError(f"--component {options.component} has no native runtime: leave --runtime native out")
    try:
        from fmu_src.native.build import build_native_fmu, chosen_platforms, native_controller, native_platoon
    except ImportError as error:
        raise BuildError(f"the native FMU needs {error.name}: pip install 'psp-platoon[native]'") from None
    make = native_platoon if options.component == "platoon" else native_controller
    return build_native_fmu(make(options.vehicles, networks), options.output, chosen_platforms(options.platforms))


def build(options: argparse.Namespace, networks: Mapping[int, NetworkFile]) -> Path:
    """Build the FMU asked for.

    Parameters
    ----------
    options : from `parse`
    networks : from `networks_for`

    Raises
    ------
    BuildError : where an option does not apply, or what builds the native FMU is missing
    """
    if options.component not in CONTROLLED and options.network:
        raise BuildError(f"--component {options.component} has no network: leave --network out")
    if options.component != "leader" and options.profile:
        raise BuildError(f"--component {options.component} takes no --profile: leave it out, or build the leader")
    if options.runtime == "native":
        return build_native(options, networks)
    if options.component == "platoon":
        return build_python_fmu(options.vehicles, options.output, networks)
    from fmu_src import traffic_runtime as traffic

    makers: dict[str, Callable[[int, Path], Path]] = {
        "controller": partial(traffic.build_controller_fmu, networks=networks),
        "plant": traffic.build_plant_fmu,
        "leader": partial(traffic.build_leader_fmu, profile=options.profile),
    }
    return makers[options.component](options.vehicles, options.output)


def main(arguments: list[str] | None = None) -> int:
    """Build what the command line asks for and say what was built.

    Returns
    -------
    exit code: 0, or 2 where the command line or a file is at fault
    """
    options = parse(arguments)
    try:
        if options.vehicles < 2:
            raise ModelError("vehicles", options.vehicles)
        if options.vehicles > MOST_VEHICLES:
            raise BuildError(f"{options.vehicles} vehicles are too many for one FMU: choose at most {MOST_VEHICLES}")
        networks = networks_for(options)
        path = build(options, networks)
    except (PspError, OSError) as error:
        print(f"build_fmu.py: {error}", file=sys.stderr)
        return 2
    print(f"{path}: {options.vehicles} vehicles, {path.stat().st_size / 1024:.0f} KiB")
    if options.component == "platoon" and options.vehicles not in networks:
        print(
            f"There is no network for {options.vehicles} vehicles: parameter_source starts at 2, a fixed alpha, r, p."
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
