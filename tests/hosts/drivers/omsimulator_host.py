from common import NAMES, STEP, STEPS, STOP, fmu, report
from OMSimulator import FMU, Capi

model = FMU(fmu)
model.stepSize, model.stopTime = STEP, STOP
model.instantiate()
model.setResultFile("")
model.initialize()
columns = {name: [] for name in NAMES}
for k in range(1, STEPS + 1):
    model.stepUntil((k - 0.5) * STEP)  # it takes whole steps, adding them up, until it is there
    for name in NAMES:
        columns[name].append(model.getValue(name))
model.terminate()
model.delete()
report(Capi.getVersion().removeprefix("OMSimulator "), columns, first=1)  # one built from source has no metadata
