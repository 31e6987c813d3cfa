"""Lemma 1 against the truth: when a spacing reaches L or a speed leaves [0, v_max] while the accelerations are held.

Within a sampling period spacings are parabolas and speeds straight lines, so that time is a closed form.  A certified
period (T < T_max) must end before it; how much later it comes says how conservative the lemma is.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from psp_model import BEST_FIXED, V_OLD, PlatoonParameters, StartDomain
from psp_model.law.feedback import feedback
from psp_model.sampling.hold import advance
from psp_model.sampling.lemma1 import largest_period

from .starts import Array, Lanes, draw
from .trial import Chunk, Outcome

_PER_DECADE, _DECADES = 50, 8  # bins of the histogram of the ratio
_KINDS = {"anywhere in Omega": "Omega", "on the paper's runs, V_new": "new", "on the paper's runs, V_old": "old"}
_LOOKS = 32  # instants within a certified period that are looked at besides


def first_exit(lanes: Lanes, a: Array) -> Array:
    """(B,) when each platoon leaves Omega while its accelerations are held [s]; infinite where never.

    Parameters
    ----------
    lanes : states, with constants
    a : (n, B) accelerations held [m/s2]
    """
    with np.errstate(all="ignore"):
        of_speeds = np.where(a > 0, (lanes.v_max - lanes.v) / a, np.where(a < 0, lanes.v / -a, np.inf))
        room, slope, curve = lanes.s - lanes.L, -np.diff(lanes.v, axis=0), -0.5 * np.diff(a, axis=0)
        root = np.sqrt(slope * slope - 4.0 * curve * room)  # NaN where the spacing never reaches L
        q = -0.5 * (slope + np.copysign(root, slope))
        times = np.stack([q / curve, room / q])
    times = np.where(times > 0, times, np.inf)  # false for NaN too
    return np.minimum(of_speeds.min(axis=0), times.min(axis=(0, 1)))


def goes_wrong(lanes: Lanes, lane: int, a: Array, T: float) -> bool:
    """Whether a platoon leaves Omega within T, in exact arithmetic.

    Parameters
    ----------
    lanes, lane, a : which platoon, and all accelerations
    T : period [s]
    """
    s, v, held = ([Fraction(float(x)) for x in part[:, lane]] for part in (lanes.s, lanes.v, a))
    L, v_max, end = (Fraction(float(x)) for x in (lanes.L[lane], lanes.v_max[lane], T))
    if any(not 0 <= speed + end * push <= v_max for speed, push in zip(v, held, strict=True)):
        return True
    for i, spacing in enumerate(s):
        slope, curve = v[i] - v[i + 1], (held[i] - held[i + 1]) / 2
        times = [end] + ([-slope / (2 * curve)] if curve > 0 and 0 < -slope / (2 * curve) < end else [])
        if any(spacing + t * (slope + t * curve) <= L for t in times):
            return True
    return False


def _judge(lanes: Lanes, kind: str, outcome: Outcome) -> None:
    a = feedback(lanes.s, lanes.v, lanes.shape, lanes)
    T_max = largest_period(lanes.s, lanes.v, a, lanes)
    exit_ = first_exit(lanes, a)
    certified = T_max > 0  # at a speed of exactly 0 or v_max nothing is certified only where a points outwards
    outcome.count += T_max.size
    outcome.tally(f"{kind}: not certifiable", (~certified).sum())
    for lane in np.flatnonzero(exit_ < T_max):  # rounding, or worse: exact arithmetic decides
        if goes_wrong(lanes, lane, a, float(np.nextafter(T_max[lane], 0.0))):
            outcome.violate(f"T_max = {T_max[lane]!r} s, but the platoon leaves Omega at {exit_[lane]!r} s")
    late = 0.999999 * np.where(np.isfinite(T_max), T_max, 1.0)
    for share in np.arange(1, _LOOKS + 1) / _LOOKS:
        s, v = advance(lanes.s, lanes.v, a, share * late)
        inside = (s > lanes.L).all(axis=0) & (v >= 0).all(axis=0) & (v <= lanes.v_max).all(axis=0)
        for lane in np.flatnonzero(~inside & certified):
            outcome.violate(f"outside Omega after {share * late[lane]!r} s, with T_max = {T_max[lane]!r} s")
    ratio = exit_[certified & np.isfinite(exit_)] / T_max[certified & np.isfinite(exit_)]
    bins = np.clip(np.floor(_PER_DECADE * np.log10(np.maximum(ratio, 1.0))), 0, _PER_DECADE * _DECADES).astype(int)
    for place, count in zip(*np.unique(bins, return_counts=True), strict=True):
        outcome.tally(f"{kind}: bin {place}", count)


def _on_the_paper_s_runs(rng: np.random.Generator, old: bool, count: int) -> Lanes:
    """States of 7 vehicles that start in the paper's domain and drive for 0 to 5 s."""
    s, v = StartDomain().draw(rng, 7, count)
    shape = V_OLD if old else BEST_FIXED
    fields = vars(PlatoonParameters()) | vars(shape) | {"T": 0.01}
    lanes = Lanes(**{name: np.full(count, float(value)) for name, value in fields.items()}, s=s, v=v)
    until = rng.integers(0, 500, count)
    for k in range(500):
        s, v = advance(lanes.s, lanes.v, feedback(lanes.s, lanes.v, lanes.shape, lanes), 0.01)
        going = until > k
        lanes.s, lanes.v = np.where(going, s, lanes.s), np.where(going, v, lanes.v)
    return lanes


def run(chunk: Chunk) -> Outcome:
    """Four fifths anywhere in Omega, 2 to 50 vehicles, V_new and some V_old; the rest on the paper's runs."""
    outcome, rng = Outcome(), np.random.default_rng([7002, chunk.number])
    for vehicles in rng.permutation(np.arange(2, 51))[:10].tolist():
        lanes = draw(rng, vehicles, max(2, chunk.count * 2 // 25), old=bool(rng.random() < 0.2))
        _judge(lanes, "Omega", outcome)
    for old in (False, True):
        _judge(_on_the_paper_s_runs(rng, old, max(2, chunk.count // 10)), "old" if old else "new", outcome)
    return outcome


def quantiles(outcome: Outcome, kind: str, shares: tuple[float, ...]) -> list[float]:
    """Largest safe T over T_max, below which a share of the cases lies (to 5 %)."""
    prefix = f"{kind}: bin "
    bins = sorted((int(n.removeprefix(prefix)), c) for n, c in outcome.tallies.items() if n.startswith(prefix))
    places, counts = np.array(bins).T
    cumulative = np.cumsum(counts) / counts.sum()
    return [10.0 ** ((places[int(np.searchsorted(cumulative, share))] + 0.5) / _PER_DECADE) for share in shares]


def tell(outcome: Outcome) -> str:
    """For the summary."""
    parts = []
    for name, kind in _KINDS.items():
        low, middle, high = quantiles(outcome, kind, (0.05, 0.5, 0.95))
        parts.append(f"{name}: {middle:.3g} ({low:.3g} to {high:.3g})")
    return "largest safe T over T_max, median (5 % to 95 %): " + "; ".join(parts)
