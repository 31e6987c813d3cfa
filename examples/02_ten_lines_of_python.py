"""How do I run the FMU from Python with start values of my own?"""

from __future__ import annotations

import sys
from typing import Any

from fmpy import simulate_fmu


def main(fmu: str = "dist/PspPlatoon.fmu") -> Any:
    """Run 20 s, print the first spacing at the end; fmpy's result comes back."""
    result = simulate_fmu(
        fmu,
        stop_time=20.0,  # [s]
        output_interval=0.05,  # [s] any: the FMU samples on its own clock
        start_values={"s_start[2]": 8.5, "v_start[1]": 33.0, "lemma1_policy": 1},
        output=["s[2]", "a[1]", "T_max", "J"],
    )
    print(f"spacing 2 ends at {result['s[2]'][-1]:.2f} m, J = {result['J'][-1]:.2f}")
    return result


if __name__ == "__main__":
    main(*sys.argv[1:])
