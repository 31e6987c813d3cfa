"""Saved states with fields forged and the checksum made to fit: refused or taken; no crash, no hang, no traceback."""

from __future__ import annotations

import json
import os
import shutil
import struct
import subprocess
import sys
from collections.abc import Iterator
from ctypes import byref, c_char, c_void_p
from pathlib import Path
from typing import Any

import pytest

from fmu_src.native.components import NATIVE, native_fmu
from fmu_src.networks import networks_up_to
from fmu_src.toolchain.compile import fmi_headers
from harness import ERROR, OK, Instance, Unpacked
from native.conftest import built

SUM, SUMMED, SIZE, PROGRESS = 8, 16, 24, 40  # places in the header (fmu_src/c/front_state.c)
HEADER = PROGRESS + 6 * 8 + 4 * 4
SENTENCE = "a state that no run can come to, though its checksum fits"
CHOSEN = {"parameter_source": 2}


def sealed(data: bytes) -> bytes:
    """The data with the checksum that fits them: FNV-1a, 64 bits."""
    total = 14695981039346656037
    for byte in data[SUMMED:]:
        total = (total ^ byte) * 1099511628211 % 2**64
    return data[:SUM] + struct.pack("<Q", total) + data[SUMMED:]


def take(instance: Instance, data: bytes) -> int:
    """Read a state, set it, and run on; the status of reading it."""
    buffer, state = (c_char * len(data)).from_buffer_copy(data), c_void_p()
    instance.messages.clear()
    status = instance.call("fmi2DeSerializeFMUstate", buffer, len(data), byref(state))
    assert status in (OK, ERROR) and (state.value is None) == (status != OK)
    if status == OK:
        assert instance.call("fmi2SetFMUstate", state) == OK
        (time,) = struct.unpack_from("<d", data, PROGRESS)
        instance.call("fmi2ExitInitializationMode")
        for k in range(2):
            instance.step(time + 0.02 * k, 0.02)
    texts = [text for _, text in instance.messages]
    assert not any("internal error" in text or "Traceback" in text or "\n" in text for text in texts), texts
    assert instance.call("fmi2Reset") == OK
    return status


def honest(instance: Instance) -> bytes:
    """The state after 53 ms."""
    assert instance.initialise(CHOSEN) == OK
    assert instance.step(0.0, 0.053) == OK
    return bytes(instance.slave.serializeFMUState(instance.slave.getFMUState()))


# the header ------------------------------------------------------------------------------------------------------

FORGED = [
    *(("mode", place, "<I", value) for place in [PROGRESS + 48] for value in (0, 3, 12, 63, 64, 128, 2**32 - 1)),
    *(("has_stop", PROGRESS + 52, "<I", value) for value in (2, 2**31)),
    *(("last_step", PROGRESS + 56, "<I", value) for value in (4, 5, 2**32 - 1)),
    *(("setup", PROGRESS + 60, "<I", value) for value in (2, 255)),
    *(("time", PROGRESS, "<d", value) for value in (float("nan"), float("inf"), 1e15)),
    ("stop", PROGRESS + 8, "<d", float("nan")),
    *(("last_success", PROGRESS + 16, "<d", value) for value in (float("nan"), float("-inf"), -1.0)),
    *(("start", PROGRESS + 24, "<d", value) for value in (float("nan"), float("inf"))),
    *(("elapsed", PROGRESS + 32, "<d", value) for value in (float("nan"), float("inf"), -1.0)),
    ("steps", PROGRESS + 40, "<Q", 2**64 - 1),
    ("reserved", PROGRESS - 4, "<I", 1),
]


@pytest.mark.parametrize(("name", "place", "form", "value"), FORGED)
def test_a_field_of_the_header_that_cannot_be_is_refused(instance, name, place, form, value):
    data = bytearray(honest(instance))
    assert take(instance, bytes(data)) == OK
    struct.pack_into(form, data, place, value)
    assert take(instance, sealed(bytes(data))) == ERROR
    assert SENTENCE in instance.messages[0][1] or name in ("time",)


