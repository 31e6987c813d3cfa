"""Spoiled and hostile files for every command that reads one: one sentence, nothing written elsewhere, no code run."""

from __future__ import annotations

import io
import resource
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from . import fmus
from .mutations import Rng, spoiled, spoiled_archive, spoiled_network, spoiled_text
from .trial import Chunk, Outcome
from .watched import Watch, complaint, settle_in

ROOT = Path(__file__).parents[2]
MEMORY = 12 << 30  # bytes of address space that a command may take
_TOML = b"""duration = "0.05 s"
vehicles = 4
step = 0.01
[start]
spacings = [9.0, "9.5 m", 10]
speeds = [30, "108 km/h", 31.5, 30.0]
position = 3.0
[set]
T = "10 ms"
mu = 0.5
[[runs]]
name = "V_old"
set = { potential = 1, lemma1_policy = 3 }
[[runs]]
name = "rollouts"
set = { parameter_source = 3, rollout_count = 4, rollout_horizon = 0.1 }
"""
_CSV = b"s_2,s_3,v_1,v_2,v_3\n9.0,10.5,30,31,29\n8.5,9,30,30,30\n"
_EVIL = {
    "../../evil.txt": b"out",
    "/tmp/psp_evil.txt": b"out",
    "resources/../../../evil.txt": b"out",
    "C:/evil.txt": b"out",
    "resources/evil.link": b"/etc",
    "resources/requirements.txt": b"this\nantigravity\nos;evil\n-c\n../x\n" + b"x" * 3000,
    "resources/zeros.bin": bytes(300_000_000),
    "modelDescription.xml": b'<?xml version="1.0"?><!DOCTYPE l [<!ENTITY a "aaaaaaaaaa">'
    + b"".join(b'<!ENTITY %c "%s">' % (98 + i, b"&%c;" % (97 + i) * 10) for i in range(9))
    + b"]><fmiModelDescription>&j;</fmiModelDescription>",
}


@dataclass(frozen=True)
class Kind:
    """One kind of file.

    Attributes
    ----------
    ending : of the file's name
    good : makes a good one, from the chunk
    spoil : makes a bad one of it
    command : arguments of psp, with {} for the file
    share : of the cases
    """

    ending: str
    good: Callable[[Chunk], Any]
    spoil: Callable[[Rng, Any], bytes]
    command: str
    share: float = 1.0


def _npz(chunk: Chunk) -> bytes:
    out = io.BytesIO()
    np.savez(out, s0=np.full((3, 2), 9.0), v0=np.full((3, 3), 30.0))
    return out.getvalue()


def _parquet(chunk: Chunk) -> bytes:
    from dataclasses import replace

    from psp_model.offline.dataset import make_dataset
    from psp_model.selection.search.search import EFFORTS
    from small_problems import PLAN, TINY

    EFFORTS["tiny"] = TINY
    path = chunk.scratch / "tmp" / "good.parquet"
    make_dataset(replace(PLAN, starts=4, chunk=4), path)
    return path.read_bytes()


def _fmu(one: fmus.Build) -> Callable[[Chunk], dict[str, bytes]]:
    def members(chunk: Chunk) -> dict[str, bytes]:
        from zipfile import ZipFile

        with ZipFile(fmus.path_of(one, chunk.fmus)) as archive:
            return {name: archive.read(name) for name in archive.namelist() if not name.startswith("sources/")}

    return members


def _spoiled_fmu(rng: Rng, members: dict[str, bytes]) -> bytes:
    """Its libraries stay as they are: an FMU is a program, and which program it is is no matter of reading files."""
    if rng.random() < 0.4:
        changed = dict(members)
        changed["modelDescription.xml"] = spoiled_text(rng, members["modelDescription.xml"])
        return spoiled_archive(rng, changed, _EVIL) if rng.random() < 0.1 else _packed(changed)
    return spoiled_archive(rng, members, _EVIL)


def _packed(members: dict[str, bytes]) -> bytes:
    import zipfile

    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return out.getvalue()


