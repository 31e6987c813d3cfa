"""The pythonfmu slave `PspController`: a thin shim between FMI and `psp_model.SampledController`."""

from __future__ import annotations

import json
from copy import copy
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from psp_model.clock import Clock
from psp_model.controller import BadMeasurement, Command, ControllerSettings, Measurement, SampledController
from psp_model.errors import ModelError
from psp_model.network import read_networks
from psp_model.parameters import PotentialParameters

from .controller_variables import controller_table
from .table_slave import LONGEST, TableSlave, logged
from .variables import Variable

_SAVED = ("_values", "_clock", "_initialising", "_sampled", "_set_at", "_fresh")


class PspController(TableSlave):
    """The feedback law for vehicles outside the FMU.

    Sampling instants lie at start + phase + k T.  At a communication point that is one, the command is computed from
    the inputs set there: when the outputs are read after inputs were set, at the latest when the next step begins.
    Instants inside a communication step use the inputs from its beginning.
    """

    _part: SampledController | None

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._networks = read_networks(Path(self.resources), self._config["networks"])
        self._ahead: Command | None = None  # the decision at the instant that the current point is, if one is known
        self._sampled = 0  # instants that lie in the past
        self._set_at = 0.0  # [sampling periods] since the first sampling instant, when gaps or speeds were last set
        self._fresh = True  # inputs were set at this communication point

    def _make_table(self) -> tuple[Variable, ...]:
        return controller_table(self.vehicles, self._config["default_source"])

    def _changed(self, inputs: bool) -> None:
        super()._changed(inputs)
        self._ahead, self._stale, self._fresh = None, True, True
        self._set_at = self._here()

    # initialisation

    def _initialise(self) -> SampledController:
        read, sampling = self._value, self._sampling()
        phase = read("phase")
        if not 0 <= phase < sampling.T:
            raise ModelError("phase", phase, sampling.T)
        settings = ControllerSettings(
            capacity=self.vehicles,
            constants=self._constants(),
            weights=self._weights(),
            sampling=sampling,
            request=self._request(),
            a_min=read("a_min"),
            a_max=read("a_max"),
            bad_input=BadMeasurement(self._chosen("bad_input")),
            a_safe=read("a_safe"),
            max_age=read("max_age"),
        )
        self._clock = Clock.begin(self._clock.time, phase, sampling.T)
        self._set_at = self._here()  # what was set before belongs to the start
        return SampledController(settings, self._networks, self._warn)

    # time

    def _here(self) -> float:
        """The communication point [sampling periods] since the first sampling instant."""
        period, fraction = self._clock.at()
        return period + fraction

    def _sample(self, controller: SampledController) -> None:
        """Decide at the next sampling instant from the inputs as they are now."""
        n, taken, desired, T = self.vehicles, self._value("t_measured"), self._value("v_desired"), self._value("T")
        time = self._clock.time_of(self._sampled, T)
        age = (self._sampled - self._set_at) * T if taken < 0 else time - taken
        measured = Measurement(
            s=np.array(self._numbers("s", 2, n)),
            v=np.array(self._numbers("v", 1, n)),
            n_active=self._value("n_active"),
            resolve=self._value("resolve"),
            age=age,
            age_rounding=self._clock.age_rounding(age, T),
            v_desired=None if desired <= -1 else desired,
        )
        controller.sample(time, measured)

    @logged
    def do_step(self, current_time: float, step_size: float) -> bool:
        controller = self._part
        assert controller is not None  # the launcher lets nobody step before initialisation has ended
        if step_size <= 0.0:
            return True
        clock = self._clock.after(current_time, step_size, self._value("T"))
        period, fraction = clock.at()
        self._stale = True
        while self._sampled < period + (fraction > 0.0):  # at the end of the step newer inputs may come
            if self._ahead is not None:
                controller.now, self._ahead = self._ahead, None
            else:
                self._sample(controller)
            self._sampled += 1
        self._clock, self._fresh = clock, False
        return True

    def _decided(self, controller: SampledController) -> Command:
        """The command to show: that of this instant, if it is one and inputs were set here, else the one held."""
        if not self._fresh or self._sampled > self._clock.at()[0]:
            return controller.now
        if self._ahead is None:
            trial = copy(controller)
            self._sample(trial)
            self._ahead = trial.now
        return self._ahead

    def _outputs(self, controller: SampledController) -> list[float]:
        now = self._decided(controller)
        shape = now.shape
        certified = now.T_max > self._value("T")
        reports = (shape.alpha, shape.r, shape.p, now.in_domain, min(now.T_max, LONGEST), certified, now.violations)
        counts = (now.in_order, now.faults, now.choices)
        return [*map(float, (*now.a, *now.saturated, *reports, *counts))]

    # the whole state

    @logged
    def _get_fmu_state(self) -> dict[str, Any]:
        state = {name: getattr(self, name) for name in _SAVED} | {"_values": tuple(self._values)}
        return state | {"now": self._part and self._part.now, "ahead": self._ahead}

    @logged
    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        for name in _SAVED:
            setattr(self, name, state[name])
        self._values, self._ahead, self._stale = list(state["_values"]), state["ahead"], True
        self._clock, self._part = Clock(*state["_clock"]), None
        if state["now"] is not None:
            clock, self._part = self._clock, self._initialise()
            self._clock, self._set_at, self._part.now = clock, state["_set_at"], state["now"]

    @staticmethod
    def _fmu_state_to_bytes(state: dict[str, Any]) -> bytes:
        commands = {name: state[name] and _pack(state[name]) for name in ("now", "ahead")}
        return json.dumps(state | commands).encode()

    @staticmethod
    def _fmu_state_from_bytes(data: bytes) -> dict[str, Any]:
        state: dict[str, Any] = json.loads(data)
        return state | {name: state[name] and _unpack(state[name]) for name in ("now", "ahead")}


def _pack(command: Command) -> dict[str, Any]:
    fields = {name: getattr(command, name) for name in Command.__dataclass_fields__}
    arrays = {"a": command.a.tolist(), "saturated": command.saturated.tolist()}
    return fields | arrays | {"shape": asdict(command.shape)}


def _unpack(packed: dict[str, Any]) -> Command:
    arrays = {"a": np.array(packed["a"]), "saturated": np.array(packed["saturated"], dtype=bool)}
    return Command(**(packed | arrays | {"shape": PotentialParameters(**packed["shape"])}))
