"""What happens to the platoon when a vehicle merges into it, and when one asks for too small a spacing?"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from fmpy import simulate_fmu


def requests() -> Any:
    """The inputs over time: a vehicle wants in 5.2 m behind the second at 5 s, another one 15 m behind it at 10 s."""
    inputs = [
        ("time", "insert", "insert_behind", "insert_gap", "insert_speed", "remove", "remove_place"),
        (0.0, 0, 2, 5.2, 30, 0, 1),
        (5.0, 1, 2, 5.2, 30, 0, 1),
        (6.0, 0, 2, 15.0, 30, 0, 1),
        (10.0, 1, 2, 15.0, 30, 0, 1),
        (15.0, 1, 2, 15.0, 30, 1, 1),  # the leader leaves
    ]
    names, *rows = inputs
    return np.array(rows, dtype=[(name, float) for name in names])


def main(fmu: str = "dist/PspPlatoon.fmu") -> Any:
    """Three vehicles 30 m apart, room for more; fmpy's result comes back."""
    result = simulate_fmu(
        fmu,
        stop_time=20.0,  # [s]
        output_interval=0.1,  # [s]
        start_values={"n_start": 3, "parameter_source": 2, "s_start[2]": 30.0, "s_start[3]": 30.0, "lemma1_policy": 3},
        input=requests(),
        output=["n_active", "change_ok", "gap_offered", "vehicle[1]", "vehicle[3]", "s[2]", "s[3]", "s[4]", "T_max"],
    )
    for time in (4.9, 5.5, 10.5, 19.9):
        row = result[np.argmin(abs(result["time"] - time))]
        numbers = f"{row['n_active']:.0f} vehicles, {row['vehicle[1]']:.0f} leads, spacing 3 is {row['s[3]']:.2f} m"
        refused = "" if row["change_ok"] else f"; refused, {row['gap_offered']:.2f} m would do"
        print(f"t = {time} s: {numbers}{refused}")
    return result


if __name__ == "__main__":
    main(*sys.argv[1:])
