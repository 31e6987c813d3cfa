"""The pythonfmu slave `PspController`: a thin shim between FMI and `psp_model.SampledController`."""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from pathlib import Path
from typing import Any

from psp_model.controller import (
    BadMeasurement,
    Command,
    ControllerSettings,
    Measurement,
    SampledController,
    followed_of,
    is_certified,
    margin_of,
)
from psp_model.errors import ModelError
from psp_model.sampling.clock import Clock
from psp_model.sampling.uncertain import Errors

from ..interface.controller import controller_table
from ..interface.meaning import actuation_of, constants_of, cooperation_of, weights_of
from ..interface.variables import Variable
from .controller_state import Kept, restored
from .network_files import networks_of
from .slave_state import SlaveState
from .table_slave import LONGEST, TableSlave, logged


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
        self._margin = self._place["brake_margin"]
        self._margin_known = False  # brake_margin in _values is that of `_shown`

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
        constants, n = constants_of(read), self.vehicles
        return ControllerSettings(
            capacity=n,
            constants=constants,
            weights=weights_of(read),
            sampling=sampling,
            request=self._request(),
            cooperation=cooperation_of(read, self._rows, n, constants.L),
            actuation=actuation_of(read, n),
            errors=Errors(read("error_s"), read("error_v")),
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
            s=self._numbers("s", 2, n),
            v=self._numbers("v", 1, n),
            n_active=self._value("n_active"),
            resolve=self._value("resolve"),
            age=age,
            age_rounding=self._clock.age_rounding(age, T),
            v_desired=None if desired <= -1 else desired,
            a_desired=self._value("a_desired"),
            automated=self._numbers("automated", 1, n),
            a_measured=self._numbers("a_measured", 1, n),
            a_known=self._numbers("a_known", 1, n),
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

    def _get(self, references: list[int], integer: bool) -> list[float]:
        values = super()._get(references, integer)
        if not self._margin_known and self._margin in references and self._part is not None:
            self._values[self._margin] = margin_of(self._part.settings, self._shown)
            self._margin_known = True
            return super()._get(references, integer)
        return values

    def _outputs(self, controller: SampledController) -> list[float]:
        """All but brake_margin, which takes as long as the rest together, and is computed where it is read."""
        now, settings = self._decided(controller), controller.settings
        self._shown, self._margin_known = now, False
        shape, N = now.shape, settings.capacity
        lemma1 = (min(now.T_max, LONGEST), now.T_max > settings.sampling.T)
        exact = (min(now.T_exact, LONGEST), is_certified(settings, now))
        reports = (shape.alpha, shape.r, shape.p, now.in_domain, *lemma1, *exact, now.violations)
        counts = (now.in_order, now.faults, now.choices)
        basis, s, v = now.basis, [0.0] * (N - 1), [0.0] * N
        if basis is not None:
            s[: basis.s.size], v[: basis.v.size] = basis.s_predicted.tolist(), basis.v_predicted.tolist()
        seen = (0.0, *s, *v, *followed_of(settings, now))
        return [*map(float, (*now.a, *now.saturated, *reports, *counts, *seen))]

    # the whole state

    def _kept(self, controller: SampledController) -> Kept:
        return Kept(self._sampled, self._set_at, self._fresh, controller.now, self._ahead, controller)

    def _taken_up(self, kept: Kept) -> SampledController:
        self._sampled, self._set_at, self._fresh, self._ahead = kept.sampled, kept.set_at, kept.fresh, kept.ahead
        return replace(kept.controller, now=kept.now, warn=self._warn)

    def _become_state(self, state: SlaveState) -> None:
        self._sampled, self._set_at, self._fresh, self._ahead = 0, 0.0, True, None
        super()._become_state(state)

    def _restored(self, data: Any, here: Clock) -> Kept:
        return restored(data, here, self._made(self._settings()))
