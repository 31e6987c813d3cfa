"""The pythonfmu slave `PspController`: a thin shim between FMI and `psp_model.SampledController`."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from psp_model.controller import BadMeasurement, Command, ControllerSettings, Measurement, SampledController
from psp_model.errors import ModelError
from psp_model.sampling.clock import Clock

from ..interface.controller import controller_table
from ..interface.meaning import constants_of, weights_of
from ..interface.variables import Variable
from .network_files import networks_of
from .slave_state import IN_MEMORY, SlaveState
from .state_check import bound, count, flag, number, potential, record, require, vector
from .table_slave import LONGEST, TableSlave, logged

_KEPT = ("sampled", "set_at", "fresh", "now", "ahead")


@dataclass(frozen=True, eq=False)
class _Kept:
    """What a state keeps of a controller.

    Attributes
    ----------
    sampled, set_at, fresh, ahead : as the slave has them
    now : the last decision
    controller : with what the parameters say
    """

    sampled: int
    set_at: float
    fresh: bool
    now: Command
    ahead: Command | None
    controller: SampledController = field(metadata=IN_MEMORY)


class PspController(TableSlave):
    """The feedback law for vehicles outside the FMU.

    Sampling instants lie at start + phase + k T.  At a communication point that is one, the command is computed from
    the inputs set there: when the outputs are read after inputs were set, at the latest when the next step begins.
    Instants inside a communication step use the inputs from its beginning.
    """

    _part: SampledController | None

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._networks, self._trained = networks_of(Path(self.resources), self._config["networks"])
        self._ahead: Command | None = None  # the decision at the instant that the current point is, if one is known
        self._sampled = 0  # instants already passed
        self._set_at = 0.0  # [sampling periods] since the first sampling instant, when spacings or speeds were last set
        self._fresh = True  # inputs were set at this communication point

    def _make_table(self) -> tuple[Variable, ...]:
        return controller_table(self.vehicles, self._config["default_source"])

    def _changed(self, inputs: bool) -> None:
        super()._changed(inputs)
        self._ahead, self._stale, self._fresh = None, True, True
        self._set_at = self._here()

    # initialisation

    def _initialise(self) -> SampledController:
        settings = self._settings()
        self._clock = Clock.begin(self._clock.time, self._value("phase"), settings.sampling.T)
        self._set_at = self._here()  # what was set before belongs to the start
        return self._made(settings)

    def _made(self, settings: ControllerSettings) -> SampledController:
        return SampledController.begin(settings, self._networks, self._warn, self._trained)

    def _settings(self) -> ControllerSettings:
        """What the parameters say, checked."""
        read, sampling = self._value, self._sampling()
        phase = read("phase")
        if not 0 <= phase < sampling.T:
            raise ModelError("phase", phase, sampling.T)
        return ControllerSettings(
            capacity=self.vehicles,
            constants=constants_of(read),
            weights=weights_of(read),
            sampling=sampling,
            request=self._request(),
            a_min=read("a_min"),
            a_max=read("a_max"),
            bad_input=BadMeasurement(self._chosen("bad_input")),
            a_safe=read("a_safe"),
            max_age=read("max_age"),
        )

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
        self._require_here(current_time, step_size)
        controller = self._part
        assert controller is not None
        if step_size <= 0.0:
            return True
        clock = self._clock.after(current_time, step_size, self._value("T"))
        period, fraction = clock.at()
        self._stale, passed = True, self._sampled
        while self._sampled < period + (fraction > 0.0):  # at the end of the step newer inputs may come
            if self._ahead is not None:
                controller.now, self._ahead = self._ahead, None
            else:
                try:
                    self._sample(controller)
                except ModelError as error:
                    if self._sampled == passed:
                        raise
                    # the step ends here, where newer inputs may come, and the command held is shown
                    T = self._value("T")
                    size = self._clock.time_of(self._sampled, T) - current_time
                    self._clock, self._fresh = self._clock.after(current_time, size, T), False
                    return self._discard(error)
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

    def _kept(self, controller: SampledController) -> _Kept:
        return _Kept(self._sampled, self._set_at, self._fresh, controller.now, self._ahead, controller)

    def _taken_up(self, kept: _Kept) -> SampledController:
        self._sampled, self._set_at, self._fresh, self._ahead = kept.sampled, kept.set_at, kept.fresh, kept.ahead
        return replace(kept.controller, now=kept.now, warn=self._warn)

    def _become_state(self, state: SlaveState) -> None:
        self._sampled, self._set_at, self._fresh, self._ahead = 0, 0.0, True, None
        super()._become_state(state)

    def _restored(self, data: Any, here: Clock) -> _Kept:
        kept, settings = record(data, _KEPT), self._settings()
        set_at, sampled = number(kept["set_at"]), count(kept["sampled"])
        require(set_at <= here.period + here.offset + 1.0)
        require(abs(sampled - here.period) <= 2)  # or a step would pass others without end
        now = _unpack(kept["now"], settings)
        ahead = None if kept["ahead"] is None else _unpack(kept["ahead"], settings)
        return _Kept(sampled, set_at, flag(kept["fresh"]), now, ahead, self._made(settings))


def _unpack(data: Any, settings: ControllerSettings) -> Command:
    packed, N = record(data, Command.__dataclass_fields__), settings.capacity
    saturated, n_active = packed["saturated"], count(packed["n_active"])
    require(n_active <= N and isinstance(saturated, list) and len(saturated) == N)
    return Command(
        a=vector(packed["a"], N),
        saturated=np.array([flag(one) for one in saturated], dtype=bool),
        in_order=flag(packed["in_order"]),
        T_max=bound(packed["T_max"]),
        violations=count(packed["violations"]),
        faults=count(packed["faults"]),
        choices=count(packed["choices"]),
        n_active=n_active,
        in_domain=flag(packed["in_domain"]),
        resolve=number(packed["resolve"]),
        shape=potential(packed["shape"], settings.constants, settings.request.old),
    )
