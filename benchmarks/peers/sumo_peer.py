"""SUMO through libsumo: sumo_peer.py CARFOLLOWMODEL VEHICLES.

As its documents have it for speed: libsumo and not TraCI, no GUI, no step log, no output files.  Steps of 0.1 s, which
is what its car-following models are made for below SUMO's default of 1 s.
"""

from __future__ import annotations

import os
import subprocess
import sys
import warnings
from pathlib import Path
from tempfile import TemporaryDirectory

import sumo
from answers import answer

STEP, STEPS, GAP, SPEED = 0.1, 50, 30.0, 30.0  # [s], of a segment, [m] front to front, [m/s]


def files(folder: Path, model: str, vehicles: int) -> list[str]:
    """A straight lane, and a column of vehicles on it, all there from the beginning."""
    length = vehicles * GAP + 2000.0
    (folder / "road.nod.xml").write_text(f'<nodes><node id="A" x="0" y="0"/><node id="B" x="{length}" y="0"/></nodes>')
    (folder / "road.edg.xml").write_text('<edges><edge id="road" from="A" to="B" numLanes="1" speed="40"/></edges>')
    convert = [f"{os.environ['SUMO_HOME']}/bin/netconvert", "-n", "road.nod.xml", "-e", "road.edg.xml"]
    subprocess.run([*convert, "-o", "road.net.xml"], cwd=folder, check=True, capture_output=True)
    rows = [f'<vType id="car" carFollowModel="{model}" length="5" maxSpeed="{SPEED + 5}" sigma="0" speedDev="0"/>']
    rows.append('<route id="all" edges="road"/>')
    for i in range(vehicles):
        place = vehicles * GAP - i * GAP + 10.0
        rows.append(
            f'<vehicle id="{i}" type="car" route="all" depart="0" departPos="{place}" departSpeed="{SPEED}" '
            'insertionChecks="none"/>'
        )
    (folder / "cars.rou.xml").write_text("<routes>" + "\n".join(rows) + "</routes>")
    options = ["--no-step-log", "--no-warnings", "--step-length", str(STEP), "--time-to-teleport", "-1"]
    return ["-n", str(folder / "road.net.xml"), "-r", str(folder / "cars.rou.xml"), *options]


def main(model: str, vehicles: str) -> None:
    """Answer requests until there are no more."""
    os.environ["SUMO_HOME"] = str(Path(sumo.__file__).parent)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import libsumo

    with TemporaryDirectory() as name:
        arguments = files(Path(name), model, int(vehicles))
        libsumo.start(["sumo", *arguments])

        def begin():
            libsumo.load(arguments)
            libsumo.simulationStep()  # puts the vehicles on the road
            if libsumo.vehicle.getIDCount() != int(vehicles):
                sys.exit(f"{libsumo.vehicle.getIDCount()} of {vehicles} vehicles are on the road")

            def run() -> None:
                for _ in range(STEPS):
                    libsumo.simulationStep()

            return run

        answer(begin, STEPS)
        libsumo.close()


if __name__ == "__main__":
    main(*sys.argv[1:])
