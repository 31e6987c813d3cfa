"""All trials: the long form takes about half an hour on two cores."""

from __future__ import annotations

from . import abuse, hostile_files, lemma1_truth, many_instances, omega_runs, saved_states, ten_hours
from .trial import Trial

TRIALS = (
    Trial(
        "ten-hours",
        "ten simulated hours at T = 0.01 s: memory flat, no slow-down, no drift",
        ten_hours.run,
        chunks=2,
        count=10 * ten_hours.HOUR,
        short=4_000,
        tell=ten_hours.tell,
        limit=3600.0,
    ),
    Trial(
        "omega-runs",
        "any start of Omega, any feasible parameters, policy 3: no exit, no NaN, no stall",
        omega_runs.run,
        chunks=40,
        count=25_000,
        short=500,
        tell=omega_runs.tell,
    ),
    Trial(
        "omega-runs-old",
        "the same with V_old, outside the feasible set: no exit, no NaN; giving up with an error is allowed",
        omega_runs.run_old,
        chunks=4,
        count=5_000,
        short=49,
        tell=omega_runs.tell,
    ),
    Trial(
        "lemma1-truth",
        "no platoon leaves Omega within a period that Lemma 1 certifies",
        lemma1_truth.run,
        chunks=8,
        count=250_000,
        short=5_000,
        tell=lemma1_truth.tell,
    ),
    Trial(
        "abuse",
        "FMI calls in any order with any arguments: refused as the standard says, in a sentence, without a crash or NaN",
        abuse.run,
        chunks=16,
        count=2_000,
        short=20,
        tell=abuse.tell,
    ),
    Trial(
        "many-instances",
        "instances by the thousand, two threads, freed in a step: no leak, no disturbance, no crash",
        many_instances.run,
        chunks=8,
        count=5_000,
        short=100,
        tell=many_instances.tell,
    ),
    Trial(
        "saved-states",
        "a saved state has one future: here, in another instance, in another process; damaged or foreign ones are refused",
        saved_states.run,
        chunks=8,
        count=400,
        short=5,
        tell=saved_states.tell,
    ),
    Trial(
        "hostile-files",
        "spoiled and hostile files: one sentence, no traceback, nothing written elsewhere, no code run",
        hostile_files.run,
        chunks=12,
        count=1_500,
        short=60,
        tell=hostile_files.tell,
        limit=1800.0,
    ),
)
