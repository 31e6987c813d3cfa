"""Fuzzes a native FMU: python tests/native/fuzz/run.py SECONDS [JOBS [COMPONENT]]   (clang with libFuzzer)

Ten minutes on two cores: python tests/native/fuzz/run.py 600 2.  Inputs that fail lie in the folder named at the end.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from shutil import which
from tempfile import mkdtemp

from fmu_src.native.components import native_fmu
from fmu_src.networks import networks_up_to
from fmu_src.toolchain.compile import FMI_HEADERS

SANITIZERS = "-fsanitize=fuzzer,address,undefined,float-cast-overflow"


def compiler() -> str | None:
    """A clang that brings libFuzzer, None if there is none."""
    names = ("clang", "clang-19", "clang-16", "clang-15", "clang-14")
    return next((path for name in names if (path := which(name))), None)


def build(folder: Path, component: str, vehicles: int = 7) -> Path:
    """The fuzzer of a component for n vehicles."""
    sources = native_fmu(component, vehicles, networks_up_to(vehicles)).sources("{fuzz}")
    for name, content in sources.items():
        (folder / name).write_bytes(content)
    fuzzer = folder / "fuzz_fmi"
    command = [
        str(compiler()),
        "-std=c11",
        "-O1",
        "-g",
        SANITIZERS,
        "-fno-sanitize-recover=all",
    ]
    command += ["-I", str(FMI_HEADERS), "-I", str(folder), "-o", str(fuzzer), str(Path(__file__).parent / "fuzz_fmi.c")]
    command += [str(folder / name) for name in sources if name.endswith(".c")] + ["-lm"]
    subprocess.run(command, check=True)
    return fuzzer


def fuzz(seconds: int, jobs: int = 1, component: str = "platoon") -> subprocess.CompletedProcess[str]:
    """Fuzz a component for some time; the exit status is 0 if nothing was found."""
    folder = Path(mkdtemp(prefix="psp_fuzz_"))
    (folder / "corpus").mkdir()
    options = [
        f"-max_total_time={seconds}",
        "-max_len=600",
        "-timeout=20",
        "-rss_limit_mb=2048",
        "-print_final_stats=1",
    ]
    options += [f"-jobs={jobs}", f"-workers={jobs}"] if jobs > 1 else []
    command = [str(build(folder, component)), *options, str(folder / "corpus")]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def main() -> int:
    """Fuzz as the command line says."""
    if compiler() is None:
        print("no clang on this machine: apt install clang", file=sys.stderr)
        return 2
    jobs, component = (*sys.argv[2:], *("1", "platoon")[len(sys.argv) - 2 :])
    ran = fuzz(int(sys.argv[1]), int(jobs), component)
    print(ran.stderr[-6000:])
    print(ran.args[0], "exit status", ran.returncode)
    return ran.returncode


if __name__ == "__main__":
    sys.exit(main())
