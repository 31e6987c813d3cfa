"""What is the controller worth in a traffic simulator that nobody here wrote?"""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from build_fmu import main as build
from psp_traffic.compare import compare
from psp_traffic.measures import Measures, table
from psp_traffic.scenario import highway


def main(duration: float = 60.0) -> dict[str, Measures]:
    """Seven vehicles from a start of the paper's, driven by the controller FMU and by SUMO's models.

    Needs `pip install 'psp-platoon[sumo]'`; `psp sumo` shows the ramp and the stop-and-go wave, too.
    """
    with TemporaryDirectory() as folder:
        build(["--component", "controller", "--output", folder])
        rows = compare(highway(duration=duration), Path(folder) / "PspController.fmu", seed=1)
    print(table(rows))
    return rows


if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))
