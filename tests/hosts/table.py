"""Runs both FMUs in every host and prints the compatibility table: python tests/hosts/table.py FOLDER

Each host gets a virtual environment of its own in FOLDER, because some of them want versions that others do not; those
that are there already are used as they are.  ecos needs Debian's libtbb12.
"""

from __future__ import annotations

import json
import subprocess
import sys
from datetime import date
from pathlib import Path
from shutil import rmtree
from tempfile import TemporaryDirectory

import numpy as np

from build_fmu import main as build
from fmu_src.interface.platoon import platoon_table
from fmu_src.networks import networks_up_to
from psp_model import PlatoonState, project, simulate
from psp_model.selection.network import ParameterNetwork

HERE = Path(__file__).parent
HOSTS = {  # driver: (name in the table, packages of its environment)
    "fmpy_host": ("fmpy", ["fmpy"]),
    "libcosimpy_host": ("libcosimpy (libcosim, C++)", ["libcosimpy", "fmpy"]),
    "ecospy_host": ("ecospy (ecos, C++)", ["ecospy"]),
    "ecos_command_line_host": ("ecos command line (C++, no Python)", ["ecospy"]),
    "sofirpy_host": ("sofirpy", ["sofirpy"]),
    "cofmupy_host": ("cofmupy", ["cofmupy"]),
    "pathsim_fmi_host": ("pathsim-fmi", ["pathsim-fmi"]),
    "gemseo_fmu_host": ("gemseo-fmu", ["gemseo-fmu"]),
    "syssimx_host": ("syssimx", ["syssimx", "fmpy"]),
    "omsimulator_host": ("OMSimulator (C++, through Python)", ["OMSimulator"]),
    "fmu_container_host": ("fmu-manipulation-toolbox (check, container)", ["fmu-manipulation-toolbox", "fmpy"]),
}


def environment(packages: list[str], folder: Path) -> Path:
    """The Python of a host's virtual environment, made if it is missing; onnxruntime is for the Python FMU.

    Raises
    ------
    OSError : where pip cannot install the packages
    """
    python = folder / packages[0] / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", str(python.parents[1])], check=True)
        install = [str(python), "-m", "pip", "install", "--quiet", *packages, "onnxruntime", "numpy"]
        if subprocess.run(install, check=False).returncode != 0:
            rmtree(python.parents[1])
            raise OSError(f"{' '.join(packages)} cannot be installed")
    return python


def reference() -> dict[str, np.ndarray]:
    """The run that all hosts should show, from psp_model and without FMI."""
    start = {row.name: row.start for row in platoon_table(7)}
    spacings = np.array([start[f"s_start[{i}]"] for i in range(2, 8)])
    speeds = np.array([start[f"v_start[{i}]"] for i in range(1, 8)])
    state = PlatoonState(spacings, speeds)
    network = ParameterNetwork(HERE.parents[1] / "onnx" / "platoon_7.onnx")
    run = simulate(state, project(network.evaluate(spacings, speeds), state.constants), duration=5.0)
    columns = {"x[7]": run.x[:, 6], "v[1]": run.v[:, 0], "a[5]": run.a[:, 4], "s[4]": run.s[:, 2]}
    return columns | {"T_max": run.T_max, "J": run.cost.sum(axis=1)}


def difference(python: Path, driver: str, fmu: Path, expected: dict[str, np.ndarray]) -> tuple[str, str]:
    """Version of the host, and its largest difference from the reference or why there is none."""
    path = f"{python.parent}:/usr/local/bin:/usr/bin:/bin"
    command = [str(python), str(HERE / "drivers" / f"{driver}.py"), str(fmu)]
    try:
        with TemporaryDirectory() as folder:
            ran = subprocess.run(
                command, capture_output=True, text=True, env={"PATH": path}, timeout=200, check=False, cwd=folder
            )
    except subprocess.TimeoutExpired:
        return "", "timed out"
    line = next((line for line in ran.stdout.splitlines() if "RESULT " in line), None)
    if line is None:
        said = (ran.stdout + ran.stderr).strip().splitlines() or ["nothing said"]
        return "", f"failed ({ran.returncode}): {said[-1][:160]}"
    found = json.loads(line[line.index("RESULT ") + 7 :])
    worst = 0.0
    for name, values in found["columns"].items():
        wanted = expected[name][found["first"] :][: len(values)]
        if len(values) < 495:
            return found["version"], f"only {len(values)} rows"
        worst = max(worst, float(np.abs(np.array(values)[: len(wanted)] - wanted).max()))
    return found["version"], f"{worst:.1e}"


def row(
    driver: str, packages: list[str], folder: Path, fmus: Path, expected: dict[str, np.ndarray]
) -> tuple[str, str, str]:
    """Version of a host, and what it makes of the native FMU and of the Python FMU."""
    try:
        python = environment(packages, folder)
    except OSError as error:
        return "", str(error), ""
    version, native = difference(python, driver, fmus / "PspPlatoonNative.fmu", expected)
    other, slow = difference(python, driver, fmus / "PspPlatoon.fmu", expected)
    return version or other, native, slow


def main(folder: Path) -> list[tuple[str, str, str, str]]:
    """Print the table in Markdown; its rows: host, version, native FMU, Python FMU."""
    rows = []
    expected = reference()
    with TemporaryDirectory() as temporary:
        for runtime in ("native", "python"):
            build(["--runtime", runtime, "--output", temporary])
        print(f"\n{date.today()}, `python tests/hosts/table.py {folder}`: largest difference from psp_model over 5 s\n")
        print("| host | version | native FMU | Python FMU |\n|---|---|---|---|")
        for driver, (name, packages) in HOSTS.items():
            rows.append((name, *row(driver, packages, folder, Path(temporary), expected)))
            print("| " + " | ".join(rows[-1]) + " |", flush=True)
    assert 7 in networks_up_to(7)
    return rows


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("build/hosts"))
