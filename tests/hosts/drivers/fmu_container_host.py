import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import fmpy
from common import NAMES, STEP, STOP, fmu, installed, report

tools = Path(sys.executable).parent
with tempfile.TemporaryDirectory() as folder:
    name = Path(shutil.copy(fmu, folder)).name
    check = subprocess.run([tools / "fmutool", "-input", name, "-check"], cwd=folder, capture_output=True, text=True)
    complaints = [line for line in (check.stdout + check.stderr).splitlines() if line.startswith(("WARN", "ERROR"))]
    if complaints:
        sys.exit(f"fmutool -check: {complaints}")
    spec = {"fmu": [name], "output": [[name, variable, variable] for variable in NAMES], "step_size": STEP}
    Path(folder, "container.json").write_text(json.dumps(spec))
    subprocess.run([tools / "fmucontainer", "-container", "container.json"], cwd=folder, check=True, stdout=sys.stderr)
    made = str(Path(folder, "container.fmu"))
    result = fmpy.simulate_fmu(made, stop_time=STOP, step_size=STEP, output_interval=STEP, output=NAMES)
report(installed("fmu-manipulation-toolbox"), {variable: result[variable].tolist() for variable in NAMES})
