"""How platoons with dead time, lag, lengths and drivers who are not ours fare; prints the tables of the road page.

`python -m benchmarks.road TABLE [--recording FILE] [--starts 20] [--T 0.05]`, with TABLE one of `leaders`,
`feedforward`, `radar`, `groups`, `paper`, `closing`, `human`, `cut_in`, `truck`, `certificates`, or `all`.  FILE is a
recording of OpenACC (European Commission, Joint Research Centre), columns Time and Speed1: the first car leads.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from psp_model import BEST_FIXED, PlatoonParameters, PotentialParameters, StartDomain, feedback, largest_period
from psp_model.law.cooperation import Cooperation
from psp_model.parameters import Actuation
from psp_model.sampling.exact import exact_period
from psp_model.sampling.hold import advance
from psp_model.vehicles.actuation import Actuators, at_rest, drive
from psp_model.vehicles.delayed import Delayed, DelayedVehicles
from psp_model.vehicles.leader import Wave
from psp_model.vehicles.membership import of_members, rearranged
from psp_model.vehicles.road_law import RoadLaw
from psp_model.vehicles.road_run import RoadRun, Sensing, run_on_road, started

Batch = NDArray[np.float64]
CONSTANTS = PlatoonParameters()
FOLLOWERS = 6
DELAY, LAG, AGE = 0.2, 0.2, 0.1  # [s]
LIMITS = {"a_min": -8.0, "a_max": 4.0}  # [m/s2]
TRUE = Actuation(DELAY, LAG, **LIMITS)
IDEAL = Actuation(0.0, 0.0, **LIMITS)
FULL = Cooperation(kappa=1.0)
TODAY = Cooperation(feedforward=0.0)
RADAR = PotentialParameters(1e-2, 12.0, 4.0)
TRUCK = 16.5  # [m]


@dataclass(frozen=True)
class Setting:
    """What all tables have in common.

    Attributes
    ----------
    starts : how many
    T : sampling period [s]
    recording : file of a recorded leader, None for none
    """

    starts: int
    T: float
    recording: Path | None

    @property
    def old(self) -> int:
        """The age of what is measured, in sampling periods."""
        return round(AGE / self.T)


def leaders(setting: Setting) -> dict[str, Batch]:
    """Speeds of foreign leaders at the sampling instants [m/s]."""
    T = setting.T

    def at(speed: Callable[[float], float], duration: float) -> Batch:
        return np.array([speed(k * T) for k in range(round(duration / T) + 1)])

    def stop(b: float) -> Batch:
        return at(lambda t: max(30.0 - b * max(t - 10.0, 0.0), 0.0), 20.0 + 30.0 / b)

    found = {"wave": at(Wave(30.0, 14.0).speed, 100.0)}
    if setting.recording is not None:
        rows = np.genfromtxt(setting.recording, delimiter=",", skip_header=1)
        time, speed = rows[:, 0], rows[:, 1]
        for name, begin, end in (("recorded, 51 to 701 s", 51.0, 701.0), ("recorded, 1241 to 1891 s", 1241.0, 1891.0)):
            found[name] = at(lambda t, begin=begin: float(np.interp(begin + t, time, speed)), end - begin)  # type: ignore[misc]
    found["sine 0.2 Hz"] = at(lambda t: 25.0 + np.sin(2 * np.pi * 0.2 * max(t - 10.0, 0.0)), 70.0)
    for b in (2.5, 6.0, 8.0):
        found[f"{b:g} m/s2 to standstill"] = stop(b)
    return found


def behind(
    setting: Setting, speed: float, lowest: float, highest: float, n: int = FOLLOWERS + 1
) -> tuple[Batch, Batch]:
    """Starts at the speed of the leader, with clearances between two bounds [m]."""
    rng = np.random.default_rng(1)
    s = CONSTANTS.L + rng.uniform(lowest, highest, (n - 1, setting.starts))
    return s, np.full((n, setting.starts), speed)


def believed(share: float) -> Actuation:
    """What a controller is told of dead time and lag, as a share of the truth."""
    return replace(TRUE, actuation_delay=share * DELAY, actuator_lag=share * LAG)


def trial(
    setting: Setting,
    law: RoadLaw,
    actuation: Actuation,
    speed: Batch,
    clearance: tuple[float, float],
    sensing: Sensing,
) -> RoadRun:
    """A platoon behind a leader."""
    plant = DelayedVehicles(actuation)
    run = started(plant, *behind(setting, speed[0], *clearance))
    law = replace(law, T=setting.T, oldest=sensing.periods_old * setting.T)
    return run_on_road(run, law, actuation, None, {0: speed}, speed.size - 1, sensing)


def shown(run: RoadRun) -> str:
    """Least clearance, gain of the last over the leader and over the first follower; or how many touch."""
    if run.touched.any():
        return f"{run.touched.sum()} of {run.touched.size} touch"
    return f"{run.least.min():.2f} m, {run.gain(-1, 0):.2f}, {run.gain(-1, 1):.2f}"


def table(title: str, columns: list[str], rows: Mapping[str, list[str]]) -> None:
    """Print a table in Markdown."""
    print(f"\n{title}\n\n| | " + " | ".join(columns) + " |\n|" + "---|" * (len(columns) + 1))
    for name, cells in rows.items():
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


def leaders_table(setting: Setting) -> None:
    """Behind foreign leaders, with what the controller believes, and with noise."""
    old, rows = setting.old, {}
    cases: dict[str, tuple[RoadLaw, Actuation, Sensing]] = {
        "today, ideal": (RoadLaw(BEST_FIXED, CONSTANTS, TODAY, IDEAL), IDEAL, Sensing()),
        "today, delayed": (RoadLaw(BEST_FIXED, CONSTANTS, TODAY, IDEAL), TRUE, Sensing(old)),
    }
    for share in (1.0, 0.7, 1.3):
        law = RoadLaw(BEST_FIXED, CONSTANTS, FULL, believed(share))
        cases[f"believed {share:g}"] = law, TRUE, Sensing(old)
    law = RoadLaw(BEST_FIXED, CONSTANTS, FULL, TRUE)
    cases["noise 0.1 m, 0.1 m/s"] = law, TRUE, Sensing(old, 0.1, 0.1)
    cases["mu 1"] = replace(law, constants=replace(CONSTANTS, mu=1.0)), TRUE, Sensing(old)
    for name, speed in leaders(setting).items():
        rows[name] = [shown(trial(setting, *case[:2], speed, (7.0, 11.0), case[2])) for case in cases.values()]
    table("Least clearance, head to tail, last over first follower", list(cases), rows)


def feedforward_table(setting: Setting) -> None:
    """What the gain of the feed-forward does."""
    gains, rows = (1.0, 0.9, 0.8, 0.6, 0.4), {}
    for name, speed in leaders(setting).items():
        laws = [RoadLaw(BEST_FIXED, CONSTANTS, replace(FULL, feedforward=gain), TRUE) for gain in gains]
        rows[name] = [shown(trial(setting, law, TRUE, speed, (7.0, 11.0), Sensing(setting.old))) for law in laws]
    table("Gain of the feed-forward", [f"{gain:g}" for gain in gains], rows)


def radar_table(setting: Setting) -> None:
    """Nothing is communicated; and with the leader's speed, but not his acceleration, communicated."""
    gaps, rows = (0.6, 1.0, 1.4), {}
    sensing = Sensing(setting.old, known=False)
    for name, speed in leaders(setting).items():
        rows[name] = []
        for gap in gaps:
            at = gap * speed[0]
            radar = Cooperation(kappa=1.0, time_gap=gap, following=2, feedforward=0.0)
            law = RoadLaw(RADAR, CONSTANTS, radar, TRUE)
            rows[name].append(shown(trial(setting, law, TRUE, speed, (at + 7.0, at + 11.0), sensing)))
        told = Cooperation(kappa=2.0, time_gap=0.6, feedforward=0.0)
        law = RoadLaw(RADAR, CONSTANTS, told, TRUE)
        rows[name].append(
            shown(trial(setting, law, TRUE, speed, (0.6 * speed[0] + 7.0, 0.6 * speed[0] + 11.0), sensing))
        )
    table("Radar only", [f"time gap {gap:g} s" for gap in gaps] + ["speed communicated, 0.6 s, kappa 2"], rows)


