"""The pythonfmu slave `PspPlatoon`: a thin shim between FMI and `psp_model.SampledPlatoon`.

Nothing here raises: whatever goes wrong is logged as one sentence with its status, and the launcher, the C library
around this slave, returns that status from the FMI call.
"""

from __future__ import annotations

from copy import copy
from pathlib import Path
from typing import Any

import numpy as np

from psp_model.choose import choose_potential, outside_domain
from psp_model.errors import ModelError
from psp_model.network import ParameterNetwork
from psp_model.parameters import PlatoonParameters
from psp_model.platoon import SampledPlatoon, locate
from psp_model.state import PlatoonState, StartDomain

from .slave_state import SlaveState, from_bytes, to_bytes
from .table_slave import LONGEST, TableSlave, logged
from .variables import Variable, platoon_table


class PspPlatoon(TableSlave):
    """The closed loop of n vehicles as an FMI 2.0 co-simulation slave (design, section 3)."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._trained: dict[str, Any] | None = self._config["network"]
        self._network_file = Path(self.resources) / self._trained["file"] if self._trained else None
        self._platoon: SampledPlatoon | None = None
        self._in_domain = 0.0

    def _make_table(self) -> tuple[Variable, ...]:
        return platoon_table(self.vehicles, self._config["default_source"])

    def _running(self) -> bool:
        return self._platoon is not None

    def _changed(self, inputs: bool) -> None:
        if not inputs:
            self._platoon = None
        self._stale = True

    # initialisation

    @logged
    def exit_initialization_mode(self) -> None:
        if self._platoon is None:
            self._platoon = self._initialise()
        self._initialising = False
        self._stale = True

    def _initialise(self) -> SampledPlatoon:
        """The platoon that the parameters describe, at its first sampling instant."""
        n, constants, weights, sampling = self.vehicles, self._constants(), self._weights(), self._sampling()
        gaps, speeds = np.array(self._numbers("s_start", 2, n)), np.array(self._numbers("v_start", 1, n))
        start = PlatoonState(gaps, speeds, constants, self._value("x_start"))
        request = self._request()
        network = ParameterNetwork(self._network_file) if self._network_file else None
        self._in_domain = self._lies_in_domain(start)
        shape = choose_potential(start, request, network, weights, sampling, self._warn)
        return SampledPlatoon(start, shape, weights, sampling, self._warn)

    # time

    @logged
    def do_step(self, current_time: float, step_size: float) -> bool:
        platoon = self._platoon
        assert platoon is not None  # the launcher lets nobody step before initialisation has ended
        time = current_time + step_size
        self._stale = True
        self._time = time
        try:
            platoon.advance_to(*locate(time - self._start_time, platoon.sampling.T))
        except ModelError:  # the outputs then show the instant that was refused
            self._time = self._start_time + (platoon.now.period + platoon.now.fraction) * platoon.sampling.T
            raise
        return True

    def _refresh(self) -> None:
        """Bring the outputs in `_values` up to date."""
        if self._platoon is None:
            if not self._initialising:
                return
            self._platoon = self._initialise()
        platoon = self._platoon
        seen = platoon.observe(*locate(self._time - self._start_time, platoon.sampling.T))
        motion = [value for part in (seen.x, seen.v, seen.a, seen.s) for value in part.tolist()]
        self._values[self._first_output :] = [*motion, *self._reported(platoon, seen.cost.tolist())]
        self._stale = False

    def _reported(self, platoon: SampledPlatoon, cost: list[float]) -> list[float]:
        """The outputs behind the motion, in the order of the table."""
        now, shape = platoon.now, platoon.shape
        of_acceleration, of_gaps = cost
        reports = (shape.alpha, shape.r, shape.p, self._in_domain, min(now.T_max, LONGEST))
        lemma1 = (float(now.T_max > platoon.sampling.T), float(now.violations))
        return [*reports, *lemma1, of_acceleration + of_gaps, of_acceleration, of_gaps]

    def _lies_in_domain(self, start: PlatoonState) -> float:
        """1.0 if the start lies in the training domain of this FMU's network, else 0.0."""
        if self._trained is None:
            return 0.0
        domain, constants = StartDomain(**self._trained["domain"]), PlatoonParameters(**self._trained["constants"])
        return float(outside_domain(start, domain, constants) is None)

    # the whole state

    @logged
    def _get_fmu_state(self) -> Any:
        return SlaveState(
            values=tuple(self._values[: self._first_output]),
            start_time=self._start_time,
            time=self._time,
            in_domain=self._in_domain,
            initialising=self._initialising,
            platoon=copy(self._platoon),
        )

    @logged
    def _set_fmu_state(self, state: Any) -> None:
        self._values[: self._first_output] = state.values
        self._start_time, self._time, self._in_domain = state.start_time, state.time, state.in_domain
        self._initialising, self._stale = state.initialising, True
        self._platoon = copy(state.platoon)
        if self._platoon is not None:
            self._platoon.warn = self._warn

    _fmu_state_to_bytes: Any = staticmethod(to_bytes)
    _fmu_state_from_bytes: Any = staticmethod(from_bytes)