def _network(name: str) -> Callable[[Chunk], bytes]:
    return lambda chunk: (ROOT / "onnx" / f"{name}.onnx").read_bytes()


_START = "--duration 0.05"
_CHOICE = (
    "--network {} --start-only --set parameter_source=3 --set rollout_count=4 --set rollout_horizon=0.1 "
    "--set lemma1_policy=2"
)
KINDS = (
    Kind("toml", lambda chunk: _TOML, spoiled_text, f"compare --scenario {{}} {_START}", 2.0),
    Kind("csv", lambda chunk: _CSV, spoiled_text, "optimize --starts {} -o out/optima.csv"),
    Kind("npz", _npz, spoiled, "optimize --starts {} -o out/optima.npz"),
    Kind("parquet", _parquet, spoiled, "train --data {} -o out/network.onnx --curves out/curves"),
    Kind("any.onnx", _network("platoon_any"), spoiled_network, f"certify -n 4 {_CHOICE}"),
    Kind("exact.onnx", _network("platoon_7"), spoiled_network, f"certify -n 7 {_CHOICE}"),
    Kind("native.fmu", _fmu(fmus.PLATOONS[0]), _spoiled_fmu, f"simulate {{}} {_START} --csv out/run.csv"),
    Kind("doctor.fmu", _fmu(fmus.PLATOONS[0]), _spoiled_fmu, "doctor {}"),
    Kind("python.fmu", _fmu(fmus.PLATOONS[1]), _spoiled_fmu, "doctor {}", 0.1),
)


def _spare_the_work() -> None:
    """Leave out solving and training: what a command does with files that are good after all is no matter here."""
    import psp_cli.train
    import psp_model.offline.plan as plan

    def solved(search: Any, starts: Any, tables: bool) -> dict[str, Any]:
        count = len(starts)
        return {
            "triples": np.ones((count, 3)),
            "J": np.ones(count),
            "T_max": np.ones(count),
            "error": np.full(count, ""),
        }

    plan.solve_or_record = solved
    psp_cli.train._train = lambda *arguments: None


def run(chunk: Chunk) -> Outcome:
    """Files of all kinds, each given to its command."""
    import os

    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    allowed = settle_in(chunk.scratch)
    outcome, rng = Outcome(), np.random.default_rng([7004, chunk.number])
    goods = {kind.ending: kind.good(chunk) for kind in KINDS}
    _spare_the_work()
    os.chdir(chunk.scratch)
    watch = Watch([*allowed, Path("/dev/shm")], ("python3", "git", "wine64"))
    total = sum(kind.share for kind in KINDS)
    for kind in KINDS:
        for number in range(max(1, round(chunk.count * kind.share / total))):
            content = kind.spoil(rng, goods[kind.ending])
            path = chunk.scratch / f"given.{kind.ending}"
            path.write_bytes(content)
            before = {entry.name for entry in chunk.scratch.iterdir()}
            code, wrong = complaint([word.format(path) for word in kind.command.split()], watch)
            outcome.count += 1
            outcome.tally(f"{kind.ending}: {'refused' if code else 'taken'}")
            more = {entry.name for entry in chunk.scratch.iterdir()} - before
            if wrong or more:
                kept = _keep(chunk, kind, number, content)
                outcome.violate(f"{kind.command.split()[0]} {kept}: {wrong or more}")
    return outcome


def _keep(chunk: Chunk, kind: Kind, number: int, content: bytes) -> Path:
    """Put a file that was taken badly where it can be looked at."""
    place = chunk.fmus.parent / "hostile" / f"{chunk.number}-{number}.{kind.ending}"
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_bytes(content)
    return place


def tell(outcome: Outcome) -> str:
    """For the summary."""
    parts = []
    for kind in KINDS:
        refused, taken = (outcome.tallies.get(f"{kind.ending}: {what}", 0) for what in ("refused", "taken"))
        parts.append(f"{kind.ending} {refused + taken:,} ({taken:,} still good)")
    return "; ".join(parts)