def groups_table(setting: Setting) -> None:
    """The least clearance of 5 starts, over 40 such groups: what `leaders` and `radar` give depends on the starts."""
    many, rows = replace(setting, starts=200), {}
    radar = RoadLaw(RADAR, CONSTANTS, Cooperation(kappa=1.0, time_gap=1.0, following=2, feedforward=0.0), TRUE)
    cases = {f"believed {share:g}": RoadLaw(BEST_FIXED, CONSTANTS, FULL, believed(share)) for share in (1.0, 0.7, 1.3)}
    for name, speed in leaders(many).items():
        rows[name] = []
        for law in (*cases.values(), radar):
            at = law.cooperation.time_gap * speed[0]
            sensing = Sensing(many.old, known=law is not radar)
            run = trial(many, law, TRUE, speed, (at + 7.0, at + 11.0), sensing)
            least = run.least.min(axis=0).reshape(40, 5).min(axis=1)
            low, middle, high = np.quantile(least, [0.1, 0.5, 0.9])
            rows[name].append(f"{middle:.2f} m ({low:.2f} to {high:.2f})")
    title = "Least clearance of 5 starts: median, and 10 to 90 % of 40 groups"
    table(title, [*cases, "radar only, time gap 1 s"], rows)


def hopeless(s: Batch, v: Batch, actuation: Actuation) -> NDArray[np.bool_]:
    """Starts in which two vehicles touch even if one brakes and the one ahead drives off as they can."""
    least = np.full(v.shape[1], np.inf)
    for t in np.linspace(0.02, 3.0, 150):
        moved = []
        for row, command in ((v[:-1], actuation.a_max), (v[1:], actuation.a_min)):
            still = 0.0 * row
            actuators = Actuators(still, still, ((actuation.actuation_delay, still + command),))
            moved.append(drive(row, actuators, actuation, float(t))[1])
        least = np.minimum(least, (s - CONSTANTS.L + moved[0] - moved[1]).min(axis=0))
    return least <= 0.0


