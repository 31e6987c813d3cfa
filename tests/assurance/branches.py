"""Measures which branches the tests reach: python tests/assurance/branches.py [FOLDER]   (make coverage)

Python: `psp_model`, by coverage.py, in the tests, in the processes that they start, and as the copy inside the FMUs
that they run.  C: the FMI front and the native backends, by clang's counters in every native FMU that the tests build.
What was not reached is listed in FOLDER; the table lies in benchmarks/results.
"""

from __future__ import annotations

if __name__ == "__main__":  # before the imports that take time
    from psp_cli.interrupt import install

    install("branches.py")

import json
import os
import subprocess
import sys
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from shutil import rmtree, which

ROOT = Path(__file__).parents[2]
TABLE = ROOT / "benchmarks" / "results" / "branches.md"
PYTHON_TESTS = ["tests/model", "tests/fmu", "tests/offline", "tests/traffic"]
C_TESTS = [f"tests/native/test_{name}.py" for name in ("front", "agreement", "derivatives", "edges", "c_functions")]
C_TESTS += [f"tests/native/test_{name}.py" for name in ("joining", "joining_at_random")]
C_TESTS += [f"tests/traffic/test_controller_{name}.py" for name in ("native", "behaviour")]


@dataclass(frozen=True)
class File:
    """Branches of one source file.

    Attributes
    ----------
    count : how many there are
    missed : where those are that no test reached
    """

    count: int
    missed: tuple[str, ...]


def run(*command: str, **environment: str) -> None:
    """A module of this Python in the project's folder; what a failed test still reached counts, but it is said."""
    path = os.pathsep.join([str(ROOT), str(ROOT / "tests"), os.environ.get("PYTHONPATH", "")])
    told = os.environ | {"PYTHONPATH": path} | environment
    if subprocess.run([sys.executable, "-m", *command], cwd=ROOT, env=told, check=False).returncode:
        print(f"failed: {' '.join(command)}", file=sys.stderr)


def of_python(folder: Path) -> dict[str, File]:
    """Branches of `psp_model`."""
    report, data = folder / "python.json", {"COVERAGE_FILE": str(folder / "python" / "data")}
    (folder / "python").mkdir()
    run("coverage", "run", "-m", "pytest", "-q", *PYTHON_TESTS, **data)
    run("coverage", "combine", "--quiet", **data)
    run("coverage", "json", "--quiet", "-o", str(report), **data)
    found = {}
    for name, file in sorted(json.loads(report.read_text())["files"].items()):
        missed = [f"line {a} to {'the end' if b < 0 else b}" for a, b in file["missing_branches"]]
        found[name] = File(file["summary"]["num_branches"], tuple(missed))
    return found


def of_c(folder: Path) -> dict[str, File]:
    """Branches of the hand-written C sources, counted over all native FMUs; what CasADi wrote does not count."""
    profiles, merged = folder / "profiles", folder / "c.profdata"
    told = {"PSP_COVERAGE": str(folder), "LLVM_PROFILE_FILE": str(profiles / "%m-%p.profraw")}
    run("pytest", "-q", "-p", "assurance.instrumented", *C_TESTS, **told)
    raw = [str(path) for path in profiles.glob("*.profraw")]
    subprocess.run([tool("llvm-profdata"), "merge", "-o", str(merged), *raw], check=True)
    taken: dict[str, Counter[tuple[int, int, bool]]] = {}
    for library in sorted((folder / "libraries").glob("*.so")):
        export = [tool("llvm-cov"), "export", "-format=text", f"-instr-profile={merged}", str(library)]
        printed = subprocess.run(export, check=True, capture_output=True).stdout
        for function in json.loads(printed)["data"][0]["functions"]:
            names = [Path(name).name for name in function["filenames"]]
            for line, column, _, _, yes, no, file, *_ in function["branches"]:
                counts = taken.setdefault(names[file], Counter())
                counts[line, column, True] += yes
                counts[line, column, False] += no
    own = {path.name for part in ("c", "native/c") for path in (ROOT / "fmu_src" / part).glob("*.[ch]")}
    return {
        name: File(len(counts), tuple(f"{at[0]}:{at[1]} never {at[2]}" for at, n in sorted(counts.items()) if n == 0))
        for name, counts in sorted(taken.items())
        if name in own
    }


def tool(name: str) -> str:
    """The path of an LLVM tool, with or without a version in its name."""
    path = next((path for version in ("", "-14", "-15", "-16", "-19") if (path := which(name + version))), None)
    if path is None:
        raise SystemExit(f"{name} is not installed: apt install clang llvm")
    return path


def as_markdown(found: dict[str, dict[str, File]]) -> str:
    """The table."""
    lines = ["# Branches", "", "`make coverage`, branches that the tests reach:", ""]
    lines += ["| sources | files | branches | reached | |", "|---|---|---|---|---|"]
    for title, files in found.items():
        count = sum(file.count for file in files.values())
        reached = count - sum(len(file.missed) for file in files.values())
        lines.append(f"| {title} | {len(files)} | {count} | {reached} | {100 * reached / count:.1f} % |")
    return "\n".join([*lines, ""])


def main(folder: Path) -> None:
    """Measure, print, keep."""
    rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    found = {"C: FMI front and native backends": of_c(folder), "Python: psp_model": of_python(folder)}
    places = [f"{name}: {place}" for files in found.values() for name, file in files.items() for place in file.missed]
    (folder / "missed.txt").write_text("\n".join([*places, ""]), encoding="utf-8")
    TABLE.write_text(as_markdown(found), encoding="utf-8")
    print(TABLE.read_text(encoding="utf-8") + f"\n{folder / 'missed.txt'} lists the {len(places)} branches not reached")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else ROOT / "build" / "coverage")
