"""The pythonfmu slave `PspOpenPlatoon`: `PspPlatoon` with vehicles that join and leave."""

from __future__ import annotations

import json
from copy import copy
from pathlib import Path
from typing import Any

import numpy as np

from psp_model.choose import choose_for_any_number
from psp_model.membership import OpenPlatoon, Refusal
from psp_model.network import ParameterNetwork
from psp_model.parameters import PotentialParameters
from psp_model.platoon import SampledPlatoon, locate
from psp_model.state import PlatoonState

from .open_variables import open_table
from .platoon_slave import PspPlatoon
from .slave_state import SlaveState, from_bytes, to_bytes
from .table_slave import logged
from .variables import Variable

_COUNTED = ("_vehicles", "_joined", "_change_ok", "_gap_offered", "_changes", "_refusals", "_insert", "_remove")


class PspOpenPlatoon(PspPlatoon):
    """The closed loop of up to N vehicles; changes take effect where a step begins."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        folder = Path(self.resources)
        self._networks = {int(n): ParameterNetwork(folder / name) for n, name in self._config["networks"].items()}
        self._heard: list[str] = []
        self._forget()

    def _speak(self) -> None:
        for sentence in self._heard:
            self._warn(sentence)
        self._heard.clear()

    def _forget(self) -> None:
        """No change was asked for yet."""
        self._vehicles: tuple[int, ...] = ()
        self._joined = self._changes = self._refusals = 0
        self._change_ok, self._gap_offered = 1.0, 0.0
        self._insert = self._remove = 0.0  # the triggers at the beginning of the last step

    def _make_table(self) -> tuple[Variable, ...]:
        return open_table(self.vehicles, self._config["default_source"])

    def _initialise(self) -> SampledPlatoon:
        n, constants, weights, sampling = self._chosen("n_start"), self._constants(), self._weights(), self._sampling()
        gaps, speeds = np.array(self._numbers("s_start", 2, n)), np.array(self._numbers("v_start", 1, n))
        start = PlatoonState(gaps, speeds, constants, self._value("x_start"))
        self._forget()
        platoon = SampledPlatoon(start, self._choose(start), weights, sampling, self._warn)
        self._speak()
        self._vehicles, self._joined = tuple(range(1, n + 1)), n
        return platoon

    def _choose(self, start: PlatoonState) -> PotentialParameters:
        """The potential for a new initial state; what it warns of is kept until that state is taken."""
        self._heard.clear()
        how = (self._request(), self._networks, self._weights(), self._sampling(), self._heard.append)
        shape, in_domain = choose_for_any_number(start.s, start.v, start.constants, *how)
        self._in_domain = float(in_domain)
        return shape

    @logged
    def do_step(self, current_time: float, step_size: float) -> bool:
        if step_size > 0.0:
            self._change(current_time)
        return bool(super().do_step(current_time, step_size))

    def _change(self, time: float) -> None:
        """Let a vehicle leave, then one join, where the triggers have risen."""
        insert, remove = self._value("insert"), self._value("remove")
        at = locate(time - self._start_time, self._value("T"))
        if remove > 0.5 >= self._remove:
            self._make(lambda road: road.remove(self._value("remove_place"), *at))
        if insert > 0.5 >= self._insert:
            wanted = [self._value(f"insert_{name}") for name in ("behind", "gap", "speed")]
            self._make(lambda road: road.insert(*wanted, *at))
        self._insert, self._remove = insert, remove

    def _make(self, change: Any) -> None:
        """Make a change or note why not."""
        assert self._platoon is not None
        in_domain = self._in_domain
        road = OpenPlatoon(self._platoon, self.vehicles, self._choose, self._vehicles, self._joined)
        refused: Refusal | None = change(road)
        self._change_ok = float(refused is None)
        if refused is None:
            self._platoon, self._vehicles, self._joined = road.platoon, road.vehicles, road.joined
            self._changes += 1
            self._speak()
            return
        self._heard.clear()
        self._in_domain = in_domain
        self._gap_offered = float(np.nan_to_num(refused.gap))
        self._refusals += 1
        self._warn(refused.sentence)

    def _refresh(self) -> None:
        if self._platoon is None:
            if not self._initialising:
                return
            self._platoon = self._initialise()
        platoon, capacity = self._platoon, self.vehicles
        seen = platoon.observe(*locate(self._time - self._start_time, platoon.sampling.T))
        motion = [
            value
            for part, size in ((seen.x, capacity), (seen.v, capacity), (seen.a, capacity), (seen.s, capacity - 1))
            for value in [*part.tolist(), *[0.0] * (size - part.size)]
        ]
        vehicles = [*self._vehicles, *[0] * (capacity - len(self._vehicles))]
        counts = (self._change_ok, self._gap_offered, self._changes, self._refusals)
        of_change = map(float, (len(self._vehicles), *vehicles, *counts))
        self._values[self._first_output :] = [*motion, *self._reported(platoon, seen.cost.tolist()), *of_change]
        self._stale = False

    # the whole state

    @logged
    def _get_fmu_state(self) -> Any:
        of_platoon = super()._get_fmu_state()
        return of_platoon, {name: copy(getattr(self, name)) for name in _COUNTED}

    @logged
    def _set_fmu_state(self, state: Any) -> None:
        super()._set_fmu_state(state[0])
        for name, value in state[1].items():
            setattr(self, name, tuple(value) if name == "_vehicles" else value)

    @staticmethod
    def _fmu_state_to_bytes(state: tuple[SlaveState, dict[str, Any]]) -> bytes:
        return json.dumps([to_bytes(state[0]).decode(), state[1]]).encode()

    @staticmethod
    def _fmu_state_from_bytes(data: bytes) -> tuple[SlaveState, dict[str, Any]]:
        of_platoon, counted = json.loads(data)
        return from_bytes(of_platoon.encode()), counted
