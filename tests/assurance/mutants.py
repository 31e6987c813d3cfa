"""Changes the model in one place at a time: does a test notice?   python tests/assurance/mutants.py   (make mutation)

mutmut makes the changes and runs the tests that pyproject.toml names; a change that nobody notices must be explained in
equivalent_mutants.toml.  Exit status 1 where one is not, or where an explanation fits none.
"""

from __future__ import annotations

if __name__ == "__main__":  # before the imports that take time
    from psp_cli.interrupt import install

    install("mutants.py")

import json
import subprocess
import sys
import tomllib
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[2]
TABLE = ROOT / "benchmarks" / "results" / "mutation.md"
EXPLAINED = Path(__file__).parent / "equivalent_mutants.toml"
KILLED = {1, 3, -24, 24, 36, 152, 255}  # a test failed, or never came to an end


def mutmut(*arguments: str) -> str:
    """What a mutmut command prints; its progress goes to the screen."""
    command = [sys.executable, "-m", "mutmut", *arguments]
    shown = None if arguments[0] == "run" else subprocess.PIPE
    return subprocess.run(command, cwd=ROOT, stdout=shown, text=True, check=False).stdout or ""


def statuses() -> dict[str, int | None]:
    """pytest's exit status for every mutant, by name; None where it was not run."""
    found: dict[str, int | None] = {}
    for path in sorted((ROOT / "mutants").rglob("*.meta")):
        found |= json.loads(path.read_text(encoding="utf-8"))["exit_code_by_key"]
    return found


def change(mutant: str) -> tuple[str, str, str]:
    """The function that a mutant changes, and the lines before and after."""
    lines = mutmut("show", mutant).splitlines()
    before = " ".join(line[1:].strip() for line in lines if line.startswith("-") and not line.startswith("---"))
    after = " ".join(line[1:].strip() for line in lines if line.startswith("+") and not line.startswith("+++"))
    return mutant.split("__mutmut_")[0].replace(".x_", ".", 1), before, after


def as_markdown(rows: dict[str, Counter[str]]) -> str:
    """The table."""
    lines = ["# Mutations", "", "`make mutation`, changes of one place at a time:", ""]
    lines += ["| module | changes | noticed | change nothing | not explained | not run |", "|---|---|---|---|---|---|"]
    for module, row in [*sorted(rows.items()), ("together", sum(rows.values(), Counter()))]:
        counts = [row.total(), *(row[name] for name in ("killed", "explained", "not explained", "not run"))]
        lines.append(f"| {module} | {' | '.join(map(str, counts))} |")
    return "\n".join([*lines, ""])


def main() -> int:
    """Run, print the table, say what is not explained."""
    mutmut("run", "--max-children", "1")
    explained = {
        (one["function"], one["before"], one["after"]): one["why"]
        for one in tomllib.loads(EXPLAINED.read_text(encoding="utf-8"))["mutant"]
    }
    rows: dict[str, Counter[str]] = {}
    unexplained, unused = [], set(explained)
    for mutant, status in statuses().items():
        row = rows.setdefault(".".join(mutant.split("__mutmut_")[0].split(".")[1:-1]), Counter())
        if status in KILLED or status is None:
            row["not run" if status is None else "killed"] += 1
            continue
        key = change(mutant)
        row["explained" if key in explained else "not explained"] += 1
        unused.discard(key)
        if key not in explained:
            unexplained.append((mutant, status, key))
    TABLE.write_text(as_markdown(rows), encoding="utf-8")
    print("\n" + TABLE.read_text(encoding="utf-8"))
    for mutant, status, (_, before, after) in unexplained:
        print(f"{mutant} (exit status {status}):\n    - {before}\n    + {after}")
    for function, before, after in sorted(unused):
        print(f"explained, but noticed or gone: {function}: {before} -> {after}")
    return 1 if unexplained or unused or any(row["not run"] for row in rows.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
