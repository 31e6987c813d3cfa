"""Somebody else's slave, as pythonfmu packs it: y counts steps, and `found` tells which pythonfmu it runs with."""

import pythonfmu
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class ForeignSlave(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.y = 0.0
        self.found = float("".join(pythonfmu.__version__.split(".")))
        for name in ("y", "found"):
            self.register_variable(Real(name, causality=Fmi2Causality.output, variability=Fmi2Variability.continuous))

    def do_step(self, current_time, step_size):
        self.y += step_size
        return True
