"""The extended law for ideal vehicles as a controller: closing up over time, a leader that drives itself (ours)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from ..namespaces import Array, Number, array_namespace
from ..parameters import PlatoonParameters
from .cooperation import Cooperation, Traffic, closing_speeds, cooperative_command, is_off, model_spacing
from .potential import Potential
from .watching import engaged


class DrivenLeader(NamedTuple):
    """What is known of a first vehicle that drives itself.

    Attributes
    ----------
    speed : its speed now [m/s]
    acceleration : what it holds over the next period [m/s2]
    """

    speed: Number
    acceleration: Number


class Engaged(NamedTuple):
    """What the extended law remembers.

    Attributes
    ----------
    closing : (n, ...) what closing up adds to the desired speeds [m/s], None where none closes up
    leader : acceleration of a first vehicle that drives itself [m/s2], None where it is automated
    """

    closing: Array | None
    leader: Number | None


@dataclass(frozen=True)
class ExtendedLaw:
    """The extended law; see `law.controller.TimedController`.  With the defaults it is the paper's, bit for bit (ours).

    Attributes
    ----------
    potential, constants : of the model
    cooperation : parameters of the extended law
    leader : the first vehicle if it drives itself, None where it is automated
    T : sampling period [s]
    """

    potential: Potential
    constants: PlatoonParameters
    cooperation: Cooperation = field(default_factory=Cooperation)
    leader: DrivenLeader | None = None
    T: float = 0.01

    def decide(self, memory: Engaged | None, s: Array, v: Array) -> tuple[Engaged | None, Array]:
        """See `Controller.decide`."""
        return self.decide_after(memory, s, v, self.T, True)

    def decide_after(
        self, memory: Engaged | None, s: Array, v: Array, since: float, nominal: bool
    ) -> tuple[Engaged | None, Array]:
        """See `TimedController.decide_after`."""
        closing = self._closing(None if memory is None else memory.closing, s, v, since)
        automated = a = None
        if self.leader is not None:
            automated, a = behind_leader(v), 0.0 * v + self.leader.acceleration
        traffic = Traffic(automated, a, closing=closing)
        a = cooperative_command(s, v, self.potential, self.constants, self.cooperation, traffic)
        if self.leader is None:
            return None if closing is None else Engaged(closing, None), a
        held = None if nominal or memory is None else memory.leader
        if held is None:
            held = driven(v[0], self.leader, self.T, self.constants)
        xp = array_namespace(a)
        return Engaged(closing, held), xp.concat([0.0 * a[:1] + held, a[1:]])

    def _closing(self, before: Array | None, s: Array, v: Array, since: float) -> Array | None:
        """What closing up adds to the desired speeds now."""
        if is_off(self.cooperation.closing_speed):
            return None
        if before is None:
            return 0.0 * v
        spacing = model_spacing(s, v, self.cooperation, self.constants)
        return engaged(before, closing_speeds(spacing, self.cooperation), since)


def behind_leader(v: Array) -> Array:
    """Which vehicles are automated behind a first one that drives itself (ours).

    Parameters
    ----------
    v : (n, ...) array, speeds [m/s]

    Returns
    -------
    (n, ...) array, 0 for the first vehicle, 1 for the others
    """
    return array_namespace(v).concat([0.0 * v[:1], 0.0 * v[1:] + 1.0])


def driven(v: Number, leader: DrivenLeader, T: Number, constants: PlatoonParameters) -> Array:
    """What takes a first vehicle from its speed in the model to where its own speed will be a period later (ours).

    So it follows a profile without drift; kept within what [0, v_max] allows for one period.

    Parameters
    ----------
    v : its speed in the model [m/s]
    leader : its own speed and acceleration
    T : sampling period [s]

    Returns
    -------
    acceleration [m/s2]
    """
    xp = array_namespace(v)
    wanted = leader.acceleration + (leader.speed - v) / T
    return xp.minimum(xp.maximum(wanted, -v / T), (constants.v_max - v) / T)
