"""cavsandbox, CACC on one lane: cavsandbox_peer.py VEHICLES.

Headless, with its defaults: steps of 0.01 s, exact sensors, actuators with lag, a log at 10 Hz as a data frame.
"""

from __future__ import annotations

import os
import sys

os.environ["PYGAME_HIDE_SUPPORT_PROMPT"] = "1"

import pandas as pd
from answers import answer
from cacc_sim import (
    CACCController,
    CACCModel,
    LeadVehicleModel,
    LeadVehicleProfile,
    PassthroughFilter,
    SimConfig,
    SimulationLoop,
    Vehicle,
    VehiclePlant,
    VehicleResponseModel,
)

STEP, GAP, SPEED, LENGTH = 0.01, 25.0, 30.0, 5.0  # [s], [m] bumper to bumper, [m/s], [m]


def main(vehicles: str) -> None:
    """Answer requests until there are no more."""
    n = int(vehicles)
    steps = max(10, min(100, 10_000 // n))
    profile = LeadVehicleProfile(pd.DataFrame({"time_s": [0.0], "value": [SPEED], "transition": ["ramp"]}))

    def begin():
        column = []
        for i in range(n):
            model = CACCModel(SPEED + 5.0, CACCController()) if i else LeadVehicleModel(profile)
            plant = VehiclePlant((n - i) * (GAP + LENGTH), SPEED, LENGTH, STEP)
            leader = i - 1 if i else None
            column.append(
                Vehicle(i, model, VehicleResponseModel(dt=STEP), plant, PassthroughFilter(), leader_id=leader)
            )
        for follower in column[1:]:
            follower.platoon_leader = column[0]
        config = SimConfig(duration_s=steps * STEP, road_length_m=n * (GAP + LENGTH) + 10_000.0, simulation_speed=0.0)
        return SimulationLoop(column, config).run

    answer(begin, steps)


if __name__ == "__main__":
    main(*sys.argv[1:])
