"""Measures of a run: safety, comfort, capacity, emissions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .scenario import LENGTH, Scenario
from .simulation import Record

_STEADY = 10.0  # [s] the end of a run, over which spacings and capacity are averaged
_BEGINNING = 30.0  # [s] of a run behind a leader, left out of its averages and of the amplification
_JERK_WINDOW = 0.1  # [s] jerk is the change of acceleration between means over this time
_SETTLED = 0.5  # [m/s] largest distance of all speeds from v_star


@dataclass(frozen=True)
class Measures:
    """The row of one run.

    Attributes
    ----------
    collisions : pairs of vehicles that touched
    clearance_min : smallest clearance, 0 if vehicles touched [m]
    ttc_min : smallest time to collision while closing [s]
    a_peak, a_rms : of accelerations [m/s2]
    jerk_peak, jerk_rms : [m/s3]
    capacity : vehicles per hour, from the last 10 s; behind a leader, all but the first 30 s
    spacing_mean : mean spacing over the same time [m]
    settling : time after which all speeds stay within 0.5 m/s of v_star [s]; infinite if never, NaN behind a leader
    amplification : r.m.s. acceleration of the last vehicle over that of the leader, behind a leader without the first
        30 s; NaN where the leader keeps its speed
    co2, fuel : per vehicle and kilometre [g/km]
    """

    collisions: int
    clearance_min: float
    ttc_min: float
    a_peak: float
    a_rms: float
    jerk_peak: float
    jerk_rms: float
    capacity: float
    spacing_mean: float
    settling: float
    amplification: float
    co2: float
    fuel: float


def spacings(record: Record) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
    """Spacings and closing speeds on the through lane at every time.

    Parameters
    ----------
    record : of a run

    Returns
    -------
    s, closing : (K, n-1) spacings [m] and speeds at which they close [m/s], in the order of the road; NaN
        where there are fewer vehicles
    pairs : (K, n-1, 2) the two vehicles, the lower number first
    """
    x = np.where(record.on_road, record.x, -np.inf)
    order = np.argsort(-x, axis=1, kind="stable")
    x, v = np.take_along_axis(x, order, 1), np.take_along_axis(record.v, order, 1)
    there = np.isfinite(x[:, 1:])
    with np.errstate(invalid="ignore"):
        s = np.where(there, x[:, :-1] - x[:, 1:], np.nan)
    pairs = np.sort(np.stack([order[:, :-1], order[:, 1:]], axis=2), axis=2)
    return s, np.where(there, v[:, 1:] - v[:, :-1], np.nan), pairs


def measure(record: Record, scenario: Scenario) -> Measures:
    """The measures of a run.

    Parameters
    ----------
    record : of the run
    scenario : that was run
    """
    step = float(record.time[1] - record.time[0])
    s, closing, pairs = spacings(record)
    free = s - LENGTH
    with np.errstate(invalid="ignore", divide="ignore"):
        ttc = np.where((closing > 0) & (free > 0), free / closing, np.inf)
    a = np.diff(record.v, axis=0) / step
    led = scenario.leader is not None
    driven = a[:, 1:] if led else a
    window = max(round(_JERK_WINDOW / step), 1)
    whole = driven[: len(driven) // window * window]
    jerk = np.diff(whole.reshape(-1, window, whole.shape[1]).mean(axis=1), axis=0) / (window * step)
    end = record.time[-1]
    late = record.time > (min(_BEGINNING, end - _STEADY) if led else end - _STEADY)
    spacing_mean = float(np.nanmean(s[late]))
    away = np.flatnonzero((abs(record.v - scenario.v_star) > _SETTLED).any(axis=1))
    settled = 0.0 if not away.size else float(record.time[away[-1]] + step)
    settled = np.inf if settled > end else settled
    passed_on = a[late[1:]] if led else a
    leading, last = _rms(passed_on[:, 0]), scenario.v.size - 1
    kilometres = 1e-3 * (record.x[-1] - record.x[0]).sum()
    return Measures(
        collisions=len(set(map(tuple, pairs[free <= 0].tolist()))),
        clearance_min=max(float(np.nanmin(free)), 0.0),
        ttc_min=float(np.nanmin(ttc)),
        a_peak=float(abs(driven).max()),
        a_rms=_rms(driven),
        jerk_peak=float(abs(jerk).max()),
        jerk_rms=_rms(jerk),
        capacity=3600.0 * float(record.v[late].mean()) / spacing_mean,
        spacing_mean=spacing_mean,
        settling=np.nan if led else settled,
        amplification=_rms(passed_on[:, last]) / leading if leading > 0.01 else np.nan,
        co2=float(record.co2.sum() / kilometres),
        fuel=float(record.fuel.sum() / kilometres),
    )


def contact(record: Record) -> float:
    """When two vehicles on the through lane first touch [s], infinite if never.

    Parameters
    ----------
    record : of a run
    """
    touched = (spacings(record)[0] <= LENGTH).any(axis=1)
    return float(record.time[touched.argmax()]) if touched.any() else np.inf


def _rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt((values**2).mean()))
