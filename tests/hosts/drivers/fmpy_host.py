import fmpy
from common import NAMES, STEP, STOP, fmu, report

result = fmpy.simulate_fmu(fmu, stop_time=STOP, step_size=STEP, output_interval=STEP, output=NAMES)
report(fmpy.__version__, {name: result[name].tolist() for name in NAMES})
