"""Speed of the native FMU against a hand-written C loop, and against the Python FMU: python benchmarks/native_speed.py

Everything is measured in one run, from a C host: fmi2DoStep over one sampling period, then fmi2GetReal of all outputs;
the best of many repetitions counts.  The loop is compiled for the same number of vehicles with the flags of the FMU.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from fmpy import extract, read_model_description

from build_fmu import main as build
from fmu_src.native.compile import FLAGS, FMI_HEADERS

HERE = Path(__file__).parent
ON_HILL, OFF_HILL = 12.0, 15.0  # [m] gaps that stay on the hill of r = 11 m, and beyond it


def compile_host(vehicles: int, folder: Path) -> Path:
    """The C host with its loop for n vehicles, by the compiler of the FMU."""
    host = folder / f"speed_{vehicles}"
    flags = [flag for flag in FLAGS if flag not in ("-shared", "-fvisibility=hidden")]
    command = [sys.executable, "-m", "ziglang", "cc", "-target", "x86_64-linux-gnu.2.17", *flags, f"-DN={vehicles}"]
    command += ["-I", str(FMI_HEADERS), "-o", str(host), str(HERE / "native_speed.c"), "-lm", "-ldl"]
    subprocess.run(command, check=True)
    return host


def measure(host: Path, fmu: Path, gap: float, steps: int, repeats: int) -> list[float]:
    """Nanoseconds per step of the FMU and of the loop, their largest difference, share of gaps on the hill."""
    folder = Path(extract(str(fmu), str(fmu.with_suffix(""))))
    model = read_model_description(str(folder), validate=False)
    reference = {variable.name: variable.valueReference for variable in model.modelVariables}
    outputs = [v.valueReference for v in model.modelVariables if v.causality == "output"]
    library = folder / "binaries" / "linux64" / f"{model.coSimulation.modelIdentifier}.so"
    numbers = [len(outputs), outputs[0], reference["s_start[2]"], reference["v_start[1]"]]
    numbers += [reference["parameter_source"], gap, steps, repeats]
    command = [str(host), str(library), (folder / "resources").as_uri(), model.guid, *map(str, numbers)]
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    ran = subprocess.run(command, check=True, capture_output=True, text=True, env=os.environ | {"PATH": path})
    return [float(word) for word in ran.stdout.split()]


def main() -> list[tuple[int, str, float, float, float]]:
    """Print the table; its rows: n, case, FMU [ns], loop [ns], Python FMU [ns] or NaN."""
    rows = []
    print(f"{'n':>5} {'hill':>5} {'FMU ns':>9} {'loop ns':>9} {'ratio':>6} {'ns/vehicle':>10} {'Python/native':>13}")
    with TemporaryDirectory() as temporary:
        for vehicles in (7, 100, 1000):
            folder = Path(temporary) / str(vehicles)
            for runtime in ("native", "python")[: 2 if vehicles == 7 else 1]:
                if build(["--runtime", runtime, "--vehicles", str(vehicles), "--output", str(folder)]):
                    sys.exit(1)
            host = compile_host(vehicles, folder)
            for case, gap in (("off", OFF_HILL), ("on", ON_HILL)):
                fmu, loop, difference, share = measure(
                    host, folder / "PspPlatoonNative.fmu", gap, 50, 20000 // vehicles
                )
                assert difference < 1e-9 and share == (case == "on"), (difference, share)
                python = float("nan")
                if vehicles == 7:
                    python = measure(host, folder / "PspPlatoon.fmu", gap, 50, 20)[0]
                rows.append((vehicles, case, fmu, loop, python))
                ratio = f"{python / fmu:13.0f}" if python == python else f"{'':13}"
                print(f"{vehicles:5} {case:>5} {fmu:9.1f} {loop:9.1f} {fmu / loop:6.2f} {fmu / vehicles:10.2f} {ratio}")
    return rows


if __name__ == "__main__":
    main()
