"""One sampling period of the closed loop: what runs, rollouts, the search's engine and IPOPT all repeat."""

from __future__ import annotations

from ..law.controller import Controller, Memory
from ..namespaces import Array
from ..objective import running_cost
from ..parameters import ObjectiveWeights
from .hold import Moving, Plant, Vehicles
from .lemma1 import largest_period


def decide(controller: Controller[Memory], memory: Memory | None, vehicles: Moving) -> tuple[Memory, Array, Array]:
    """The commands at a sampling instant, and the period that Lemma 1 certifies for them (ours).

    Parameters
    ----------
    controller : in use
    memory : what it remembers, None at first
    vehicles : state of the plant

    Returns
    -------
    what the controller remembers, the (n, ...) accelerations commanded from here on [m/s2], and T_max, (...) [s]
    """
    remembered, a = controller.decide(memory, vehicles.s, vehicles.v)
    return remembered, a, largest_period(vehicles.s, vehicles.v, a, controller.constants)


def hold(
    plant: Plant[Vehicles], vehicles: Vehicles, a: Array, tau: float, weights: ObjectiveWeights
) -> tuple[Vehicles, tuple[Array, Array]]:
    """The plant a time tau after a sampling instant, and what that adds to the two terms of J (ours).

    Parameters
    ----------
    plant : what is driven
    vehicles : its state at the sampling instant
    a : (n, ...) accelerations held since [m/s2]
    tau : time since the sampling instant [s]
    weights : of the objective

    Returns
    -------
    the state, and the (...) terms of acceleration and of spacings [s]; exact where vehicles follow commands at once,
    else as if each held its mean acceleration
    """
    after, held = plant.advance(vehicles, a, tau)
    return after, running_cost(vehicles.s, vehicles.v, held, tau, weights)