def paper_table(setting: Setting) -> None:
    """The paper's starts, all automated, with and without the predictor."""
    rows, rng = {}, np.random.default_rng(2)
    s, v = StartDomain().draw(rng, 7, setting.starts)
    for delay, lag in ((0.1, 0.1), (0.2, 0.2), (0.3, 0.3), (0.3, 0.5), (0.5, 0.3), (0.5, 0.5)):
        true = Actuation(delay, lag, **LIMITS)
        lost = hopeless(s, v, true)
        cells = [f"{lost.sum()} of {lost.size}"]
        for kappa, share in ((0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 0.7), (1.0, 1.0), (1.0, 1.3)):
            told = Actuation(share * delay, share * lag, **LIMITS)
            law = RoadLaw(BEST_FIXED, CONSTANTS, Cooperation(kappa=kappa), told, setting.T)
            run = run_on_road(started(DelayedVehicles(true), s, v), law, true, None, {}, round(20.0 / setting.T))
            touched, least = (run.touched & ~lost).sum(), run.least[:, ~lost].min()
            cells.append(f"{touched} touch" if touched else f"{least:.2f} m")
        rows[f"{delay:g} s, {lag:g} s"] = cells
    columns = ["touch under any law", "kappa 0, no predictor", "predictor", "kappa 1, no predictor"]
    columns += [f"believed {share:g}" for share in (0.7, 1.0, 1.3)]
    table("The paper's starts, 20 s: least clearance of the others, or how many of them touch", columns, rows)


