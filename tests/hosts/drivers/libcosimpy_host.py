from common import NAMES, STEP, STEPS, fmu, installed, report
from fmpy import read_model_description
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

reference = {v.name: v.valueReference for v in read_model_description(fmu).modelVariables}
execution = CosimExecution.from_step_size(step_size=round(STEP * 1e9))  # [ns]
slave = execution.add_local_slave(CosimLocalSlave(fmu_path=fmu, instance_name="platoon"))
observer = CosimObserver.create_last_value()
assert execution.add_observer(observer)
columns = {name: [] for name in NAMES}
for _ in range(STEPS):
    assert execution.step()
    for name, value in zip(NAMES, observer.last_real_values(slave, [reference[n] for n in NAMES]), strict=True):
        columns[name].append(value)
report(installed("libcosimpy"), columns, first=1)
