"""The protocol of controllers, and the paper's law, which has no memory."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, TypeVar

from ..namespaces import Array
from ..parameters import PlatoonParameters
from .feedback import feedback
from .potential import Potential

Memory = TypeVar("Memory")


class Controller(Protocol[Memory]):
    """Decides the accelerations, once in every sampling period (ours).

    A frozen dataclass whose fields are, among others, `potential` and `constants`, so that another potential can take
    the place of the one in use.  `decide` is pure; what the controller remembers is a struct of its own, None for
    nothing.
    """

    @property
    def potential(self) -> Potential:
        """The potential in use."""

    @property
    def constants(self) -> PlatoonParameters:
        """The constants of the model."""

    def decide(self, memory: Memory | None, s: Array, v: Array) -> tuple[Memory, Array]:
        """The commands for vehicles at these spacings and speeds.

        Parameters
        ----------
        memory : what the last call returned, None before the first
        s, v : (n-1, ...) spacings [m], above L, and (n, ...) speeds [m/s]

        Returns
        -------
        what to remember, and the (n, ...) accelerations [m/s2]
        """


class TimedController(Controller[Memory], Protocol):
    """A controller that is told when it decides (ours)."""

    def decide_after(
        self, memory: Memory | None, s: Array, v: Array, since: float, nominal: bool
    ) -> tuple[Memory, Array]:
        """The commands for vehicles at these spacings and speeds; with the same memory and `since` 0 the same again.

        Parameters
        ----------
        memory, s, v : as for `decide`
        since : time since the call that returned the memory [s]
        nominal : whether this is one of the clock's instants, or one between them

        Returns
        -------
        as `decide`
        """


@dataclass(frozen=True)
class PaperLaw:
    """F_i = -k_i (v_i - v*) + u_i (paper, eq. 2); see `feedback`.

    Attributes
    ----------
    potential, constants : of the model
    """

    potential: Potential
    constants: PlatoonParameters

    def decide(self, memory: None, s: Array, v: Array) -> tuple[None, Array]:
        """See `Controller.decide`."""
        return None, feedback(s, v, self.potential, self.constants)


MakeController = Callable[[Potential, PlatoonParameters], Controller[Memory]]
"""Makes a controller from the potential and the constants, as `PaperLaw` does."""
