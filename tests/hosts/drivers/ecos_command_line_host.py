import csv
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import ecospy
from common import NAMES, STEP, STOP, fmu, installed, report

binaries = Path(ecospy.__file__).parent / "binaries"
with tempfile.TemporaryDirectory() as folder:
    program = shutil.copy(binaries / "ecos", folder)
    os.chmod(program, 0o755)
    environment = os.environ | {"LD_LIBRARY_PATH": str(binaries)}
    command = [program, "simulate", "--path", fmu, "--stopTime", str(STOP), "--stepSize", str(STEP), "-l", "err"]
    subprocess.run(command, check=True, cwd=folder, env=environment, stdout=subprocess.DEVNULL)
    (table,) = Path(folder).rglob("*.csv")
    with table.open() as file:
        rows = list(csv.DictReader(file, skipinitialspace=True))
key = {name: next(k for k in rows[0] if f"::{name}[REAL]" in k.replace(" ", "")) for name in NAMES}
report(installed("ecospy"), {name: [float(row[key[name]]) for row in rows] for name in NAMES})
