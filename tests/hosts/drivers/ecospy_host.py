from common import NAMES, STEP, STEPS, fmu, installed, report
from ecospy import EcosSimulation, EcosSimulationStructure

structure = EcosSimulationStructure()
structure.add_model("platoon", fmu)
with EcosSimulation(structure=structure, step_size=STEP) as simulation:
    simulation.init()
    columns = {name: [] for name in NAMES}
    for _ in range(STEPS):
        simulation.step(1)
        for name in NAMES:
            columns[name].append(simulation.get_real("platoon::" + name))
    simulation.terminate()
report(installed("ecospy"), columns, first=1)
