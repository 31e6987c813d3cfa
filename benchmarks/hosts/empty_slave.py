"""A pythonfmu slave that does nothing, with as many outputs as the platoon: what pythonfmu itself costs."""

from pythonfmu import Fmi2Causality, Fmi2Slave, Real

OUTPUTS = 1  # written over when the FMU is built


class EmptySlave(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        for i in range(OUTPUTS):
            name = f"y{i}"
            setattr(self, name, float(i))
            self.register_variable(Real(name, causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        return True
