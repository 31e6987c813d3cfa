"""Lives of controllers drawn at random: parameters, inputs good and bad, steps of any size; what came of them."""

from __future__ import annotations

from ctypes import c_double, c_uint
from math import inf, nan

import numpy as np

from harness import ERROR, OK, WARNING, Instance, Unpacked, random_start

T, N = 0.01, 7
BAD_VALUES = (nan, inf, -inf, -1.0, -0.01, 0.0, 4.9, 5.0, 35.001, 1e300)
LAW = {
    "kappa": (0.0, 1.0),
    "kappa_reach": (30.0, 12.0),
    "time_gap": (0.0, 0.6),
    "feedforward": (1.0, 0.8),
    "closing_speed": (0.0, 0.6),
    "closing_spacing": (15.0, 9.0),
    "closing_reach": (100.0, 40.0),
    "error_s": (0.0, 0.1),
    "error_v": (0.0, 0.2),
}


def settings(rng: np.random.Generator) -> dict[str, float]:
    """Parameters drawn at random, all of them good."""
    chosen = {
        "potential": int(rng.integers(1, 3)),
        "parameter_source": int(rng.integers(1, 4)),
        "rollout_horizon": 0.3,
        "lemma1_policy": int(rng.integers(1, 3)),
        "bad_input": int(rng.integers(1, 3)),
        "certificate": int(rng.integers(1, 3)),
        "a_safe": float(rng.uniform(-3.0, 0.0)),
        "max_age": float(rng.choice([1e9, 0.035])),
        "phase": float(rng.choice([0.0, 0.5 * T, 0.3 * T])),
    }
    for i in range(1, N + 1):
        chosen[f"a_min[{i}]"] = float(rng.choice([-1000.0, -8.0, -3.0]))
        chosen[f"a_max[{i}]"] = float(rng.choice([1000.0, 4.0, 1.5]))
    return chosen


def road_settings(rng: np.random.Generator) -> dict[str, float]:
    """Parameters of real vehicles drawn at random, all of them good, most of them off."""
    chosen = {name: float(rng.choice([off, off, value])) for name, (off, value) in LAW.items()}
    chosen |= {"following": int(rng.choice([1, 1, 2])), "lemma1_policy": 2, "max_age": float(rng.choice([1e9, 0.05]))}
    chosen["actuation_delay"] = float(rng.choice([0.0, 0.5, 1.0, 3.7, 20.0])) * T
    lags = (np.zeros(N), np.full(N, 0.2), rng.choice([0.0, 0.1, 0.3], N))[rng.integers(3)]
    lengths = (np.zeros(N), rng.choice([0.0, 4.0, 5.0, 8.0], N))[rng.integers(2)]
    for i in range(1, N + 1):
        chosen |= {f"actuator_lag[{i}]": float(lags[i - 1]), f"length[{i}]": float(lengths[i - 1])}
    return chosen


def inputs(rng: np.random.Generator, time: float, n: int | None = None) -> dict[str, float]:
    """Spacings, speeds and the other inputs: from the training domain, from all of the state space, or bad ones."""
    n = int(rng.choice([1, 2, 4, 6, 7, 7, 7])) if n is None else n
    if rng.random() < 0.5:
        s, v = random_start(int(rng.integers(1000)), n) if n > 1 else ([], [30.0])
    else:
        s, v = rng.uniform(5.01, 25.0, n - 1), rng.uniform(0.0, 35.0, n)
    named = {f"s[{i}]": float(spacing) for i, spacing in enumerate(s, start=2)}
    named |= {f"v[{i}]": float(speed) for i, speed in enumerate(v, start=1)}
    named |= {"n_active": float(n), "resolve": float(rng.integers(2)), "t_measured": float(rng.choice([-1.0, time]))}
    named["v_desired"] = float(rng.choice([-1.0, rng.uniform(0.0, 35.0), 0.0, 35.0, -1e-9, 35.0 + 1e-9, 1e-300]))
    for name, bound in (("s[2]", 5.0), ("s[3]", 5.0), ("v[1]", 0.0), ("v[2]", 35.0)):
        if name in named and rng.random() < 0.1:
            named[name] = bound + float(rng.choice([0.0, -1e-15, 1e-12, -1e-9, 1e-7, -1e-7]))
    if rng.random() < 0.1:
        named[str(rng.choice(list(named)))] = float(rng.choice(BAD_VALUES))
    return named


def road_inputs(rng: np.random.Generator, time: float) -> dict[str, float]:
    """Inputs on a road: older ones, few of them bad, a vehicle more or less now and then, and who drives himself."""
    named = inputs(rng, time, int(rng.choice([1, 5, 6, 6, 7, 7, 7, 7])))
    named["t_measured"] = float(rng.choice([-1.0, time, time - 0.013, time - 0.05]))
    named["a_desired"] = float(rng.choice([0.0, 0.0, rng.normal()]))
    driving = (np.ones(N), np.array([0.0] + [1.0] * (N - 1)), rng.choice([0.0, 1.0, 0.5, 0.7], N))[rng.integers(3)]
    for i in range(1, N + 1):
        named[f"automated[{i}]"] = float(driving[i - 1])
        named[f"a_measured[{i}]"] = float(rng.normal(0.0, 2.0))
        named[f"a_known[{i}]"] = float(rng.choice([1.0, 1.0, 0.0]))
    if rng.random() < 0.05:
        named[str(rng.choice(list(named)))] = float(rng.choice(BAD_VALUES))
    return named


def read(instance: Instance) -> tuple[int, list[float]]:
    """Status and values of all outputs."""
    names = [v.name for v in instance.fmu.description.modelVariables if v.causality == "output"]
    references = (c_uint * len(names))(*(instance.fmu.reference[name] for name in names))
    values = (c_double * len(names))()
    return instance.call("fmi2GetReal", references, len(names), values), list(values)


def life(
    fmu: Unpacked, seed: int, start_time: float = 0.0, road: bool = False, fixed: dict[str, float] | None = None
) -> tuple[list[int], np.ndarray, list[tuple[int, str]]]:
    """Statuses, outputs and messages of an instance that is driven at random and reset after errors."""
    rng, instance = np.random.default_rng(seed), Instance(fmu)
    drawn, fixed = road_inputs if road else inputs, fixed or {}
    held = {name: value for name, value in fixed.items() if name.startswith("a_known")}

    def told(rng: np.random.Generator, time: float) -> dict[str, float]:
        return drawn(rng, time) | held

    statuses, rows, time = [], [], None
    for _ in range(60):
        if time is None:
            time = start_time
            chosen = settings(rng) | (road_settings(rng) if road else {}) | fixed
            statuses.append(instance.initialise(told(rng, time) | chosen, start_time))
        if rng.random() < 0.7:
            statuses.append(instance.set(told(rng, time)))
        if rng.random() < 0.6 and statuses[-1] <= WARNING:
            status, values = read(instance)
            statuses.append(status)
            if status <= WARNING:
                rows.append(values)
        size = T * float(rng.choice([1.0, 1.0, 1.0, 0.25, 0.4, 2.5, 0.0]))
        statuses.append(instance.step(time, size) if statuses[-1] <= WARNING else ERROR)
        time += size
        if statuses[-1] > WARNING:
            assert instance.call("fmi2Reset") == OK
            time = None
    messages = instance.messages
    instance.close()
    return statuses, np.array(rows), messages
