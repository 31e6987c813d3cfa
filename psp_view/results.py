"""Runs from the outputs of an FMU of this project, as fmpy returns them or from a CSV file."""

from __future__ import annotations

from pathlib import Path
from typing import IO, Any

import numpy as np

from psp_model.run import Run
from psp_model.whole_file import whole_file


def run_from_result(result: Any) -> Run:
    """A run from the outputs of the FMU `PspPlatoon` or its native twin.

    Parameters
    ----------
    result : structured array with the columns time, x[1..n], s[2..n], v[1..n], a[1..n], T_max, J_acceleration, J_gap
        and lemma1_violations, as `fmpy.simulate_fmu` returns it

    Returns
    -------
    Run

    Raises
    ------
    KeyError : naming the first column that is missing
    """
    names = set(result.dtype.names)
    n = sum(name.startswith("v[") for name in names)
    wanted = {f"{letter}[{i}]" for letter in "xva" for i in range(1, n + 1)} | {f"s[{i}]" for i in range(2, n + 1)}
    wanted |= {"time", "T_max", "J_acceleration", "J_gap", "lemma1_violations"}
    if n < 2 or wanted - names:
        raise KeyError(min(wanted - names) if n >= 2 else "v[1]")

    def table(letter: str, first: int) -> Any:
        return np.column_stack([result[f"{letter}[{i}]"] for i in range(first, n + 1)])

    return Run(
        time=np.array(result["time"]),
        x=table("x", 1),
        s=table("s", 2),
        v=table("v", 1),
        a=table("a", 1),
        T_max=np.array(result["T_max"]),
        cost=np.column_stack([result["J_acceleration"], result["J_gap"]]),
        violations=int(result["lemma1_violations"][-1]),
    )


def read_csv(path: str | Path) -> Any:
    """The structured array that `fmpy.util.write_csv` or `write_csv` wrote to a file.

    Parameters
    ----------
    path : the file; names in the first line, in quotation marks or not
    """
    with open(path, encoding="utf-8") as file:
        names = [name.strip().strip('"') for name in file.readline().split(",")]
        table = np.loadtxt(file, delimiter=",", ndmin=2)
    result = np.empty(len(table), dtype=[(name, float) for name in names])
    for name, column in zip(names, table.T, strict=True):
        result[name] = column
    return result


def write_csv(path: str | Path, result: Any) -> None:
    """Write a structured array so that `read_csv` gives it back to the last bit.

    Parameters
    ----------
    path : the file; missing folders are made
    result : structured array with the column `time` first
    """
    with whole_file(Path(path)) as partial, partial.open("w", encoding="utf-8", newline="\n") as file:
        write_rows(file, result)


def write_rows(file: IO[str], result: Any) -> None:
    """Write the same to an open file.

    Parameters
    ----------
    file : open for text
    result : structured array with the column `time` first
    """
    file.write(",".join(f'"{name}"' for name in result.dtype.names) + "\n")
    for row in result:
        file.write(",".join(repr(float(value)) for value in row) + "\n")
