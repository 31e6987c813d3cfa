"""What predicting costs: a step of the native controller with 50 commands on their way, with lags, without any."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

from fmpy import read_model_description

from .fmus import CACHE, compiled, controller
from .registry import Context
from .rounds import Row, interleave, row
from .worker import Worker

SIZES = (7, 100)
DELAY, AGE = 0.5, 0.1  # [s] 50 commands of 0.01 s on their way; the largest age of a measurement
WITHOUT = "no prediction"


@dataclass(frozen=True)
class Case:
    """What a controller is told, and what is read of it.

    Attributes
    ----------
    parameters : Real ones by name; of arrays the value for all, or a pair in turn
    read : the first output that is read
    all_of_it : whether the outputs of its name are read, else that one alone
    """

    parameters: Mapping[str, float | tuple[float, float]]
    read: str = "a"
    all_of_it: bool = True


PREDICTED = {"actuation_delay": DELAY, "max_age": AGE}
CASES = {
    WITHOUT: Case({}),
    "no prediction, from 8 m/s2": Case({"a_min": -8.0, "a_max": 4.0}),
    "50 commands": Case(PREDICTED),
    "50 commands, one lag": Case(PREDICTED | {"actuator_lag": 0.2}),
    "50 commands, different lags": Case(PREDICTED | {"actuator_lag": (0.2, 0.3)}),
    "brake_margin": Case({"a_min": -8.0, "a_max": 4.0}, "brake_margin", False),
    "brake_margin, 50 commands, different lags": Case(
        PREDICTED | {"actuator_lag": (0.2, 0.3), "a_min": -8.0, "a_max": 4.0}, "brake_margin", False
    ),
}
PEERS = {
    "50 commands": WITHOUT,
    "50 commands, one lag": WITHOUT,
    "50 commands, different lags": WITHOUT,
    "brake_margin": "no prediction, from 8 m/s2",
    "brake_margin, 50 commands, different lags": "50 commands, different lags",
}


def told(case: Case, reference: Mapping[str, int], n: int) -> list[str]:
    """The parameters, as control_host takes them."""
    words = ["i", str(reference["parameter_source"]), "2", "i", str(reference["lemma1_policy"]), "2"]
    for name, value in case.parameters.items():
        pair = value if isinstance(value, tuple) else (value, value)
        places = [reference[name]] if name in reference else [reference[f"{name}[{i}]"] for i in range(1, n + 1)]
        for k, place in enumerate(places):
            words += ["r", str(place), str(pair[k % 2])]
    return words


def worker(n: int, name: str) -> Worker:
    """A controller that is driven."""
    case, made = CASES[name], controller(n)
    model = read_model_description(made.folder, validate=False)
    reference = {variable.name: variable.valueReference for variable in model.modelVariables}
    first = reference[f"{case.read}[1]"] if case.all_of_it else reference[case.read]
    places = map(str, (n, reference["s[2]"], reference["v[1]"], first, n if case.all_of_it else 1))
    command = [str(compiled("control_host")), *made.arguments(0.0)[:3], *places, *told(case, reference, n)]
    return Worker(command, CACHE / f"control_{n}.log")


@contextmanager
def workers(n: int) -> Iterator[dict[str, Worker]]:
    """All that is compared at one number of vehicles, by name."""
    with ExitStack() as stack:
        yield {name: stack.enter_context(worker(n, name)) for name in CASES}


def measure(context: Context) -> list[Row]:
    """All lines of this measurement."""
    rows = []
    for n in SIZES:
        context.say(f"n = {n}")
        with workers(n) as running:
            measures = {name: one.seconds for name, one in running.items()}
            found = interleave(measures, context.rounds(9), 25.0)
        for name, peer in PEERS.items():
            rows.append(row(name, f"n = {n}", peer, found[name], found[peer], "µs/step", scale=1e6))
    return rows
