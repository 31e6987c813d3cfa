"""How do I run the platoon without FMI, and which sampling period does Lemma 1 allow on the way?"""

from __future__ import annotations

from psp_model import BEST_FIXED, V_OLD, PlatoonState, Run, simulate


def main() -> dict[str, Run]:
    """Run four vehicles with V_old and with a fixed V_new; the runs by name come back."""
    start = PlatoonState([9.0, 10.5, 11.0], [30.0, 31.0, 29.0, 30.5])
    runs = {"V_old": simulate(start, V_OLD), "V_new": simulate(start, BEST_FIXED)}
    for name, run in runs.items():
        print(f"{name}: smallest gap {run.s.min():.2f} m, smallest T_max {run.T_max.min():.4f} s, J = {run.J:.2f}")
    return runs


if __name__ == "__main__":
    main()
