from common import NAMES, STEP, STEPS, fmu, installed, report
from syssimx import FMUComponent

component = FMUComponent("platoon", fmu)
component.initialize(0.0)
columns = {name: [] for name in NAMES}
for k in range(STEPS):
    component.do_step(k * STEP, STEP)
    outputs = component.get_outputs()
    for name in NAMES:
        value = outputs[name]
        columns[name].append(float(getattr(value, "magnitude", value)))
report(installed("syssimx"), columns, first=1)
