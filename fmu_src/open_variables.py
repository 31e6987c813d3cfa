"""The table of FMI variables of `PspOpenPlatoon`: those of `PspPlatoon`, and what joining and leaving needs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from .variables import Variable, platoon_table


def _inputs(n: int) -> Iterator[Variable]:
    yield Variable("insert", "A vehicle joins where this rises above 0.5", "1", 0.0, 0, 1, input=True)
    text = "Place of the vehicle that the new one joins behind, 1 for the leader; 0: it joins ahead of the leader"
    yield Variable("insert_behind", text, "1", float(n), 0, n, input=True)
    text = "Gap from the new vehicle to the one it joins behind or, where it becomes the leader, to the old leader"
    yield Variable("insert_gap", text, "m", 20.0, 0, nominal=10, input=True)
    yield Variable("insert_speed", "Speed of the new vehicle, at most v_max", "m/s", 30.0, 0, nominal=30, input=True)
    yield Variable("remove", "A vehicle leaves where this rises above 0.5", "1", 0.0, 0, 1, input=True)
    yield Variable("remove_place", "Place of the vehicle that leaves, 1 for the leader", "1", 1.0, 1, n, input=True)


def _outputs(n: int) -> Iterator[Variable]:
    nothing: tuple[str, ...] = ()
    start = ("n_start",)
    text = "How many vehicles there are; what belongs to the places behind them is 0"
    yield Variable("n_active", text, minimum=1, maximum=n, initial_dependencies=start)
    for i in range(1, n + 1):
        text = f"Number of the vehicle at place {i}: 1, 2, ... at the start, then in the order of joining; 0: none"
        yield Variable(f"vehicle[{i}]", text, minimum=0, initial_dependencies=start)
    text = "1 if the last change that was asked for was made, or none was, else 0"
    yield Variable("change_ok", text, minimum=0, maximum=1, initial_dependencies=nothing)
    text = "A gap at which the vehicle that was refused last could have joined, 0 if there was none"
    yield Variable("gap_offered", text, "m", minimum=0, nominal=10, initial_dependencies=nothing)
    yield Variable("changes", "Vehicles that joined or left so far", minimum=0, initial_dependencies=nothing)
    yield Variable("refusals", "Changes refused so far", minimum=0, initial_dependencies=nothing)


def open_table(capacity: int, default_source: int = 2) -> tuple[Variable, ...]:
    """The variables of `PspOpenPlatoon`.

    Parameters
    ----------
    capacity : most vehicles N, at least 2
    default_source : start value of parameter_source; 1 where there are networks

    Returns
    -------
    tuple of Variable (ours)
    """
    rows = platoon_table(capacity, default_source)
    text = "How many vehicles there are at the start: the first ones of s_start and v_start"
    start = Variable("n_start", text, start=capacity, minimum=2, maximum=capacity, integer=True)
    parameters = [row for row in rows if row.causality == "parameter"]
    outputs = [
        replace(row, initial_dependencies=(*row.initial_dependencies, "n_start")) if row.initial_dependencies else row
        for row in rows
        if row.causality == "output"
    ]
    return (*parameters, start, *_inputs(capacity), *outputs, *_outputs(capacity))
