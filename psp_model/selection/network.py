"""The trained network that gives alpha, r, p for an initial state at once."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Mapping
from copy import copy
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import ModelError
from ..law.potential import PotentialParameters
from ..parameters import PlatoonParameters
from ..state import StartDomain
from ..validate import validate

INPUT, PARAMETERS, SCORES, DICTIONARY = "initial_condition", "parameters", "scores", "dictionary"
GAPS, SPEEDS = "gaps", "speeds"
ANY_NUMBER = "platoon_any.onnx"  # the network that serves where there is none for just that number of vehicles


def import_onnxruntime() -> Any:
    """The package onnxruntime, which neither writes into HOME nor asks the network for anything.

    From version 1.29 on it does both on Linux and macOS, unless the environment variable ORT_DISABLE_TELEMETRY is 1
    before it is imported; a value that is set already stays.

    Raises
    ------
    ModelError : where it cannot be imported
    """
    os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")
    try:
        import onnxruntime  # here, because it takes longer to import than everything else together

        _ = onnxruntime.InferenceSession, onnxruntime.SessionOptions  # which a folder left of it lacks
    except Exception as error:  # of another build, it raises whatever it likes
        why = " ".join(f"{type(error).__name__}: {error}".split())[:300]
        python = sys.executable or os.path.join(
            sys.prefix, "bin", "python3"
        )  # in a host that has started Python itself
        raise ModelError("onnxruntime", python, why, python) from None
    return onnxruntime


@lru_cache(maxsize=64)
def _open_session(content: bytes) -> Any:
    """A session for a file's content, one for all copies: an FMU that is loaded again is in another folder."""
    onnxruntime = import_onnxruntime()
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    # the further optimisations hang or crash on some files with sizes that cannot be
    options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_ENABLE_BASIC
    options.log_severity_level = 4  # what is wrong is said once, by ModelError
    return onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])


def _numbers(text: str) -> dict[str, float]:
    """Finite numbers by name, from JSON."""
    found = {name: float(value) for name, value in json.loads(text).items()}
    if not np.isfinite(list(found.values())).all():
        raise ValueError(text)
    return found


