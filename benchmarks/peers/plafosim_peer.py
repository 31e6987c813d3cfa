"""plafosim, one platoon under CACC on one lane: plafosim_peer.py VEHICLES.

Its default step of 1 s, the only kind it is tested with; nothing recorded; run with PYTHONOPTIMIZE=1, as it recommends.
"""

from __future__ import annotations

import os
import sys
from tempfile import mkdtemp

from answers import answer
from plafosim.simulator import Simulator

STEPS = 20


def main(vehicles: str) -> None:
    """Answer requests until there are no more."""
    os.chdir(mkdtemp())  # it writes a summary where it runs

    def begin():
        simulator = Simulator(
            number_of_lanes=1,
            number_of_vehicles=int(vehicles),
            pre_fill=True,
            start_as_platoon=True,
            desired_speed=30.0,
            random_desired_speed=False,
            depart_desired=True,
            max_step=STEPS,
            random_seed=1,
            progress=False,
            record_end_trace=False,
        )
        return simulator.run

    answer(begin, STEPS)


if __name__ == "__main__":
    main(*sys.argv[1:])
