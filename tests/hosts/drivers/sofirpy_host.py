import sofirpy
from common import NAMES, STEP, STOP, fmu, installed, report

log = {"platoon": NAMES}
table = sofirpy.simulate(stop_time=STOP, step_size=STEP, fmu_paths={"platoon": fmu}, parameters_to_log=log)
report(installed("sofirpy"), {name: table[f"platoon.{name}"].tolist() for name in NAMES})
