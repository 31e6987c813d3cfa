"""highway-env, IDM on one lane: highway_env_peer.py VEHICLES.

As its own fast variant, highway-fast-v0: no vehicle but the first looks for collisions.  Steps of 1/15 s, its default
simulation frequency; spacings at which its IDM follows at 30 m/s.
"""

from __future__ import annotations

import sys

from answers import answer
from highway_env.road.road import Road, RoadNetwork
from highway_env.vehicle.behavior import IDMVehicle

GAP, SPEED = 60.0, 29.0  # [m] front to front, [m/s]


def main(vehicles: str) -> None:
    """Answer requests until there are no more."""
    n = int(vehicles)
    steps = max(1, min(50, 500 // n))

    def begin():
        network = RoadNetwork.straight_road_network(1, length=n * GAP + 10_000.0, speed_limit=30)
        road = Road(network=network, record_history=False)
        for i in range(n):
            place = road.network.get_lane(("0", "1", 0)).position((n - i) * GAP, 0)
            car = IDMVehicle(road, place, speed=SPEED, target_speed=30.0, enable_lane_change=False)
            car.check_collisions = i == 0
            road.vehicles.append(car)

        def run() -> None:
            for _ in range(steps):
                road.act()
                road.step(1 / 15)

        return run

    answer(begin, steps)


if __name__ == "__main__":
    main(*sys.argv[1:])
