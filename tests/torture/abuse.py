"""FMI abuse: calls in any order with any arguments, judged by the standard's table; the instance must survive them.

A session is some dozens of calls.  After each call: a function that the standard forbids in this state was refused and
changed nothing; whatever is no success was explained in one sentence; no output that was read is NaN.  After each
session: reset, and the instance runs as a fresh one does, bit for bit.
"""

from __future__ import annotations

import ctypes
import math
from ctypes import byref, c_char, c_double, c_int, c_size_t, c_uint, c_void_p
from typing import Any

import numpy as np

from .call_order import ALLOWED, LEADS_TO
from .fmus import BUILDS, Build, unpacked
from .raw import DISCARD, ERROR, FATAL, OK, WARNING, Library, Raw
from .trial import Chunk, Outcome

_CALLS = 60  # in a session
_NUMBERS = (0.0, 0.01, 1.0, 2.0, 5.0, 9.0, 20.0, 30.0, 35.0, -1.0, 1e300, -1e300, 1e-300, math.nan, math.inf, -math.inf)
_PERIODS = (0.01, 0.005, 0.1, 0.0, -0.01, math.nan, math.inf, 1e-300)
_STEPS = (0.0, 0.01, 0.005, 0.037, 0.3, 1e-9, -0.01, -1e300, 1e300, math.nan, math.inf, 1e17)
_COMMON = (
    "SetupExperiment",
    "EnterInitializationMode",
    "ExitInitializationMode",
    "DoStep",
    "DoStep",
    "GetReal",
    "SetReal",
)


