"""What do the paper's scenarios 1 (V_old) and 2 (V_new with the network) look like, run by the FMU from one start?"""

from __future__ import annotations

if __name__ == "__main__":  # before the imports that take time
    from psp_cli.interrupt import install

    install("01_paper_scenarios.py")

import sys
from pathlib import Path

import numpy as np
from fmpy import simulate_fmu, write_csv
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from psp_model import Run
from psp_view.results import run_from_result
from psp_view.runs import save_runs

SCENARIOS = {"V_old": {"potential": 1}, "V_new": {"potential": 2}}


def main(fmu: str = "dist/PspPlatoon.fmu", folder: str = "out") -> dict[str, Run]:
    """Run both scenarios, write their CSVs and one picture, print the table; the runs by name come back."""
    out = Path(folder)
    out.mkdir(parents=True, exist_ok=True)
    runs = {}
    for name, start_values in SCENARIOS.items():
        result = simulate_fmu(fmu, start_values=start_values, output_interval=0.01)
        write_csv(str(out / f"{name}.csv"), result)
        runs[name] = run_from_result(result)
    save_runs(runs, out / "scenarios.png", command="make simulate")
    Console().print(table(runs))
    print(f"CSV files and picture: {out}/V_old.csv, {out}/V_new.csv, {out}/scenarios.png")
    return runs


def table(runs: dict[str, Run]) -> Table:
    """The figures that the paper's two scenarios are compared by."""
    out = Table("", *runs, title="Scenario 1: V_old, scenario 2: V_new")
    rows = {
        "final spacings [m]": lambda run: f"{run.s[-1].min():.2f} .. {run.s[-1].max():.2f}",
        "smallest spacing [m]": lambda run: f"{run.s.min():.2f}",
        "peak |acceleration| [m/s2]": lambda run: f"{np.abs(run.a).max():.2f}",
        "J": lambda run: f"{run.J:.2f}",
        "J_acceleration": lambda run: f"{run.cost[-1, 0]:.2f}",
        "J_gap": lambda run: f"{run.cost[-1, 1]:.2f}",
        "smallest T_max [s]": lambda run: f"{run.T_max.min():.4f}",
    }
    for label, value in rows.items():
        out.add_row(escape(label), *(value(run) for run in runs.values()))
    return out


if __name__ == "__main__":
    main(*sys.argv[1:])
