"""What is the controller worth in a traffic simulator that nobody here wrote?"""

from __future__ import annotations

if __name__ == "__main__":  # before the imports that take time
    from psp_cli.interrupt import install

    install("04_in_sumo.py")

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from build_fmu import main as build
from psp_traffic.compare import compare
from psp_traffic.measures import Measures
from psp_traffic.results import Results
from psp_traffic.scenario import highway
from psp_traffic.summary import table


def main(duration: float = 60.0) -> dict[str, list[Measures]]:
    """Seven vehicles from a start of the paper's, driven by the controller FMU and by SUMO's models.

    Needs the extra `sumo` (`pip install '.[sumo]'` in a checkout); `psp sumo` shows the ramp, the stop-and-go wave
    and the WLTC, too.
    """
    with TemporaryDirectory() as folder:
        build(["--component", "controller", "--output", folder])
        rows = compare({1: highway(seed=1, duration=duration)}, Path(folder) / "PspController.fmu", Results())
    print(table(rows))
    return rows


if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))
