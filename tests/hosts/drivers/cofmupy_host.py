from cofmupy import Coordinator
from common import NAMES, STEP, STEPS, fmu, installed, report

coordinator = Coordinator()
coordinator.start({"fmus": [{"id": "platoon", "path": fmu}], "connections": [], "cosim_method": "jacobi"})
columns = {name: [] for name in NAMES}
for _ in range(STEPS):
    coordinator.do_step(STEP)
    for name in NAMES:
        columns[name].append(float(coordinator.get_variable(("platoon", name))[0]))
report(installed("cofmupy"), columns, first=1)
