"""Lemma 1 and the exact period at the predicted state against the truth: late, uncertain measurements, dead time, lag.

True platoons drive by commands given before; what is measured of them is old and wrong by up to error_s and error_v;
the controller predicts from that, takes a command, and certifies a period in both ways.  During that period, which
begins when the command takes effect, the true platoon must not leave Omega.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from psp_model import BEST_FIXED, PlatoonParameters
from psp_model.law.cooperation import ALL_AUTOMATED, Cooperation
from psp_model.parameters import Actuation
from psp_model.sampling.exact import exact_period
from psp_model.sampling.uncertain import Errors, uncertain_exact_period, uncertain_period
from psp_model.vehicles.actuation import Actuators, drive
from psp_model.vehicles.prediction import Issued, predict, predictive_command
from psp_model.vehicles.ride import ride

from .trial import Chunk, Outcome

CONSTANTS = PlatoonParameters()
_LOOKS = 32  # instants within a certified period that are looked at
_BATCHES = 20  # of one dead time, age and lag each


def _commanded(rng: np.random.Generator, n: int, count: int, actuation: Actuation, age: float) -> Actuators:
    """Actuators when the measurement is taken, with commands on their way at random times."""
    due = np.sort(rng.uniform(0.0, age + actuation.actuation_delay, rng.integers(1, 6)))
    given = [rng.normal(0.0, 3.0, (n, count)) for _ in range(due.size + 2)]
    return Actuators(given[0], given[1], tuple(zip(due.tolist(), given[2:], strict=True)))


def _batch(rng: np.random.Generator, count: int, outcome: Outcome) -> None:
    n, L, v_max = int(rng.integers(2, 8)), CONSTANTS.L, CONSTANTS.v_max
    lag = 0.0 if rng.random() < 0.4 else float(rng.uniform(0.02, 0.6))
    actuation, age = Actuation(float(rng.uniform(0.0, 0.5)), lag, -8.0, 4.0), float(rng.uniform(0.0, 0.3))
    errors = Errors(float(rng.choice([0.0, 0.1, 0.5])), float(rng.choice([0.0, 0.1, 0.5])))
    s = L + rng.uniform(0.0, 1.0, (n - 1, count)) * 10.0 ** rng.uniform(-0.5, 1.7, count)
    v = np.clip(rng.uniform(-2.0, v_max + 2.0, count) + rng.normal(0.0, 2.0, (n, count)), 0.0, v_max)
    actuators = _commanded(rng, n, count, actuation, age)
    wrong_s = rng.choice([-1.0, 1.0, 0.3], s.shape) * errors.error_s
    wrong_v = rng.choice([-1.0, 1.0, 0.3], v.shape) * errors.error_v
    measured_v = np.maximum(v + wrong_v, 0.0)  # known to be inside Omega
    predicted = predict(Issued(actuators, age), s + wrong_s, measured_v, age, actuation)
    cooperation = Cooperation(kappa=1.0)
    a = np.clip(
        predictive_command(predicted, BEST_FIXED, CONSTANTS, cooperation, ALL_AUTOMATED, lag),
        actuation.a_min,
        actuation.a_max,
    )
    horizon = age + actuation.actuation_delay
    before = predicted.a if lag else a
    carried = errors.carried(horizon)
    of_command = (predicted.s, predicted.v, a, carried, CONSTANTS, before)
    T_max, T_exact = uncertain_period(*of_command), uncertain_exact_period(*of_command)
    true_v, moved, then = drive(v, actuators, actuation, horizon)
    true_s = s + moved[:-1] - moved[1:]
    off = (np.abs(true_s - predicted.s) - carried.error_s).max(), (np.abs(true_v - predicted.v) - carried.error_v).max()
    if max(off) > 1e-9:
        outcome.violate(f"the errors exceed their bounds by {off[0]!r} m and {off[1]!r} m/s")
    inside = (true_v <= v_max).all(axis=0)  # commands at random may have taken it out before
    certified = (T_max > 0.0) & inside
    outcome.count += count
    outcome.tally("not certifiable", int((~certified).sum()))
    for name, found, rounding in (("T_max", T_max, 0.0), ("T_exact", T_exact, 1e-9)):
        period = 0.999999 * np.minimum(found, 5.0)
        for share in np.arange(1, _LOOKS + 1) / _LOOKS:
            now, way, _ = ride(true_v, then.a, a, lag, share * period)
            spacing = true_s + way[:-1] - way[1:]
            good = (spacing > L - rounding).all(axis=0) & (now >= 0.0).all(axis=0) & (now <= v_max + 1e-9).all(axis=0)
            for lane in np.flatnonzero(~good & (found > 0.0) & inside):
                outcome.violate(f"outside Omega after {share * period[lane]!r} s, with {name} = {found[lane]!r} s")
    if lag == 0.0:
        exact = exact_period(true_s, true_v, a, CONSTANTS)
        known = certified & np.isfinite(exact) & (true_s > L).all(axis=0)
        ratio = exact[known] / T_max[known]
        for bound in (1.0, 2.0, 5.0, 10.0, 100.0, 1000.0):
            outcome.tally(f"exact period over T_max below {bound:g}", int((ratio < bound).sum()))
        outcome.tally("exact period over T_max known", ratio.size)


def run(chunk: Chunk) -> Outcome:
    """Platoons of 2 to 7 vehicles; dead times to 0.5 s, ages to 0.3 s, lags to 0.6 s, errors to 0.5 m and 0.5 m/s."""
    outcome, rng = Outcome(), np.random.default_rng([7113, chunk.number])
    for _ in range(_BATCHES):
        _batch(rng, max(2, chunk.count // _BATCHES), outcome)
    return outcome


def tell(outcome: Outcome) -> str:
    """For the summary."""
    known = max(outcome.tallies.get("exact period over T_max known", 0), 1)
    shares: list[Any] = []
    for bound in (2, 5, 10, 100, 1000):
        below = outcome.tallies.get(f"exact period over T_max below {bound:g}", 0)
        shares.append(f"below {bound} in {100 * below / known:.0f} %")
    return "exact period of the true platoon over T_max: " + ", ".join(shares)