@pytest.mark.parametrize("keep", [0, 1, 7, 8, 16, HEADER - 1])
def test_less_than_a_header_is_refused_whatever_size_it_claims(instance, keep):
    data = bytearray(honest(instance))
    struct.pack_into("<Q", data, SIZE, 2**64 - 1)
    for forged in (bytes(data[:keep]), sealed(bytes(data))):
        assert take(instance, forged) == ERROR and len(instance.messages) == 1


# the native FMUs -------------------------------------------------------------------------------------------------


def _compiled(component: str, folder: Path) -> Path:
    """forged_states.c with a native FMU, under the sanitizers that there are."""
    sources = native_fmu(component, 4, networks_up_to(4)).sources("{forged}")
    for name, content in (fmi_headers() | sources).items():
        (folder / name).write_bytes(content)
    shutil.copy(Path(__file__).parent / "forged_states.c", folder)
    compiler = shutil.which("gcc") or shutil.which("clang")
    checks = ["-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all"]
    command = [str(compiler), "-std=gnu11", "-O1", "-g", *checks, "-o", "forged", *_files(folder), "-lm"]
    if compiler is None or subprocess.run(command, cwd=folder, capture_output=True, check=False).returncode:
        command = [sys.executable, "-m", "ziglang", "cc", "-std=gnu11", "-O1", "-fsanitize=undefined", "-o", "forged"]
        subprocess.run([*command, *_files(folder), "-lm"], cwd=folder, check=True)  # UBSan alone comes with it
    return folder / "forged"


def _files(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.glob("*.c"))


@pytest.mark.parametrize("component", NATIVE)
def test_no_forged_state_of_a_native_fmu_does_harm(component, tmp_path):
    program = _compiled(component, tmp_path)
    ran = subprocess.run([str(program), str(os.getpid())], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr[-2000:]
    refused, taken = (int(word) for word in ran.stdout.split() if word.isdigit())
    assert refused > 1000 and taken > 1000  # what may be anything, such as an input, is taken


# the Python FMUs -------------------------------------------------------------------------------------------------

NASTY: list[Any] = [None, True, -1, 0, 2.5, 10**400, -(10**18), float("nan"), float("inf"), "x", [], [1], {}, [[]] * 3]


def _forged(value: Any) -> Iterator[Any]:
    """Copies of a JSON value with one part of it forged."""
    yield from NASTY
    if isinstance(value, dict):
        yield from ({k: one for k, one in value.items() if k != gone} for gone in value)
        yield from (value | {name: forged} for name, part in value.items() for forged in _forged(part))
    elif isinstance(value, list) and value:
        yield from (value[:-1], [*value, value[-1]])
        yield from ([forged, *value[1:]] for forged in _forged(value[0]))


DELAYED = {"actuation_delay": 0.033, "actuator_lag[1]": 0.1}
EXTENDED = {"kappa": 0.5, "closing_speed": 0.5, "length[1]": 6.0, "leader_automated": 0.0, "certificate": 2}
SETTINGS = [(component, {"plant": DELAYED, "leader": {}}.get(component, CHOSEN)) for component in NATIVE]


@pytest.mark.parametrize(("component", "values"), [*SETTINGS, ("platoon", CHOSEN | EXTENDED)])
def test_no_forged_state_of_a_python_fmu_does_harm(component, values, tmp_path):
    fmu: Unpacked = built("python", 3, tmp_path, component)
    instance = Instance(fmu)
    assert instance.initialise(values) == OK and instance.step(0.0, 0.053) == OK
    data = bytes(instance.slave.serializeFMUState(instance.slave.getFMUState()))
    assert take(instance, data) == OK
    cases = [json.dumps(forged).encode() for forged in _forged(json.loads(data[HEADER:]))]
    cases += [b"", b"{", b"\xff\xfe", b"[" * 100_000, json.dumps({"a": 1}).encode()]
    counts = {OK: 0, ERROR: 0}
    for content in cases:
        head = data[:SIZE] + struct.pack("<Q", len(content)) + data[SIZE + 8 : HEADER]
        status = take(instance, sealed(head + content))
        counts[status] += 1
        if status == ERROR:
            assert [SENTENCE in text for _, text in instance.messages] == [True]
    assert counts[ERROR] > 50, counts
    assert take(instance, data) == OK
    instance.close()
