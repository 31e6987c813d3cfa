"""Where a report's numbers come from: versions, hashes and sources."""

from __future__ import annotations

import hashlib
import json
import platform
import subprocess
from collections.abc import Sequence
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

import psp_model
from psp_model.analysis.cases import Case
from psp_model.installed.files import checkout
from psp_model.parameters import ObjectiveWeights, PlatoonParameters
from psp_model.selection.network import ParameterNetwork

SOURCES = {name: "paper, section V" for name in ("L", "lam", "v_star", "v_max", "epsilon", "mu", "z", "w1", "w2")}
SOURCES |= {"a_ref": "ours: equal to z", "s_ref": "ours: equal to lambda"}
UNITS = {"L": "m", "lam": "m", "v_star": "m/s", "v_max": "m/s", "epsilon": "m/s²", "mu": "1/s", "z": "m/s²"}
UNITS |= {"w1": "1", "w2": "1", "a_ref": "m/s²", "s_ref": "m"}


def constants_table(case: Case) -> list[tuple[str, str, str, str]]:
    """Name, value, unit and source of every constant and weight of a run.

    Parameters
    ----------
    case : the run
    """
    rows = []
    for given, usual in (
        (case.setup.start.constants, PlatoonParameters()),
        (case.setup.weights, ObjectiveWeights()),
    ):
        for name, value in asdict(given).items():
            source = SOURCES[name] if value == getattr(usual, name) else "set by the user"
            rows.append(("lambda" if name == "lam" else name, f"{value:.10g}", UNITS[name], source))
    return rows


def versions() -> dict[str, str]:
    """What made the report, by name."""
    found = {"psp-platoon": _version("psp-platoon"), "source": _commit() or "not a git checkout"}
    found["Python"] = platform.python_version()
    return found | {name: _version(name) for name in ("numpy", "onnxruntime")}


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def _commit() -> str | None:
    """The commit that the model's files are at, with a mark where they differ from it."""
    if checkout() is None:
        return None  # a repository around an installed wheel is not this project's
    folder = Path(psp_model.__file__).parent
    try:
        head = subprocess.run(["git", "rev-parse", "HEAD"], cwd=folder, capture_output=True, text=True, check=True)
        changed = subprocess.run(
            ["git", "diff", "--quiet", "HEAD", "--", "."], cwd=folder, capture_output=True, check=False
        ).returncode
    except (OSError, subprocess.CalledProcessError):
        return None
    return f"commit {head.stdout.strip()}" + (", psp_model changed since" if changed else "")


def network_hash(network: ParameterNetwork | None) -> dict[str, str]:
    """Name and SHA-256 of the network's file; empty without one.

    Parameters
    ----------
    network : the network, None if there is none
    """
    if network is None:
        return {}
    return {f"network {network.path.name}, SHA-256": hashlib.sha256(network.path.read_bytes()).hexdigest()}


def hashes(cases: Sequence[Case]) -> dict[str, str]:
    """SHA-256 of what went into the runs and of what came out of them, all digits included.

    Parameters
    ----------
    cases : the runs
    """
    asked, came = hashlib.sha256(), hashlib.sha256()
    for case in cases:
        setup = case.setup
        tables = [setup.start.s.tolist(), setup.start.v.tolist(), setup.start.x_leader]
        settings = [asdict(setup.start.constants), asdict(setup.weights), asdict(setup.sampling), asdict(case.shape)]
        asked.update(json.dumps([case.name, tables, settings], sort_keys=True).encode())
        for table in (case.run.time, case.run.x, case.run.s, case.run.v, case.run.a, case.run.cost):
            came.update(np.ascontiguousarray(table, dtype="<f8").tobytes())
    return {"inputs, SHA-256": asked.hexdigest(), "results, SHA-256": came.hexdigest()}