def closing_table(setting: Setting) -> None:
    """From spacings of 38 to 48 m."""
    rows, rng, T = {}, np.random.default_rng(3), setting.T
    s, v = rng.uniform(38, 48, (6, setting.starts)), np.full((7, setting.starts), 27.0)
    for name, actuation in (("ideal", IDEAL), ("delayed", TRUE)):
        law = RoadLaw(BEST_FIXED, replace(CONSTANTS, v_star=27.0), Cooperation(closing_speed=0.6), actuation, T)
        run, after, end = started(DelayedVehicles(actuation), s, v), np.inf, 0.0
        for second in range(1, 121):
            run_on_road(run, law, actuation, None, {}, round(1.0 / T))
            if run.vehicles.s.max() <= 20.0 and after == np.inf:
                after = second
            if second == 60:
                end = run.vehicles.s.max()
        rows[name] = [f"{after:g} s", f"{end:.1f} m", f"{run.largest.max():.2f} m/s2", f"{run.least.min():.2f} m"]
    table(
        "Closing up",
        ["all at most 20 m after", "largest after 60 s", "largest acceleration", "least clearance in 120 s"],
        rows,
    )


def human_table(setting: Setting) -> None:
    """A human in the middle brakes to some speed, and drives off again."""
    rows, T = {}, setting.T
    for low in (20.0, 10.0, 0.0):
        cells = []
        for b in (2.5, 6.0):
            time = np.arange(round(60.0 / T) + 1) * T
            speed = np.minimum(np.maximum(27.0 - b * np.maximum(time - 5, 0), low) + 2 * np.maximum(time - 30, 0), 27.0)
            law = RoadLaw(BEST_FIXED, replace(CONSTANTS, v_star=27.0), FULL, TRUE, T, AGE)
            run = started(DelayedVehicles(TRUE), *behind(setting, 27.0, 7.0, 11.0))
            run = run_on_road(run, law, TRUE, None, {3: speed}, time.size - 1, Sensing(setting.old))
            cells.append(shown_least(run))
        rows[f"to {low:g} m/s"] = cells
    table("A human in place 4 of 7", ["brakes with 2.5 m/s2", "6 m/s2"], rows)


def shown_least(run: RoadRun) -> str:
    """Least clearance and largest acceleration of the automated; or how many touch."""
    touch = f"{run.touched.sum()} of {run.touched.size} touch"
    return touch if run.touched.any() else f"{run.least.min():.2f} m, {run.largest.max():.1f} m/s2"


def cut_in_table(setting: Setting) -> None:
    """A car cuts in 8 m ahead, bumper to bumper, at 3 m/s less than the rest."""
    rows, T, n = {}, setting.T, FOLLOWERS
    law = RoadLaw(BEST_FIXED, replace(CONSTANTS, v_star=27.0), FULL, TRUE, T, AGE)
    for place in (0, 3):
        cells = []
        for clearance in (8.0, 6.0, 4.0):
            run = started(DelayedVehicles(TRUE), *behind(setting, 27.0, 20.0, 24.0, n))
            run = run_on_road(run, law, TRUE, None, {}, round(2.0 / T), Sensing(setting.old))
            members: list[int | None] = list(range(n))
            members.insert(place, None)
            past = [(*joined(s, v, place, clearance, 24.0), np.zeros((n + 1, 1))) for s, v, _ in run.past]
            s, v = joined(run.vehicles.s, run.vehicles.v, place, clearance, 24.0)
            memory = None if run.memory is None else rearranged(run.memory, members, v)
            actuators = at_rest(v) if memory is None else of_members(run.vehicles.actuators, members)
            after = started(DelayedVehicles(TRUE), s, v)
            after.vehicles, after.memory = Delayed(0.0, s, v, actuators), memory
            after.past.extend(past)
            speed = np.full(round(30.0 / T) + 1, 24.0)
            after = run_on_road(after, law, TRUE, None, {place: speed}, speed.size - 1, Sensing(setting.old))
            cells.append(shown_least(after))
        rows[f"in place {place + 1}"] = cells
    table("A car cuts in at 3 m/s less", ["8 m ahead", "6 m", "4 m"], rows)


