"""The table that the long form ends with."""

from __future__ import annotations

import json
import os
import platform
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

from .trial import Outcome, Trial


def _machine() -> str:
    """Processor, cores, system and Python."""
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    model = next(
        (line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine()
    )
    return (
        f"{model}, {os.cpu_count()} cores, {platform.system()} {platform.release()}, Python {platform.python_version()}"
    )


def _commit() -> str:
    ran = subprocess.run(["git", "describe", "--always", "--dirty"], capture_output=True, text=True, check=False)
    return ran.stdout.strip() or "no checkout"


def as_markdown(trials: Sequence[Trial], totals: Mapping[str, Outcome], seconds: float) -> str:
    """The table with what goes with it.

    Parameters
    ----------
    trials, totals : what was tried, and what came of it by name
    seconds : that this run took
    """
    cases, wrong = sum(o.count for o in totals.values()), sum(o.failures for o in totals.values())
    lines = [
        "# Torture tests",
        "",
        f"`make torture`: {cases:,} cases, {wrong} violations, {seconds / 60:.0f} minutes in this run.",
        f"{_machine()}; commit {_commit()}.",
        "",
        "| trial | what must hold | cases | violations | processor time [s] | figures |",
        "|---|---|---|---|---|---|",
    ]
    for trial in trials:
        found = totals[trial.name]
        told = trial.tell(found) if found.count else "nothing came back"
        lines.append(
            f"| {trial.name} | {trial.promise} | {found.count:,} | {found.failures} | {found.seconds:.0f} | {told} |"
        )
    said = [f"- {name}: {text}" for name, found in totals.items() for text in found.violations]
    return "\n".join([*lines, *(["", "## Violations", "", *said] if said else []), ""])


def write_summary(
    trials: Sequence[Trial], totals: Mapping[str, Outcome], places: Sequence[Path], seconds: float
) -> str:
    """Write the summary as Markdown and JSON; the Markdown comes back.

    Parameters
    ----------
    trials, totals, seconds : as for `as_markdown`
    places : to write to, without endings
    """
    text = as_markdown(trials, totals, seconds)
    rows = {t.name: totals[t.name].as_dict() | {"promise": t.promise} for t in trials}
    about = {"machine": _machine(), "commit": _commit(), "seconds": seconds, "trials": rows}
    for place in places:
        place.with_suffix(".md").write_text(text)
        place.with_suffix(".json").write_text(json.dumps(about, indent=1) + "\n")
    return text
