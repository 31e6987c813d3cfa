"""The smallest slave that exercises the launcher: y counts steps, and `mode` makes things go wrong."""

import json

import numpy as np
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real
from pythonfmu.enums import Fmi2Status


class TinySlave(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.y = 0.0
        self.mode = 0.0
        self.register_variable(Real("y", causality=Fmi2Causality.output))
        self.register_variable(
            Real("mode", causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable, start=0.0)
        )

    def do_step(self, current_time, step_size):
        if self.mode == 1:
            self.log("100 % wrong: %s %n", Fmi2Status.error)
            return False
        if self.mode == 2:
            raise RuntimeError("a bug")
        if self.mode == 3:
            self.log("careful", Fmi2Status.warning)
        if self.mode == 4:
            return False
        self.y += float(np.ones(1)[0])
        return True

    @staticmethod
    def _fmu_state_to_bytes(state):
        return json.dumps(state).encode()
