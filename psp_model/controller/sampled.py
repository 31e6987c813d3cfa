"""The controller of measured vehicles as a shell around its pure decisions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ..callbacks import Warns, silent
from ..errors import ModelError
from ..sampling.policy import Lemma1Policy
from ..selection.network import ParameterNetwork
from ..selection.selectors import Selector, Trained, selector_for
from .deciding import Verdict, decide
from .decision import Command, is_certified, no_command
from .measurement import Measurement
from .settings import BadMeasurement, ControllerSettings


@dataclass
class SampledController(Warns):
    """The feedback law for measured vehicles: a shell around `decide` that acts on its verdicts as the policies say.

    Attributes
    ----------
    settings : of the controller
    selector : selects alpha, r, p
    trained : what networks were trained on, by number of vehicles
    now : the command held, all zeros before the first sampling instant
    warn : called with one sentence for each thing to be warned of
    """

    settings: ControllerSettings
    selector: Selector
    trained: Mapping[int, Trained]
    now: Command
    warn: Callable[[str], None] = silent

    @classmethod
    def begin(
        cls,
        settings: ControllerSettings,
        networks: Mapping[int, ParameterNetwork] | None = None,
        warn: Callable[[str], None] = silent,
        trained: Mapping[int, Trained] | None = None,
    ) -> SampledController:
        """A controller before its first sampling instant.

        Parameters
        ----------
        settings : of the controller
        networks : by number of vehicles
        warn : as the attribute
        trained : as the attribute, where it is known without opening the networks

        Raises
        ------
        ModelError : where the settings make no sense
        """
        settings.checked()
        selector = selector_for(settings.request, networks or {}, settings.weights, settings.sampling)
        known = (networks or {}) if trained is None else trained
        return cls(settings, selector, known, no_command(settings), warn)

    def sample(self, time: float, measured: Measurement) -> None:
        """Decide at a sampling instant and make the decision `now`.

        Parameters
        ----------
        time : of the instant [s], for messages
        measured : the inputs

        Raises
        ------
        ModelError : with bad_input 1 where the inputs are not in order; under policy 1 where T is not certified; where
            a network file is at fault
        """
        before, settings = self.now, self.settings
        decision = decide(settings, self.selector, self.trained, before, time, measured)
        if decision.warning:
            self.warn(decision.warning)
        if decision.verdict is Verdict.BAD_MEASUREMENT:
            assert decision.why is not None
            if settings.bad_input == BadMeasurement.ERROR:
                raise decision.why
            if before.in_order:
                self.warn(str(ModelError("safe_action", time, decision.why)))
        if decision.verdict is Verdict.NOT_CERTIFIED:
            assert decision.why is not None
            if settings.sampling.policy == Lemma1Policy.ERROR:
                raise decision.why
            if before.violations == 0 or is_certified(settings, before):
                self.warn(str(decision.why))
        self.now = decision.command
