"""All trials."""

from __future__ import annotations

from . import lemma1_truth, omega_runs
from .trial import Trial

TRIALS = (
    Trial(
        "omega-runs",
        "any start of Omega, any feasible parameters, policy 3: no exit, no NaN, no stall",
        omega_runs.run,
        chunks=40,
        count=25_000,
        short=2_000,
        tell=omega_runs.tell,
    ),
    Trial(
        "omega-runs-old",
        "the same with V_old, outside the feasible set: no exit, no NaN; giving up with an error is allowed",
        omega_runs.run_old,
        chunks=4,
        count=5_000,
        short=98,
        tell=omega_runs.tell,
    ),
    Trial(
        "lemma1-truth",
        "no platoon leaves Omega within a period that Lemma 1 certifies",
        lemma1_truth.run,
        chunks=8,
        count=250_000,
        short=20_000,
        tell=lemma1_truth.tell,
    ),
)
