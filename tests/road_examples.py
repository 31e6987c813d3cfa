"""The part of `class_examples` that vehicles on a road need."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from psp_model import (
    BEST_FIXED,
    Actuation,
    Braking,
    Cooperation,
    DelayedVehicles,
    DrivenLeader,
    Errors,
    ExtendedLaw,
    PlatoonParameters,
    PlatoonState,
    RoadLaw,
    RoadPlant,
    Seen,
    Traffic,
    brake_margin,
    cooperative_command,
)
from psp_model.analysis.behind import BehindLeader
from psp_model.law.watching import watch
from psp_model.vehicles.actuation import Foreign, drive
from psp_model.vehicles.prediction import predict
from psp_model.vehicles.road_law import Remembered
from psp_model.vehicles.road_run import RoadRun, Sensing, run_on_road, started


def behind_leader() -> BehindLeader:
    """Three instants, the last of them with a contact."""
    time, apart = np.array([0.0, 0.1, 0.2]), np.array([[9.0, 8.0], [8.0, 7.0], [-1.0, 7.5]])
    v = np.array([[30.0, 29.0, 28.0], [29.0, 29.5, 28.0], [27.0, 29.0, 28.5]])
    return BehindLeader(time, 3 * v, v, apart + 5.0, apart, 0.1 * v, 0.2 * v, *np.ones((5, 3)))


Example = tuple[Callable[[], Any], Callable[[Any], Any]]
"""Makes an object; what that object does."""

CONSTANTS = PlatoonParameters()
PAIR = np.array([9.0, 14.0]), np.array([30.0, 28.5, 31.0])
COOPERATION = Cooperation(kappa=0.3, kappa_reach=25.0, time_gap=0.2, feedforward=0.8, closing_speed=2.0)
TRAFFIC = Traffic(np.array([0.0, 1.0, 1.0]), np.array([-0.5, 0.0, 0.0]), v_desired=29.0)
ACTUATION = Actuation(0.03, 0.2)
ROAD_LAW = RoadLaw(BEST_FIXED, CONSTANTS, COOPERATION, ACTUATION, oldest=0.05)
EXTENDED_LAW = ExtendedLaw(BEST_FIXED, CONSTANTS, COOPERATION, DrivenLeader(29.0, -0.5), 0.02)
SEEN = Seen(*PAIR, 0.02, np.array([0.0, 1.0, 1.0]), np.array([-0.5, 0.0, 0.0]))


def itself(made: Any) -> Any:
    """What an object does that does nothing."""
    return made


def rode(made: Any) -> list[Any]:
    """What a plant does with two commands, the second to a standstill."""
    first, mean = made.advance(made.begin(3.0, *PAIR), np.array([1.0, 0.0, -2.0]), 0.1)
    return [first, mean, made.advance(first, np.full(3, -8.0), 5.0)]


def delayed() -> Any:
    """Vehicles with commands on their way."""
    made = DelayedVehicles(ACTUATION)
    return made.advance(made.begin(3.0, *PAIR), np.array([1.0, 0.0, -2.0]), 0.01)[0]


def road_plant(actuation: Actuation) -> RoadPlant:
    """Vehicles of several lengths on their way, the first of which drives itself."""
    made = RoadPlant.begin(PlatoonState(*PAIR, x_leader=3.0), 0.01, actuation, [5.0, 12.0, 4.5])
    return made.advanced_to(3, np.array([1.0, 0.5, -2.0]), [0.0, 1.0, 1.0])


def driven_on(made: RoadPlant) -> list[Any]:
    """What a plant does with further commands, and what is seen of it."""
    made = made.advanced_to(made.period + 2, np.array([-1.0, 2.0, 0.0])).advanced_to(
        made.period + 400, np.full(3, -9.0)
    )
    return [made.now, made.period, made.positions(), made.clearances(), made.accelerations()]


def remembered() -> Remembered:
    """The memory of a law for the road after two sampling instants."""
    return ROAD_LAW.sample(ROAD_LAW.sample(None, SEEN)[0], SEEN)[0]


def road_run(sensing: Sensing, periods: int) -> RoadRun:
    s, v = (part[:, None] for part in PAIR)
    run = started(DelayedVehicles(ACTUATION), s, v)
    return run_on_road(run, ROAD_LAW, ACTUATION, None, {0: np.linspace(30.0, 29.0, periods + 1)}, periods, sensing)


ROAD_EXAMPLES: dict[str, Example] = {
    "Cooperation": (lambda: COOPERATION, lambda made: cooperative_command(*PAIR, BEST_FIXED, CONSTANTS, made, TRAFFIC)),
    "Traffic": (
        lambda: TRAFFIC,
        lambda made: cooperative_command(*PAIR, BEST_FIXED, CONSTANTS, COOPERATION, made),
    ),
    "Watched": (lambda: remembered().watched, lambda made: watch(made, PAIR[1] + 0.1, 0.0 * PAIR[1], 0.01)),
    "Actuation": (lambda: ACTUATION, lambda made: rode(DelayedVehicles(made))),
    "Errors": (lambda: Errors(0.3, np.array([0.1, 0.0, 0.2])), lambda made: made.carried(0.2)),
    "Actuators": (lambda: delayed().actuators, lambda made: drive(PAIR[1], made, ACTUATION, 0.1)),
    "Foreign": (
        lambda: Foreign(np.array([0.0, 1.0, 1.0]), np.array([-2.0, 0.0, 0.0])),
        lambda made: drive(PAIR[1], delayed().actuators, ACTUATION, 0.1, made),
    ),
    "Braking": (
        lambda: Braking(PAIR[1], np.array([-1.0, 0.5, 0.0]), 0.2, 0.3, -6.0),
        lambda made: brake_margin(np.array([20.0, 30.0]), made),
    ),
    "Issued": (lambda: remembered().issued, lambda made: predict(made, *PAIR, 0.02, ACTUATION)),
    "Predicted": (lambda: remembered().predicted, itself),
    "Seen": (lambda: SEEN, lambda made: ROAD_LAW.sample(None, made)),
    "Remembered": (lambda: remembered(), lambda made: ROAD_LAW.sample(made, SEEN)),
    "DrivenLeader": (lambda: EXTENDED_LAW.leader, itself),
    "ExtendedLaw": (lambda: EXTENDED_LAW, lambda made: made.decide(made.decide(None, *PAIR)[0], *PAIR)),
    "Engaged": (lambda: EXTENDED_LAW.decide(None, *PAIR)[0], lambda made: EXTENDED_LAW.decide(made, *PAIR)),
    "RoadLaw": (lambda: ROAD_LAW, lambda made: made.sample(remembered(), SEEN)),
    "RoadPlant": (lambda: road_plant(Actuation(0.033, np.array([0.0, 0.1, 0.3]), -8.0, 4.0)), driven_on),
    "RoadPlant, ideal": (lambda: road_plant(Actuation()), driven_on),
    "BehindLeader": (behind_leader, lambda made: (made.figures(), made.contact)),
    "Sensing": (lambda: Sensing(1, 0.1, 0.05, seed=3), lambda made: road_run(made, 3)),
    "RoadRun": (lambda: road_run(Sensing(), 2), lambda made: (made.touched, made.gain(2, 0), made)),
}
