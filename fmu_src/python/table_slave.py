"""What all slaves share: a table of variables, values by reference, failures as one logged sentence.

Nothing here raises: every failure is logged as one sentence with its status, and the launcher, the C library
around a slave, returns that status from the FMI call.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar
from weakref import ref

from pythonfmu.enums import Fmi2Status
from pythonfmu.fmi2slave import Fmi2Slave

from psp_model.errors import PspError
from psp_model.sampling.clock import Clock
from psp_model.sampling.policy import Sampling
from psp_model.selection.selectors import Request

from ..errors import FmiError
from ..interface.meaning import choice_of, request_of, sampling_of
from ..interface.variables import Variable
from .slave_state import SlaveState, as_json, from_json
from .surroundings import Unsuitable, one_line

CONFIG = "platoon.json"  # what build_fmu.py decided: how many vehicles, which networks
TIME_REFERENCE = 2**31 - 1  # by which the launcher asks how far a step came; hosts cannot use it
LONGEST = 1e9  # [s] T_max of a lone vehicle at rest with v_star is infinite, which importers do not accept

Result = TypeVar("Result")


def logged(call: Callable[..., Result]) -> Callable[..., Result | bool | list[float]]:
    """Turn what a call of the slave raises into one logged sentence."""

    @wraps(call)
    def guarded(self: TableSlave, *args: Any) -> Any:
        try:
            return call(self, *args)
        except Exception as error:  # a defect of the FMU must not crash the host
            self.log(str(_explained(call.__name__, error)), Fmi2Status.error)
        except BaseException as error:  # the host's, which the launcher raises there; most wait until the call is over
            self.log(str(FmiError("interrupted", call.__name__, type(error).__name__)), Fmi2Status.error)
            sys._psp_interruption = error  # type: ignore[attr-defined]
        return [0.0] * len(args[0]) if call.__name__.startswith("get_") else False

    return guarded


def _explained(call: str, error: Exception) -> PspError:
    """What a call has raised, as a sentence that names the cause."""
    if isinstance(error, PspError):
        return error
    if isinstance(error, MemoryError):
        return FmiError("memory", call)
    if isinstance(error, ImportError):
        return FmiError("import", sys.executable, call, one_line(error))
    if isinstance(error, OSError):
        return FmiError("refused", call, one_line(error))
    return FmiError("internal", call, repr(error))


@dataclass
class StateOfBytes:
    """A saved state that has come as bytes.

    Attributes
    ----------
    data : the bytes
    state : what they hold, None before they were checked
    """

    data: bytes
    state: Any = None


class TableSlave(Fmi2Slave):  # type: ignore[misc]  # pythonfmu has no types
    """A slave whose variables are the rows of a table.

    A subclass says which table (`_make_table`), what the parameters describe (`_initialise`) and its outputs
    (`_outputs`).
    """

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        resources = Path(self.resources)
        try:
            self._config: dict[str, Any] = json.loads((resources / CONFIG).read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise Unsuitable(
                f"{resources / CONFIG} cannot be read ({one_line(error)}): extract the whole FMU"
            ) from error
        self.vehicles: int = self._config["vehicles"]
        self._table = self._make_table()
        self._rows = {variable.name: variable for variable in self._table}
        self._place = {variable.name: place for place, variable in enumerate(self._table)}
        self._values: list[float] = [0.0 if row.start is None else row.start for row in self._table]
        self._first_output = next(place for place, row in enumerate(self._table) if row.start is None)
        self._clock = Clock()  # before initialisation it is at the start
        self._initialising = False
        self._part: Any = None  # what the parameters describe, made when initialisation ends or outputs are read
        self._stale = True  # the outputs in _values are not up to date
        # Real and Integer variables read last, already checked
        self._read: dict[bool, list[int]] = {False: [], True: []}

    def _make_table(self) -> tuple[Variable, ...]:
        raise NotImplementedError

    def _initialise(self) -> Any:
        """What the parameters describe, checked."""
        raise NotImplementedError

    def _outputs(self, part: Any) -> Iterable[float]:
        """Its outputs at the communication point, in the order of the table."""
        raise NotImplementedError

    def _changed(self, inputs: bool) -> None:
        """Parameters or, if `inputs`, inputs only were set."""
        if not inputs:
            self._part, self._stale = None, True

    def _refresh(self) -> None:
        """Bring the outputs in `_values` up to date; before initialisation there is nothing to show."""
        if self._part is None:
            if not self._initialising:
                return
            self._part = self._initialise()
        self._values[self._first_output :] = self._outputs(self._part)
        self._stale = False

    # parameters and inputs in, outputs out

    def _get(self, references: list[int], integer: bool) -> list[float]:
        if self._stale:
            self._refresh()
        if references != self._read[integer]:  # most hosts read the same variables in every step
            for reference in references:
                self._require_variable(reference, integer)
            self._read[integer] = list(references)
        values = self._values
        return [values[reference] for reference in references]

    def _require_variable(self, reference: int, integer: bool) -> None:
        if not (0 <= reference < len(self._table) and self._table[reference].integer is integer):
            raise FmiError("reference", reference, "Integer" if integer else "Real")

    def _set(self, references: list[int], values: list[float], integer: bool) -> None:
        inputs = True
        for reference in references:
            self._require_variable(reference, integer)
            row = self._table[reference]
            if row.input:
                continue
            inputs = False
            if reference >= self._first_output:
                raise FmiError("output", row.name)
            if self._part is not None and not self._initialising:
                raise FmiError("fixed", row.name)
        for reference, value in zip(references, values, strict=True):
            self._values[reference] = value
        self._changed(inputs)

    @logged
    def get_real(self, vrs: list[int]) -> list[float]:
        if vrs == [TIME_REFERENCE]:
            return [self._clock.time]
        return self._get(vrs, integer=False)

    @logged
    def get_integer(self, vrs: list[int]) -> list[float]:
        return [int(value) for value in self._get(vrs, integer=True)]

    @logged
    def set_real(self, vrs: list[int], values: list[float]) -> None:
        self._set(vrs, values, integer=False)

    @logged
    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        self._set(vrs, [float(value) for value in values], integer=True)

    @logged
    def setup_experiment(self, start_time: float, stop_time: float | None, tolerance: float | None) -> None:
        self._clock = Clock.begin(start_time)

    @logged
    def enter_initialization_mode(self) -> None:
        self._initialising = True

    @logged
    def exit_initialization_mode(self) -> None:
        if self._part is None:
            self._part = self._initialise()
        self._initialising, self._stale = False, True

    # time

    def _require_here(self, time: float, step_size: float) -> None:
        """The launcher's time [s] is ours: only a forged state can make them differ, or have no part to step."""
        near = abs(time - self._clock.time) <= 1e-3 + 1e-5 * step_size + 1e-9 * abs(time)
        if self._part is None or not near:
            raise FmiError("state")

    def _discard(self, error: PspError) -> bool:
        """Report that a step ended early, at a time at which a step could have succeeded; the slave's return value."""
        self.log(str(error), Fmi2Status.discard)
        return False

    # the whole state

    def _kept(self, part: Any) -> Any:
        """The saved form of the part, which later steps do not change."""
        raise NotImplementedError

    def _taken_up(self, kept: Any) -> Any:
        """The part from its saved form."""
        raise NotImplementedError

    def _restored(self, data: Any, here: Clock) -> Any:
        """The saved form, from JSON, every field checked; ValueError if no run can reach it.

        Parameters and inputs have the values of that state meanwhile.
        """
        raise NotImplementedError

    def _state(self) -> SlaveState:
        """Everything that the slave's future depends on."""
        kept = None if self._part is None else self._kept(self._part)
        return SlaveState(tuple(self._values[: self._first_output]), self._clock, self._initialising, kept)

    def _become_state(self, state: SlaveState) -> None:
        """Continue from a state."""
        self._values = [*state.values, *[0.0] * (len(self._values) - len(state.values))]
        self._clock, self._initialising, self._stale = state.clock, state.initialising, True
        self._part = None if state.part is None else self._taken_up(state.part)

    def _restore(self, data: Any) -> SlaveState:
        """The state in the JSON, every field checked; ValueError if no run can reach it."""

        def part(data: Any, values: Sequence[float], here: Clock) -> Any:
            with self._with_values(values):
                return self._restored(data, here)

        integers = [row.integer for row in self._table[: self._first_output]]
        return from_json(data, integers, part)

    @logged
    def _get_fmu_state(self) -> Any:
        return self._state()

    @logged
    def _set_fmu_state(self, state: Any) -> None:
        """Continue from a state; one that came as bytes is checked only when it is set for the first time.

        pythonfmu reads bytes without an instance, so nothing could be logged then: the launcher sets the state at once.
        """
        if isinstance(state, StateOfBytes):
            if state.state is None:
                try:
                    state.state = self._restore(json.loads(state.data))
                except Exception:  # any consequence of forged bytes
                    raise FmiError("state") from None
                return
            state = state.state
        self._become_state(state)

    @classmethod
    def _fmu_state_to_bytes(cls, state: Any) -> bytes:
        return state.data if isinstance(state, StateOfBytes) else json.dumps(as_json(state)).encode()

    @staticmethod
    def _fmu_state_from_bytes(data: bytes) -> StateOfBytes:
        return StateOfBytes(data)

    @contextmanager
    def _with_values(self, values: Sequence[float]) -> Iterator[None]:
        """A context in which parameters and inputs have other values."""
        before, self._values = self._values, [*values, *self._values[len(values) :]]
        try:
            yield
        finally:
            self._values = before

    # the meaning of the parameters

    def _value(self, name: str) -> float:
        return self._values[self._place[name]]

    def _numbers(self, name: str, first: int, last: int) -> list[float]:
        """The values of name[first] to name[last]."""
        return [self._value(f"{name}[{i}]") for i in range(first, last + 1)]

    def _chosen(self, name: str) -> int:
        """An Integer parameter, checked against the bounds in its row."""
        return choice_of(self._rows[name], self._value(name))

    def _sampling(self) -> Sampling:
        return sampling_of(self._value, self._rows)

    def _request(self) -> Request:
        return request_of(self._value, self._rows)

    @property
    def _warn(self) -> Callable[[str], None]:
        """Logs a sentence as a warning; it does not keep a freed slave and its networks in memory."""
        slave = ref(self)

        def warn(sentence: str) -> None:
            alive = slave()
            if alive is not None:
                alive.log(sentence, Fmi2Status.warning)

        return warn
