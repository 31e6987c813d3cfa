"""Cost of the controller in SUMO with 1, 10, 100 platoons of 10: `python benchmarks/traffic.py [ROUNDS [FILE.json]]`.

Round after round the native controller, the Python one, nobody (vehicles are read and set, nothing is decided) and
CACC of SUMO drive the same vehicles for as many steps; figures are medians, ratios those of the rounds.
"""

from __future__ import annotations

if __name__ == "__main__":  # before the imports that take time
    from psp_cli.interrupt import install

    install("traffic.py")

import json
import sys
from pathlib import Path
from statistics import median, quantiles
from tempfile import TemporaryDirectory

from build_fmu import main as build
from psp_model.whole_file import write_whole
from psp_traffic.driver import Driver, controllers, sumo_drivers
from psp_traffic.scale import SIZE, Cost, cost

STEPS = {1: 2000, 10: 500, 100: 100}  # by number of platoons: every run takes about as long
CACC = "SUMO's CACC alone"


def drivers(folder: Path) -> dict[str, Driver]:
    """The controllers with a fixed triple, nobody, and CACC, by name."""
    found = {}
    for runtime in ("native", "python"):
        arguments = ["--component", "controller", "--runtime", runtime, "--vehicles", str(SIZE)]
        if build([*arguments, "--output", str(folder / runtime)]):
            raise SystemExit(2)
        new = controllers(next((folder / runtime).glob("*.fmu")))[0]
        found[runtime] = Driver(new.name, new.vehicle_type, new.fmu, {**new.parameters, "parameter_source": 2})
    found["nobody"] = Driver("nobody", new.vehicle_type)
    return found | {CACC: sumo_drivers()[2]}


def measure(platoons: int, rounds: int, known: dict[str, Driver]) -> dict[str, list[Cost]]:
    """What each driver cost, round by round; one round before them is thrown away."""
    found: dict[str, list[Cost]] = {name: [] for name in known}
    for number in range(-1, rounds):
        for name, driver in known.items():
            one = cost(platoons, STEPS[platoons], driver, exchange=name == "nobody")
            if number >= 0:
                found[name].append(one)
    return found


def line(platoons: int, name: str, costs: list[Cost], cacc: list[Cost]) -> dict[str, object]:
    """One line of the table."""
    ratios = [ours.rate / theirs.rate for ours, theirs in zip(costs, cacc, strict=True)]
    low, middle, high = quantiles(ratios, n=4, method="inclusive") if len(ratios) > 1 else 3 * ratios
    parts = {part: median(100 * getattr(one, part) / one.total for one in costs) for part in Cost.PARTS}
    shares = {f"{part} [%]".replace("sumo", "SUMO"): round(share) for part, share in parts.items()}
    rates = {"kvs/s": round(median(one.rate for one in costs), 1), f"{CACC}, kvs/s": round(median(map(_rate, cacc)), 1)}
    ratio = {"ratio": round(middle, 3), "quartiles": f"{low:.3f} to {high:.3f}"}
    return {"platoons of 10": platoons, "controller": name} | shares | rates | ratio


def _rate(one: Cost) -> float:
    return one.rate


def main(rounds: int = 5, output: Path | None = None) -> None:
    """Print the table, and write it to a file if one is named."""
    rows = []
    with TemporaryDirectory() as folder:
        known = drivers(Path(folder))
        for platoons in STEPS:
            found = measure(platoons, rounds, known)
            for name in list(known)[:-1]:
                rows.append(line(platoons, name, found[name], found[CACC]))
                if len(rows) == 1:
                    print("| " + " | ".join(rows[0]) + " |\n" + "|---" * len(rows[0]) + "|")
                print("| " + " | ".join(map(str, rows[-1].values())) + " |", flush=True)
    if output is not None:
        write_whole(output, json.dumps({"rounds": rounds, "steps": STEPS, "rows": rows}, indent=1) + "\n")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]), *map(Path, sys.argv[2:3]))
