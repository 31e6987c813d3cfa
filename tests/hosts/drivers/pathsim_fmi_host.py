from common import NAMES, STEP, STOP, fmu, installed, report
from pathsim import Connection, Simulation
from pathsim.blocks import Scope
from pathsim_fmi import CoSimulationFMU

block = CoSimulationFMU(fmu, dt=STEP)
ports = [list(block.fmu_wrapper.output_refs).index(name) for name in NAMES]
scope = Scope(sampling_period=STEP, t_wait=STEP / 2)  # between two steps, where the order of events does not matter
links = [Connection(block[port], scope[place]) for place, port in enumerate(ports)]
simulation = Simulation([block, scope], links, dt=STEP, log=False)
simulation.run(STOP)
_, values = scope.read()
report(installed("pathsim-fmi"), {name: list(map(float, values[place])) for place, name in enumerate(NAMES)}, first=1)