class Session:
    """One instance under abuse, and what the standard says of its state.

    Parameters
    ----------
    raw : the instance
    rng : source of randomness
    outcome : that violations go into
    """

    def __init__(self, raw: Raw, rng: np.random.Generator, outcome: Outcome):
        self.raw, self.rng, self.outcome = raw, rng, outcome
        self.state, self.time = "instantiated", 0.0
        self.states: list[tuple[Any, str, float]] = []  # handles, and what they bring back
        self.bytes = b""
        self.trace: list[str] = []
        variables = {v.name: v.valueReference for v in raw.library.fmu.description.modelVariables}
        self.period = variables.get("T", -1)
        self.short = {variables[name]: 0.05 for name in ("rollout_horizon",) if name in variables}  # takes time only

    def pick(self, values: Any) -> Any:
        """One of some values."""
        return values[int(self.rng.integers(len(values)))]

    def wrong(self, what: str) -> None:
        """Note a violation with the calls that led to it."""
        name = self.raw.library.fmu.path.name
        self.outcome.violate(f"{name}: {what}; calls: {' '.join(self.trace[-12:])}; said {self.raw.messages[-2:]}")

    def step(self) -> None:
        """One call, and what it has to come to."""
        function = self.pick(_COMMON) if self.rng.random() < 0.5 else self.pick(list(ALLOWED))
        if self.state in ("error", "failed", "terminated") and self.rng.random() < 0.3:
            function = "Reset"  # or most of a session would be refusals
        self.trace.append(function)
        self.raw.messages.clear()
        allowed, before = self.state in ALLOWED[function], self.state
        status = getattr(self, f"_{function}", self._plain)(function)
        if status is None:
            return
        self.trace[-1] += f"={status}"
        self.outcome.tally("calls")
        if not OK <= status <= FATAL:
            self.wrong(f"{function} gave status {status}")
        if status == FATAL:
            self.wrong(f"{function} was fatal in state {before}")
        if not allowed:
            self.outcome.tally("refused out of order")
            named = any(function in said for said in self.raw.messages)
            quiet = function == "Terminate" and before == "error"  # only cleans up: the error has been told
            if status != ERROR or named == quiet:
                self.wrong(f"{function} in state {before} gave {status} and was not refused by name")
        elif function == "DoStep" and status == DISCARD:
            self.state = "failed"
        elif status >= ERROR:
            self.state = "error" if status == ERROR else "fatal"
        elif function in LEADS_TO and status <= WARNING:
            self.state = LEADS_TO[function]
        self._explained(function, status)

    def _explained(self, function: str, status: int) -> None:
        quiet = function in ("Terminate", "FreeFMUstate") and status == ERROR and self.state == "error"
        if status != OK and not self.raw.messages and not quiet:
            self.wrong(f"{function} gave {status} without a word")
        for said in self.raw.messages:
            if "\n" in said or "Traceback" in said or "internal error" in said or not 10 < len(said) < 600:
                self.wrong(f"{function} said {said!r}")

    # the calls; each returns the status, or None where nothing was called ---------------------------------------

    def _plain(self, function: str) -> int:
        status = self.raw.call(function)
        if function == "Reset" and status <= WARNING:
            self.time = 0.0
        return status

    def _SetDebugLogging(self, function: str) -> int:
        names = (ctypes.c_char_p * 3)(b"logAll", None, b"100%n%s")
        status = self.raw.call(function, 1, int(self.rng.integers(4)), self.pick([names, None]))
        if self.state != "fatal":
            self.raw.call(function, 1, 0, None)  # all messages again
        return status

    def _SetupExperiment(self, function: str) -> int:
        start, stop = self.pick(_NUMBERS), self.pick(_NUMBERS)
        status = self.raw.call(function, int(self.rng.integers(2)), self.pick(_NUMBERS), start, 0, stop)
        if status <= WARNING:
            self.time = start
        return status

    def _DoStep(self, function: str) -> int:
        size, begin = self.pick(_STEPS), self.time
        astray = self.rng.random() < 0.1
        if astray:
            begin += self.pick([-1.0, 1.0, -0.01, 1e9, math.nan, -math.inf])
        status = self.raw.call(function, begin, size, int(self.rng.integers(2)))
        if status <= WARNING:
            if not math.isfinite(size) or size < 0 or (astray and abs(begin - self.time) > 1e-3 + 1e-5 * size):
                self.wrong(f"a step of {size} from {begin} at {self.time} was taken")
            self.time = begin + size
        return status

    def _references(self, usual: list[int]) -> tuple[list[int], Any]:
        count = int(self.rng.integers(0, 4))
        unknown = (0xFFFFFFFF, 10**6, len(self.raw.library.reals) + len(self.raw.library.integers))
        chosen = [int(self.pick(usual if self.rng.random() < 0.93 else unknown)) for _ in range(count)]
        return chosen, (c_uint * max(count, 1))(*chosen)

    def _GetReal(self, function: str) -> int:
        usual = self.pick([self.raw.library.outputs, self.raw.library.reals])
        if self.rng.random() < 0.3:
            chosen = list(self.raw.library.outputs)
            references: Any = (c_uint * len(chosen))(*chosen)
        else:
            chosen, references = self._references(usual)
        values = (c_double * max(len(chosen), 1))()
        if self.rng.random() < 0.05:
            return self.raw.call(function, self.pick([None, references]), len(chosen) + 1, None)
        status = self.raw.call(function, references, len(chosen), values)
        outputs = set(self.raw.library.outputs)
        found = [value for place, value in zip(chosen, values, strict=False) if place in outputs]
        if status <= WARNING and self.state == "stepped" and any(map(math.isnan, found)):
            self.wrong("an output is NaN")
        return status

    def _SetReal(self, function: str) -> int:
        chosen, references = self._references(self.raw.library.settable)
        values = (c_double * max(len(chosen), 1))()
        for place, reference in enumerate(chosen):
            values[place] = self.short.get(reference, self.pick(_PERIODS if reference == self.period else _NUMBERS))
        if self.rng.random() < 0.05:
            return self.raw.call(function, None, len(chosen) + 1, values)
        return self.raw.call(function, references, len(chosen), values)

    def _GetInteger(self, function: str) -> int:
        chosen, references = self._references(self.raw.library.integers)
        return self.raw.call(function, references, len(chosen), (c_int * max(len(chosen), 1))())

    def _SetInteger(self, function: str) -> int:
        chosen, references = self._references(self.raw.library.integers)
        values = [self.pick([0, 1, 2, 3, 7, -1, 2**31 - 1, -(2**31)]) for _ in chosen]
        return self.raw.call(function, references, len(chosen), (c_int * max(len(chosen), 1))(*values))

    def _other_type(self, function: str) -> int:
        chosen, references = self._references(self.raw.library.reals)
        return self.raw.call(function, references, len(chosen), (c_void_p * max(len(chosen), 1))())

    _GetBoolean = _SetBoolean = _GetString = _SetString = _other_type

    def _derivatives(self, function: str) -> int:
        count = int(self.rng.integers(0, 2))
        return self.raw.call(function, None, count, None, None)

    _SetRealInputDerivatives = _GetRealOutputDerivatives = _derivatives

    def _GetDirectionalDerivative(self, function: str) -> int:
        one, unknowns = self._references(self.raw.library.outputs)
        other, knowns = self._references(self.raw.library.reals)
        seed, found = (c_double * max(len(other), 1))(1.0), (c_double * max(len(one), 1))()
        return self.raw.call(function, unknowns, len(one), knowns, len(other), seed, found)

    def _inquiry(self, function: str) -> int:
        return self.raw.call(function, int(self.rng.integers(-1, 6)), self.pick([byref(c_double()), None]))

    _GetStatus = _GetRealStatus = _GetIntegerStatus = _GetBooleanStatus = _GetStringStatus = _inquiry

    def _GetFMUstate(self, function: str) -> int:
        handle = c_void_p()
        status = self.raw.call(function, byref(handle))
        if status <= WARNING:
            self.states.append((handle, self.state, self.time))
        return status

    def _SetFMUstate(self, function: str) -> int:
        if not self.states or self.rng.random() < 0.1:
            return self.raw.call(function, self.pick([None, c_void_p(4242)]))
        handle, state, time = self.pick(self.states)
        status = self.raw.call(function, handle)
        if status <= WARNING:
            self.state, self.time = state, time
        return status

    def _FreeFMUstate(self, function: str) -> int:
        if not self.states or self.rng.random() < 0.1:
            return self.raw.call(function, self.pick([None, byref(c_void_p(4242))]))
        handle, _, _ = self.states.pop(int(self.rng.integers(len(self.states))))
        return self.raw.call(function, byref(handle))

    def _SerializedFMUstateSize(self, function: str) -> int:
        handle = self.states[-1][0] if self.states and self.rng.random() < 0.8 else c_void_p(4242)
        return self.raw.call(function, handle, self.pick([byref(c_size_t()), None]))

    def _SerializeFMUstate(self, function: str) -> int:
        size = c_size_t()
        if not self.states or self.raw.call("SerializedFMUstateSize", self.states[-1][0], byref(size)) > WARNING:
            return self.raw.call(function, c_void_p(4242), None, 0)
        buffer = (c_char * size.value)()
        short = int(self.rng.integers(0, size.value)) if self.rng.random() < 0.3 else size.value
        status = self.raw.call(function, self.states[-1][0], buffer, short)
        if status <= WARNING:
            self.bytes = bytes(buffer)
        return status

    def _DeSerializeFMUstate(self, function: str) -> int:
        damaged = bytearray(self.bytes or b"nothing at all")
        if self.rng.random() < 0.8:
            damaged[int(self.rng.integers(len(damaged)))] ^= 1 << int(self.rng.integers(8))
        if self.rng.random() < 0.5:
            damaged = damaged[: int(self.rng.integers(len(damaged)))]
        handle, changed = c_void_p(), bytes(damaged) != self.bytes
        status = self.raw.call(function, (c_char * max(len(damaged), 1))(*bytes(damaged)), len(damaged), byref(handle))
        if status <= WARNING and changed:
            self.wrong("a damaged state was taken")
        if status <= WARNING:
            self.raw.call("FreeFMUstate", byref(handle))
        return status