class ParameterNetwork:
    """A network in an ONNX file (paper, section IV; file format: ours, see the design).

    A network for n vehicles has the input `initial_condition`, float32 [batch, 2n-1], s_2..s_n [m] then v_1..v_n [m/s].
    A network for any number of vehicles between two bounds has the inputs `gaps`, float32 [batch, n-1], and `speeds`,
    float32 [batch, n].  Output `parameters` is float32 [batch, 3], alpha, r [m], p.  A network that also ranks
    candidates has the outputs `scores`, float32 [batch, K], and `dictionary`, float32 [K, 3].  All scaling is inside.
    The file is read when it is first needed; a pickle carries what was read, and opens it again.

    Parameters
    ----------
    path : the file

    Raises
    ------
    ModelError : from everything but the constructor, where the file is missing, unreadable or of another shape
    """

    def __init__(self, path: Path | str) -> None:
        self.path = Path(path)
        self._content: bytes | None = None  # of the file, once it was found in order

    def __getstate__(self) -> dict[str, Any]:
        return {"path": self.path, "_content": self._content}

    def __copy__(self) -> ParameterNetwork:
        made = ParameterNetwork(self.path)
        vars(made).update(vars(self))  # the session, too, which nothing changes
        return made

    def __deepcopy__(self, memo: dict[int, Any]) -> ParameterNetwork:
        return copy(self)

    @cached_property
    def _session(self) -> Any:
        try:
            content = self.path.read_bytes() if self._content is None else self._content
        except OSError as error:
            raise ModelError("network_missing", self.path.name, error.strerror) from None
        import_onnxruntime()
        try:
            session = _open_session(content)
        except Exception:  # onnxruntime raises a class of its own for every kind of damage
            raise ModelError("network_damaged", self.path.name) from None
        self._require_shapes(session)
        self._content = content
        return session

    def _require_shapes(self, session: Any) -> None:
        inputs = {port.name: port.shape[1:] for port in session.get_inputs()}
        outputs = {port.name: port.shape[1:] for port in session.get_outputs()}
        columns = inputs.get(INPUT, [None])[-1]
        exact = list(inputs) == [INPUT] and isinstance(columns, int) and columns >= 3 and columns % 2 == 1
        open_ended = all(len(sizes) == 1 and not isinstance(sizes[0], int) for sizes in inputs.values())
        free = set(inputs) == {GAPS, SPEEDS} and open_ended
        if not (exact or free) or outputs.get(PARAMETERS) != [3]:
            raise ModelError("network_shape", self.path.name, str(inputs), str(outputs))

    @cached_property
    def _columns(self) -> int | None:
        """Width of `initial_condition`; None of a network for any number of vehicles."""
        return {port.name: port.shape[1] for port in self._session.get_inputs()}.get(INPUT)

    @cached_property
    def _metadata(self) -> dict[str, Any]:
        """The metadata, with the JSON of what the model needs."""
        entries = self._session.get_modelmeta().custom_metadata_map
        names = ("psp_vehicles", "psp_vehicles") if self._columns else ("psp_vehicles_min", "psp_vehicles_max")
        try:
            return {
                "vehicles": range(int(entries[names[0]]), int(entries[names[1]]) + 1),
                "domain": StartDomain(**_numbers(entries["psp_domain"])),
                "constants": validate(PlatoonParameters(**_numbers(entries["psp_constants"]))),
            }
        except (AttributeError, KeyError, TypeError, ValueError, ArithmeticError, RecursionError):
            raise ModelError("network_metadata", self.path.name) from None

    @property
    def vehicles(self) -> range:
        """The numbers of vehicles that the network is for."""
        vehicles: range = self._metadata["vehicles"]
        return vehicles

    @property
    def domain(self) -> StartDomain:
        """The starts it was trained on."""
        domain: StartDomain = self._metadata["domain"]
        return domain

    @property
    def constants(self) -> PlatoonParameters:
        """The constants it was trained with."""
        constants: PlatoonParameters = self._metadata["constants"]
        return constants

    @property
    def trained_on(self) -> str:
        """Content hashes of the data sets it was trained on; empty where the file does not say."""
        return str(self._session.get_modelmeta().custom_metadata_map.get("psp_data_sha256", ""))

    @property
    def ranks(self) -> bool:
        """Whether it ranks candidates for a start."""
        return {SCORES, DICTIONARY} <= {port.name for port in self._session.get_outputs()}

    def require_vehicles(self, vehicles: int) -> None:
        """Check that the network is for this many vehicles.

        Parameters
        ----------
        vehicles : n

        Raises
        ------
        ModelError : where it is not
        """
        made_for = self.vehicles
        if self._columns is None and vehicles not in made_for:
            raise ModelError("network_range", self.path.name, made_for.start, made_for.stop - 1, vehicles)
        if self._columns and (vehicles not in made_for or self._columns != 2 * vehicles - 1):
            raise ModelError("network_vehicles", self.path.name, (self._columns + 1) // 2, vehicles)

    def _run(self, outputs: list[str], s: ArrayLike, v: ArrayLike) -> list[Any]:
        self.require_vehicles(np.size(v))
        spacings, speeds = (np.asarray(part, dtype=np.float32)[None, :] for part in (s, v))
        inputs = (
            {INPUT: np.concatenate([spacings, speeds], axis=1)} if self._columns else {GAPS: spacings, SPEEDS: speeds}
        )
        try:
            found = list(self._session.run(outputs, inputs))
        except Exception:  # onnxruntime's own: a graph that contradicts its shapes
            raise ModelError("network_damaged", self.path.name) from None
        sizes = [(1, 3), (1, len(found[2])), (len(found[2]), 3)] if len(found) == 3 else [(1, 3)]
        if [np.shape(part) for part in found] != sizes:
            raise ModelError("network_damaged", self.path.name)
        return found

    def evaluate(self, s: ArrayLike, v: ArrayLike) -> PotentialParameters:
        """What the network returns for a start, before projection (paper, section IV).

        Parameters
        ----------
        s : (n-1,) array, spacings [m]
        v : (n,) array, speeds [m/s]

        Returns
        -------
        the triple

        Raises
        ------
        ModelError : where the file is at fault or made for another number of vehicles
        """
        (raw,) = self._run([PARAMETERS], s, v)
        return PotentialParameters(*map(float, raw[0]))

    def candidates(self, s: ArrayLike, v: ArrayLike, count: int) -> list[PotentialParameters]:
        """The network's answer, then the dictionary's triples that it ranks highest for this start (ours).

        Parameters
        ----------
        s : (n-1,) array, spacings [m]
        v : (n,) array, speeds [m/s]
        count : most candidates

        Returns
        -------
        up to `count` triples before projection, `evaluate`'s first; of equal scores the first in the dictionary wins
        """
        if not self.ranks:
            return [self.evaluate(s, v)]
        raw, scores, dictionary = self._run([PARAMETERS, SCORES, DICTIONARY], s, v)
        best = np.argsort(-scores[0], kind="stable")[: count - 1]
        return [PotentialParameters(*map(float, row)) for row in (raw[0], *dictionary[best])]


@lru_cache(maxsize=64)
def _shared(path: Path, stamp: tuple[int, int]) -> ParameterNetwork:
    """The network in a file, shared: a session of onnxruntime takes time and memory."""
    return ParameterNetwork(path)


def open_network(path: Path) -> ParameterNetwork:
    """The network in a file as it is now, shared; a file replaced since is opened again (ours).

    Parameters
    ----------
    path : the file; where it is missing or damaged, that is said when the network is needed
    """
    try:
        state = path.stat()
    except OSError:
        return ParameterNetwork(path)
    return _shared(path, (state.st_mtime_ns, state.st_size))


def read_networks(folder: Path, names: Mapping[Any, str]) -> dict[int, ParameterNetwork]:
    """Networks by number of vehicles, each file read once however many numbers it serves.

    Parameters
    ----------
    folder : where the files are
    names : of the files, by number of vehicles, which JSON gives as text
    """
    networks = {name: open_network(folder / name) for name in set(names.values())}
    return {int(n): networks[name] for n, name in names.items()}


def network_path(vehicles: int, folder: Path) -> Path | None:
    """The file in a folder that serves n vehicles: platoon_n.onnx, else platoon_any.onnx, else None (ours).

    Parameters
    ----------
    vehicles : n
    folder : with the networks

    Raises
    ------
    ModelError : where platoon_any.onnx cannot be read
    """
    exact, free = folder / f"platoon_{vehicles}.onnx", folder / ANY_NUMBER
    if exact.exists():
        return exact
    return free if free.exists() and vehicles in open_network(free).vehicles else None
