"""How do I run the platoon without FMI, and which sampling period does Lemma 1 allow on the way?"""

from __future__ import annotations

from psp_model import Run, simulate


def main() -> dict[str, Run]:
    """Run four vehicles with V_old and with the network's V_new; the runs by name come back."""
    start = [9.0, 10.5, 11.0], [30.0, 31.0, 29.0, 30.5]  # spacings [m], speeds [m/s], leader first
    runs = {"V_old": simulate(start, "old"), "V_new": simulate(start, "network")}
    for name, run in runs.items():
        print(f"{name}: smallest spacing {run.s.min():.2f} m, smallest T_max {run.T_max.min():.4f} s, J = {run.J:.2f}")
    return runs


if __name__ == "__main__":
    main()
