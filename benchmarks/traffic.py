"""Cost of the controller in SUMO with 1, 10, 100 platoons of 10: `python benchmarks/traffic.py [CONTROLLER.fmu]`."""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from build_fmu import main as build
from psp_traffic.driver import Driver, controllers, sumo_drivers
from psp_traffic.scale import SIZE, cost


def main(fmu: Path) -> None:
    """Print the table; steps are chosen so that every line takes about as long."""
    cacc = sumo_drivers()[2]
    new = controllers(fmu)[0]
    fixed = Driver(new.name, new.vehicle_type, fmu, {**new.parameters, "parameter_source": 2})
    print("| platoons of 10 | SUMO [%] | exchange [%] | controller [%] | kvs/s | SUMO's CACC alone, kvs/s | ratio |")
    print("|---|---|---|---|---|---|---|")
    for platoons, steps in ((1, 2000), (10, 500), (100, 100)):
        ours, theirs = cost(platoons, steps, fixed), cost(platoons, 10 * steps, cacc)
        parts = [100 * part / (ours.sumo + ours.exchange + ours.controller) for part in _parts(ours)]
        shares = " | ".join(f"{part:.0f}" for part in parts)
        print(
            f"| {platoons} | {shares} | {ours.rate:.1f} | {theirs.rate:.0f} | {ours.rate / theirs.rate:.4f} |",
            flush=True,
        )


def _parts(ours: object) -> list[float]:
    return [getattr(ours, name) for name in ("sumo", "exchange", "controller")]


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main(Path(sys.argv[1]))
    else:
        with TemporaryDirectory() as folder:
            build(["--component", "controller", "--vehicles", str(SIZE), "--output", folder])
            main(Path(folder) / "PspController.fmu")