def run_on(one: Build, chunk: Chunk, outcome: Outcome) -> None:
    """Sessions on one FMU, and after each a run that must be the usual one.

    Parameters
    ----------
    one : the FMU
    chunk : how many sessions, and which
    outcome : that counts and violations go into
    """
    library = Library(unpacked(one, chunk.fmus, chunk.scratch))
    fresh = Raw(library)
    usual = fresh.usual_run()
    if not usual or not all(all(map(math.isfinite, row)) for row in usual):
        outcome.violate(f"{one.name}: a fresh instance does not run: {fresh.messages}")
    fresh.free()
    raw = Raw(library)
    rng = np.random.default_rng([7003, chunk.number, sum(map(ord, one.name))])
    for session in range(chunk.count):
        trial = Session(raw, rng, outcome)
        for _ in range(_CALLS):
            trial.step()
            if trial.state == "fatal":
                break
        outcome.count += 1
        outcome.tally(one.name)
        for handle, _, _ in trial.states:
            raw.call("FreeFMUstate", byref(handle))
        raw.messages.clear()
        if raw.call("Reset") != OK or raw.usual_run() != usual:
            trial.wrong("after a reset it does not run as a fresh instance does")
        if raw.call("Reset") != OK or session % 50 == 49 or trial.state == "fatal":
            raw.free()
            raw = Raw(library)
    raw.free()


def run(chunk: Chunk) -> Outcome:
    """One FMU after the other, a different one for each chunk."""
    outcome = Outcome()
    run_on(BUILDS[chunk.number % len(BUILDS)], chunk, outcome)
    return outcome


def run_on_all(chunk: Chunk) -> Outcome:
    """All FMUs, for the short form."""
    outcome = Outcome()
    for one in BUILDS:
        run_on(one, chunk, outcome)
    return outcome


def tell(outcome: Outcome) -> str:
    """For the summary."""
    found = outcome.tallies
    each = ", ".join(f"{name} {found[name]:,}" for name in (b.name for b in BUILDS) if name in found)
    return (
        f"{found['calls']:,} calls, {found['refused out of order']:,} of them refused as out of order; sessions: {each}"
    )
