"""The pythonfmu slave `PspPlatoon`: a thin shim between FMI and `psp_model.SampledPlatoon`.

Nothing here raises: whatever goes wrong is logged as one sentence with its status, and the launcher, the C library
around this slave, returns that status from the FMI call.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from copy import copy
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from pythonfmu.enums import Fmi2Status
from pythonfmu.fmi2slave import Fmi2Slave

from psp_model.choose import ParameterSource, Request, choose_potential, outside_domain
from psp_model.errors import ModelError
from psp_model.network import ParameterNetwork
from psp_model.parameters import ObjectiveWeights, PlatoonParameters, PotentialParameters
from psp_model.platoon import Lemma1Policy, SampledPlatoon, Sampling, locate
from psp_model.state import PlatoonState, StartDomain

from .slave_state import SlaveState, from_bytes, to_bytes
from .variables import platoon_table

CONFIG = "platoon.json"  # what build_fmu.py decided: how many vehicles, which network

Result = TypeVar("Result")


def _logged(call: Callable[..., Result]) -> Callable[..., Result | bool | list[float]]:
    """Turn what a call of the slave raises into one logged sentence."""

    @wraps(call)
    def guarded(self: PspPlatoon, *args: Any) -> Any:
        try:
            return call(self, *args)
        except ModelError as error:
            self.log(str(error), Fmi2Status.error)
        except Exception as error:  # a defect of ours must not crash the host
            self.log(str(ModelError("internal", call.__name__, repr(error))), Fmi2Status.error)
        return [0.0] * len(args[0]) if call.__name__.startswith("get_") else False

    return guarded


class PspPlatoon(Fmi2Slave):  # type: ignore[misc]  # pythonfmu has no types
    """The closed loop of n vehicles as an FMI 2.0 co-simulation slave (design, section 3)."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        resources = Path(self.resources)
        config = json.loads((resources / CONFIG).read_text(encoding="utf-8"))
        self.vehicles: int = config["vehicles"]
        self._trained: dict[str, Any] | None = config["network"]
        self._network_file = resources / config["network"]["file"] if self._trained else None
        self._table = platoon_table(self.vehicles, config["default_source"])
        self._place = {variable.name: place for place, variable in enumerate(self._table)}
        self._values: list[float] = [0.0 if row.start is None else row.start for row in self._table]
        self._first_output = next(place for place, row in enumerate(self._table) if row.start is None)
        self._start_time = 0.0
        self._time = 0.0  # [s] last communication point
        self._platoon: SampledPlatoon | None = None
        self._in_domain = 0.0
        self._initialising = False
        self._stale = True  # the outputs in _values lag behind the platoon

    # parameters in, outputs out

    def _get(self, references: list[int], integer: bool) -> list[float]:
        if self._stale:
            self._refresh()
        values, table = self._values, self._table
        for reference in references:
            if not (0 <= reference < len(table) and table[reference].integer is integer):
                raise ModelError("reference", reference, "Integer" if integer else "Real")
        return [values[reference] for reference in references]

    def _set(self, references: list[int], values: list[float], integer: bool) -> None:
        for reference in references:
            if not (0 <= reference < len(self._table) and self._table[reference].integer is integer):
                raise ModelError("reference", reference, "Integer" if integer else "Real")
            name = self._table[reference].name
            if reference >= self._first_output:
                raise ModelError("output", name)
            if self._platoon is not None and not self._initialising:
                raise ModelError("fixed", name)
        for reference, value in zip(references, values, strict=True):
            self._values[reference] = value
        self._platoon, self._stale = None, True

    @_logged
    def get_real(self, vrs: list[int]) -> list[float]:
        return self._get(vrs, integer=False)

    @_logged
    def get_integer(self, vrs: list[int]) -> list[float]:
        return [int(value) for value in self._get(vrs, integer=True)]

    @_logged
    def set_real(self, vrs: list[int], values: list[float]) -> None:
        self._set(vrs, values, integer=False)

    @_logged
    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        self._set(vrs, [float(value) for value in values], integer=True)

    # initialisation

    @_logged
    def setup_experiment(self, start_time: float, stop_time: float | None, tolerance: float | None) -> None:
        self._start_time = self._time = start_time

    @_logged
    def enter_initialization_mode(self) -> None:
        self._initialising = True

    @_logged
    def exit_initialization_mode(self) -> None:
        if self._platoon is None:
            self._platoon = self._initialise()
        self._initialising = False
        self._stale = True

    def _value(self, name: str) -> float:
        return self._values[self._place[name]]

    def _chosen(self, name: str) -> int:
        """An Integer parameter, checked against the bounds in its row."""
        row, value = self._table[self._place[name]], int(self._value(name))
        low, high = int(row.minimum or 0), row.maximum
        if high is None and value < low:
            raise ModelError("count", name, value)
        if high is not None and not low <= value <= high:
            raise ModelError("choice", name, value, low, int(high))
        return value

    def _initialise(self) -> SampledPlatoon:
        """The platoon that the parameters describe, at its first sampling instant."""
        names = {"lam": "lambda"}
        read = self._value
        constants = PlatoonParameters(
            **{key: read(names.get(key, key)) for key in PlatoonParameters.__dataclass_fields__}
        )
        weights = ObjectiveWeights(**{key: read(key) for key in ObjectiveWeights.__dataclass_fields__})
        sampling = Sampling(read("T"), Lemma1Policy(self._chosen("lemma1_policy")), self._chosen("max_short_periods"))
        gaps = [read(f"s_start[{i}]") for i in range(2, self.vehicles + 1)]
        speeds = [read(f"v_start[{i}]") for i in range(1, self.vehicles + 1)]
        start = PlatoonState(np.array(gaps), np.array(speeds), constants, read("x_start"))
        request = Request(
            old=self._chosen("potential") == 1,
            source=ParameterSource(self._chosen("parameter_source")),
            fixed=PotentialParameters(read("alpha_fixed"), read("r_fixed"), read("p_fixed")),
            rollouts=self._chosen("rollout_count"),
            horizon=read("rollout_horizon"),
        )
        network = ParameterNetwork(self._network_file) if self._network_file else None
        self._in_domain = self._lies_in_domain(start)
        shape = choose_potential(start, request, network, weights, sampling, self._warn)
        return SampledPlatoon(start, shape, weights, sampling, self._warn)

    def _warn(self, sentence: str) -> None:
        self.log(sentence, Fmi2Status.warning)

    # time

    @_logged
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
        now, shape = platoon.now, platoon.shape
        of_acceleration, of_gaps = seen.cost.tolist()
        reports = (shape.alpha, shape.r, shape.p, self._in_domain, now.T_max)
        lemma1 = (float(now.T_max > platoon.sampling.T), float(now.violations))
        objective = (of_acceleration + of_gaps, of_acceleration, of_gaps)
        motion = [value for part in (seen.x, seen.v, seen.a, seen.s) for value in part.tolist()]
        self._values[self._first_output :] = [*motion, *reports, *lemma1, *objective]
        self._stale = False

    def _lies_in_domain(self, start: PlatoonState) -> float:
        """1.0 if the start lies in the training domain of this FMU's network, else 0.0."""
        if self._trained is None:
            return 0.0
        domain, constants = StartDomain(**self._trained["domain"]), PlatoonParameters(**self._trained["constants"])
        return float(outside_domain(start, domain, constants) is None)

    # the whole state

    @_logged
    def _get_fmu_state(self) -> SlaveState:
        return SlaveState(
            values=tuple(self._values[: self._first_output]),
            start_time=self._start_time,
            time=self._time,
            in_domain=self._in_domain,
            initialising=self._initialising,
            platoon=copy(self._platoon),
        )

    @_logged
    def _set_fmu_state(self, state: SlaveState) -> None:
        self._values[: self._first_output] = state.values
        self._start_time, self._time, self._in_domain = state.start_time, state.time, state.in_domain
        self._initialising, self._stale = state.initialising, True
        self._platoon = copy(state.platoon)
        if self._platoon is not None:
            self._platoon.warn = self._warn

    _fmu_state_to_bytes = staticmethod(to_bytes)
    _fmu_state_from_bytes = staticmethod(from_bytes)
