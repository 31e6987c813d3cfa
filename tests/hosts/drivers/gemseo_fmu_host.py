from common import NAMES, STEP, STOP, fmu, installed, report
from gemseo_fmu.disciplines.fmu_discipline import FMUDiscipline

discipline = FMUDiscipline(fmu, input_names=None, output_names=NAMES, final_time=STOP, time_step=STEP)
data = discipline.execute()
report(installed("gemseo-fmu"), {name: list(map(float, data[name])) for name in NAMES})
