"""The files that SUMO reads: a straight road of one lane, with an acceleration lane where there is a ramp; vehicles."""

from __future__ import annotations

import os
import subprocess
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from .driver import Driver
from .scenario import LANE_END, LENGTH, RAMP_END, ROAD_END, Scenario

EMISSIONS = "HBEFA4/PC_petrol_Euro-6ab"

_NODES = f"""<nodes>
<node id="A" x="0" y="0"/><node id="B" x="{RAMP_END}" y="0"/><node id="C" x="{LANE_END}" y="0"/>
<node id="D" x="{ROAD_END}" y="0"/></nodes>"""
_EDGES = """<edges>
<edge id="before" from="A" to="B" numLanes="{lanes}" speed="40"/>
<edge id="beside" from="B" to="C" numLanes="{lanes}" speed="40"/>
<edge id="after" from="C" to="D" numLanes="1" speed="40"/></edges>"""
_CONNECTION = """<connection from="{}" to="{}" fromLane="{}" toLane="{}"/>"""


def sumo_home() -> Path:
    """SUMO's folder, also given to the environment, where libsumo looks for it."""
    import sumo

    home = Path(sumo.__file__).parent
    os.environ["SUMO_HOME"] = str(home)
    return home


def through_lanes(scenario: Scenario) -> dict[str, int]:
    """The through lane of each edge; the lanes right of it are the ramp and its acceleration lane.

    Parameters
    ----------
    scenario : with or without vehicles on the ramp

    Returns
    -------
    number of the lane, from the right, by the name of the edge
    """
    through = 1 if scenario.merging else 0
    return {"before": through, "beside": through, "after": 0}


def write_road(folder: Path, scenario: Scenario) -> Path:
    """Write the network file.

    Parameters
    ----------
    folder : for the file
    scenario : has a second lane beside the through lane only where vehicles come from the ramp
    """
    path = folder / "road.net.xml"
    path.write_bytes(_network(2 if scenario.merging else 1))
    return path


@cache
def _network(lanes: int) -> bytes:
    """What SUMO's netconvert makes of the road, once for all runs of a process."""
    pairs = [("before", "beside", lane, lane) for lane in range(lanes)] + [("beside", "after", lanes - 1, 0)]
    connections = "".join(_CONNECTION.format(*pair) for pair in pairs)
    parts = {
        "node": _NODES,
        "edge": _EDGES.format(lanes=lanes),
        "connection": f"<connections>{connections}</connections>",
    }
    with TemporaryDirectory() as name:
        for kind, text in parts.items():
            Path(name, f"road.{kind}.xml").write_text(text)
        network = Path(name, "road.net.xml")
        options = [f"--{kind}-files={name}/road.{kind}.xml" for kind in parts]
        quiet = ["--no-internal-links", "--no-turnarounds", "--no-warnings", "--junctions.corner-detail=0"]
        command = [str(sumo_home() / "bin" / "netconvert"), *options, *quiet, f"--output-file={network}"]
        subprocess.run(command, check=True, capture_output=True)
        return network.read_bytes()


def _start(x: float) -> str:
    """Edge and position on it, as attributes of a vehicle."""
    edges = (("before", 0.0), ("beside", RAMP_END), ("after", LANE_END))
    edge, begin = next((e, b) for e, b in reversed(edges) if x > b + LENGTH)
    names = [name for name, _ in edges]
    route = " ".join(names[names.index(edge) :])
    return f'departPos="{x - begin!r}"><route edges="{route}"/>'


def write_vehicles(folder: Path, scenario: Scenario, driver: Driver) -> Path:
    """Write the route file; vehicles are called 0, 1, ... from the leader back, those on the ramp come last.

    Parameters
    ----------
    folder : for the file
    scenario : starts
    driver : who drives
    """
    attributes: dict[str, str | float] = {
        "length": LENGTH,
        "emissionClass": EMISSIONS,
        "sigma": 0,
        "speedFactor": 1,
        "speedDev": 0,
    }
    attributes |= {"maxSpeed": 60.0} | dict(driver.vehicle_type)
    listed = " ".join(f'{name}="{value}"' for name, value in attributes.items())
    rows = ["<routes>", f'<vType id="car" {listed}/>']
    through, x = through_lanes(scenario)["before"], scenario.x_leader
    starts = []
    for i, speed in enumerate(scenario.v):
        x -= scenario.s[i - 1] if i else 0.0
        starts.append((x, float(speed), through if x < LANE_END else 0))
    starts += [(x, speed, 0) for x, speed in scenario.merging]
    for i, (x, speed, lane) in enumerate(starts):
        rows.append(
            f'<vehicle id="{i}" type="car" depart="0" insertionChecks="none" departSpeed="{speed!r}" '
            f'departLane="{lane}" {_start(float(x))}</vehicle>'
        )
    path = folder / "vehicles.rou.xml"
    path.write_text("\n".join([*rows, "</routes>"]))
    return path