def joined(s: Batch, v: Batch, place: int, clearance: float, speed: float) -> tuple[Batch, Batch]:
    """Spacings and speeds with a car more, so far ahead of the one whose place it takes."""
    ahead = np.full((1, s.shape[1]), clearance + CONSTANTS.L)
    if place == 0:
        spacing = np.concatenate([ahead, s])
    else:
        spacing = np.concatenate([s[: place - 1], s[place - 1 : place] - ahead, ahead, s[place:]])
    return spacing, np.insert(v, place, speed, axis=0)


def truck_table(setting: Setting) -> None:
    """A truck among cars, behind a wave, told its length or not."""
    rows, n = {}, FOLLOWERS + 1
    for name, place in (("leading", 0), ("in the middle", 3), ("last", 6)):
        length = np.full((n, 1), CONSTANTS.L)
        length[place] = TRUCK
        cells = []
        for told in (length, None):
            law = RoadLaw(BEST_FIXED, CONSTANTS, replace(FULL, length=told), TRUE, setting.T, AGE)
            speed = leaders(replace(setting, recording=None))["wave"]
            s, v = behind(setting, speed[0], 7.0, 11.0)
            run = started(DelayedVehicles(TRUE), s + (length[:-1] - CONSTANTS.L), v)
            run = run_on_road(run, law, TRUE, length, {0: speed}, speed.size - 1, Sensing(setting.old))
            cells.append(shown(run))
        rows[name] = cells
    table(f"A truck of {TRUCK:g} m", ["true length given", "assumed to be a car"], rows)


def certificates_table(setting: Setting) -> None:
    """The share of the paper's starts that are certified at every sampling instant for 20 s."""
    rows, count = {}, 20 * setting.starts
    start = StartDomain().draw(np.random.default_rng(4), 7, count)
    for rate in (5, 10, 20, 50):
        (s, v), T = start, 1.0 / rate
        lemma, exact, ratio = np.ones(count, dtype=bool), np.ones(count, dtype=bool), []
        with np.errstate(all="ignore"):
            for _ in range(20 * rate):
                a = feedback(s, v, BEST_FIXED, CONSTANTS)
                bounds = largest_period(s, v, a, CONSTANTS), exact_period(s, v, a, CONSTANTS)
                lemma &= bounds[0] > T
                exact &= bounds[1] > T
                ratio.append(bounds[1][exact] / bounds[0][exact])
                s, v = advance(s, v, a, T)
        middle = np.median(np.concatenate(ratio)) if exact.any() else np.nan
        rows[f"{rate} Hz"] = [f"{lemma.sum()} of {count}", f"{exact.sum()} of {count}", f"{middle:.0f}"]
    table(
        "The paper's starts, 20 s, certified throughout",
        ["Lemma 1", "exact period", "median of exact over Lemma 1"],
        rows,
    )


TABLES: dict[str, Callable[[Setting], None]] = {
    "leaders": leaders_table,
    "feedforward": feedforward_table,
    "radar": radar_table,
    "groups": groups_table,
    "paper": paper_table,
    "closing": closing_table,
    "human": human_table,
    "cut_in": cut_in_table,
    "truck": truck_table,
    "certificates": certificates_table,
}

BEHAVIOUR = {name: TABLES[name] for name in ("closing", "human", "cut_in", "truck")}
"""Tables in which nobody touches."""


def main() -> None:
    """Print tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("table", choices=[*TABLES, "all"])
    parser.add_argument("--recording", type=Path)
    parser.add_argument("--starts", type=int, default=20)
    parser.add_argument("--T", type=float, default=0.05)
    given = parser.parse_args()
    setting = Setting(given.starts, given.T, given.recording)
    for name in TABLES if given.table == "all" else [given.table]:
        TABLES[name](setting)


if __name__ == "__main__":
    main()
