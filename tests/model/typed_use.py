"""The public face for `mypy --strict`, without ignores and casts; tests/model/test_face.py runs it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from psp_model import (
    BEST_FIXED,
    V_OLD,
    Actuation,
    Braking,
    ControllerSettings,
    Cooperation,
    DelayedVehicles,
    Errors,
    IdealPlant,
    Lemma1Policy,
    Measurement,
    ModelError,
    PaperLaw,
    ParameterNetwork,
    PlatoonParameters,
    PlatoonState,
    Potential,
    RoadLaw,
    Run,
    Runs,
    SampledController,
    Sampling,
    Traffic,
    Wave,
    brake_margin,
    cooperative_command,
    exact_period,
    feedback,
    largest_period,
    max_slope,
    potential,
    potential_slope,
    project,
    project_networks,
    rollout_costs,
    simulate,
    simulate_many,
    uncertain_period,
    validate,
)

Numbers = NDArray[np.float64]


@dataclass(frozen=True)
class Inverse:
    """A potential of one's own: k / (s - L)."""

    k: float

    def value(self, s: Numbers, constants: PlatoonParameters) -> Numbers:
        return self.k / (s - constants.L)

    def slope(self, s: Numbers, constants: PlatoonParameters) -> Numbers:
        return -self.k / (s - constants.L) ** 2


@dataclass(frozen=True)
class Standing:
    """State of a plant of one's own."""

    x: float | Numbers
    s: Numbers
    v: Numbers


class Parked:
    """A plant of one's own: vehicles that keep their speeds."""

    def begin(self, x: float | Numbers, s: Numbers, v: Numbers) -> Standing:
        return Standing(x, s, v)

    def advance(self, vehicles: Standing, a: Numbers, tau: float | Numbers) -> tuple[Standing, Numbers]:
        moved = tau * vehicles.v
        return Standing(vehicles.x + moved[0], vehicles.s + moved[:-1] - moved[1:], vehicles.v), 0.0 * a


def functions() -> list[Numbers]:
    """Each function of the equations with lists and tuples."""
    s, v = [9.0, 10.5], (30.0, 31.0, 29.0)
    a = feedback(s, v, BEST_FIXED)
    found = [a, potential(s, BEST_FIXED), potential_slope(s, V_OLD), largest_period(s, v, [0.1, -0.2, 0.0])]
    found += [exact_period(s, v, a), uncertain_period(s, v, a, Errors(0.1, 0.2))]
    found.append(cooperative_command(s, v, BEST_FIXED, cooperation=Cooperation(kappa=1.0), traffic=Traffic()))
    vehicles = Braking(np.array(v), np.zeros(3), 0.2, 0.1, -6.0)
    found.append(brake_margin([4.0, 5.5], vehicles, automated=[1, 1, 1]))
    return found


def runs() -> tuple[Run, Runs]:
    """Runs and batches, and what they say."""
    run = simulate(([9, 10.5], [30, 31, 29]), "network", duration=0.1)
    in_use: Potential | None = run.potential
    warnings: tuple[str, ...] = run.warnings
    assert in_use is not None and not warnings
    start = PlatoonState([9.0, 10.5], [30.0, 31.0, 29.0])
    simulate(start, Inverse(20.0), plant=Parked(), controller=PaperLaw, duration=0.1)
    vehicles = Actuation(actuation_delay=0.02, actuator_lag=0.1)
    simulate(
        start,
        BEST_FIXED,
        sampling=Sampling(policy=Lemma1Policy.WARN),
        plant=DelayedVehicles(vehicles),
        controller=lambda shape, constants: RoadLaw(shape, constants, Cooperation(kappa=1.0), vehicles),
        duration=0.1,
    )
    J, certified = rollout_costs(start, [Inverse(10.0), Inverse(20.0)], horizon=0.1)
    best: float = J[certified].min()
    assert best > 0
    many = simulate_many([([9.0, 10.5], [30.0, 31.0, 29.0]), start], "fixed", duration=0.1)
    peaks: Numbers = many.a_peak
    assert peaks.shape == (2,)
    return run, many


def control() -> Numbers:
    """Measured vehicles behind a leader of one's own."""
    controller = SampledController.begin(ControllerSettings(3), project_networks(3))
    plant, leader = IdealPlant.begin(PlatoonState([9.0, 10.5], [30.0, 31.0, 29.0]), T=0.01), Wave(30.0, 25.0)
    for k in range(5):
        controller.sample(0.01 * k, Measurement([9.0, 10.5], [30, 31, 29], 3, v_desired=leader.speed(0.01 * k)))
        plant = plant.advanced_to(k + 1, controller.now.a)
    network: ParameterNetwork = project_networks(3)[3]
    slope: float = max_slope(
        project(network.evaluate([9.0, 10.5], [30.0, 31.0, 29.0]), PlatoonParameters()), PlatoonParameters()
    )
    assert slope <= 4.0
    return controller.now.a


def refused() -> str | None:
    """What an error says."""
    try:
        validate(PlatoonParameters(L=-1.0))
    except ModelError as error:
        return error.key
    return None


if __name__ == "__main__":
    print(functions(), *runs(), control(), refused())
