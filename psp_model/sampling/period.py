"""One sampling period of the closed loop: what runs, rollouts, the search's engine and IPOPT all repeat."""

from __future__ import annotations

from ..law.controller import Controller, Memory
from ..law.cooperation import contact_spacing
from ..law.extended import behind_leader
from ..namespaces import Array
from ..objective import running_cost
from ..parameters import ObjectiveWeights
from .exact import exact_period
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
    return remembered, a, lemma1_period(controller, vehicles, a)


def lemma1_period(controller: Controller[Memory], vehicles: Moving, a: Array) -> Array:
    """T_max for the commands of a controller, with lengths of vehicles and a leader that drives itself (ours).

    Parameters
    ----------
    controller : may have a `cooperation` with lengths, and a `leader` that is not None where it drives itself
    vehicles : state of the plant
    a : (n, ...) accelerations commanded [m/s2]

    Returns
    -------
    (...) array [s]
    """
    return largest_period(room(controller, vehicles.s), vehicles.v, a, controller.constants, automated(controller, a))


def exact_period_of(controller: Controller[Memory], vehicles: Moving, a: Array, memory: object) -> Array:
    """T_exact for the commands of a controller, likewise (ours).

    Parameters
    ----------
    controller, vehicles, a : as for `lemma1_period`
    memory : of the controller that decided them

    Returns
    -------
    (...) array [s]
    """
    v = vehicles.v
    leads_itself = getattr(memory, "leader", None) is not None
    foreign = behind_leader(v) if leads_itself else None
    return exact_period(room(controller, vehicles.s), v, a, controller.constants, foreign)


def room(controller: Controller[Memory], s: Array) -> Array:
    """Spacings with the lengths of the vehicles ahead taken for L (ours).

    Parameters
    ----------
    controller : as for `lemma1_period`
    s : (n-1, ...) array [m]

    Returns
    -------
    (n-1, ...) array [m]; L where vehicles touch
    """
    cooperation = getattr(controller, "cooperation", None)
    return s if cooperation is None else contact_spacing(s, cooperation, controller.constants)


def automated(controller: Controller[Memory], v: Array) -> Array | None:
    """Which vehicles are automated, None where all are (ours).

    Parameters
    ----------
    controller : as for `lemma1_period`
    v : (n, ...) array like the vehicles

    Returns
    -------
    (n, ...) array, 0 for a first vehicle that drives itself
    """
    return None if getattr(controller, "leader", None) is None else behind_leader(v)


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
