"""The FMUs under test, the empty ones beside them, and the programs that host them; each is built once and kept."""

from __future__ import annotations

import io
import json
import os
import shutil
import sys
from contextlib import redirect_stdout
from dataclasses import asdict, dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path

from fmpy import extract, read_model_description

from build_fmu import main as build
from fmu_src.toolchain.compile import (
    ENDINGS,
    FLAGS,
    FMI_HEADERS,
    SOURCES,
    compile_library,
    host_platform,
    run_compiler,
)

from .worker import Worker

ROOT = Path(__file__).parents[1]
CACHE = ROOT / "build" / "bench"
HOSTS = Path(__file__).parent / "hosts"
ON_HILL, OFF_HILL = 12.0, 15.0  # [m] spacings that stay on the hill of r = 11 m over a segment, and beyond it
KINDS = ("python", "native", "empty python", "empty native")


@dataclass(frozen=True)
class Fmu:
    """An FMU, unpacked, as the workers want it.

    Attributes
    ----------
    folder, model, guid : where it lies, its modelIdentifier, its GUID
    vehicles : n
    outputs, first_output : how many Real outputs, and the reference of the first; the others follow
    s_start, v_start, source : references of the first spacing, the first speed and parameter_source; -1: it has none
    """

    folder: str
    model: str
    guid: str
    vehicles: int
    outputs: int
    first_output: int
    s_start: int = -1
    v_start: int = -1
    source: int = -1

    def arguments(self, spacing: float) -> list[str]:
        """For step_host, from the library on."""
        platform = host_platform()
        library = Path(self.folder) / "binaries" / platform / f"{self.model}.{ENDINGS[platform]}"
        numbers = [self.vehicles, self.outputs, self.first_output, self.s_start, self.v_start, self.source, spacing]
        return [str(library), (Path(self.folder) / "resources").as_uri(), self.guid, *map(str, numbers)]


@cache
def sources_digest() -> str:
    """What the FMUs and the workers are made from, in a few letters."""
    digest = sha256()
    for folder in ("fmu_src", "psp_model", "onnx", "benchmarks/hosts"):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.is_file() and "__pycache__" not in path.parts:
                digest.update(path.relative_to(ROOT).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:12]


def _kept(name: str) -> Path:
    """The folder for one built thing; older sources have another."""
    return CACHE / sources_digest() / name


def fmu(kind: str, vehicles: int) -> Fmu:
    """One of KINDS for n vehicles, built if it is not there.

    Raises
    ------
    RuntimeError : where it cannot be built
    """
    folder = _kept(f"{kind.replace(' ', '_')}_{vehicles}")
    note = folder / "fmu.json"
    if not note.exists():
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        made = _empty(kind, vehicles, folder) if kind.startswith("empty") else _built(kind, vehicles, folder)
        note.write_text(json.dumps(asdict(made)))
    return Fmu(**json.loads(note.read_text()))


def _built(runtime: str, vehicles: int, folder: Path) -> Fmu:
    """The platoon FMU, by the public command."""
    said = io.StringIO()
    with redirect_stdout(said):
        code = build(["--runtime", runtime, "--vehicles", str(vehicles), "--output", str(folder)])
    if code:
        raise RuntimeError(f"build_fmu.py --runtime {runtime} --vehicles {vehicles} gave {code}")
    (path,) = folder.glob("*.fmu")
    unpacked = str(extract(str(path), str(folder / "unpacked")))
    model = read_model_description(unpacked, validate=False)
    reference = {variable.name: variable.valueReference for variable in model.modelVariables}
    outputs = [variable.valueReference for variable in model.modelVariables if variable.causality == "output"]
    assert outputs == list(range(outputs[0], outputs[0] + len(outputs)))
    places = (reference["s_start[2]"], reference["v_start[1]"], reference["parameter_source"])
    return Fmu(unpacked, model.coSimulation.modelIdentifier, model.guid, vehicles, len(outputs), outputs[0], *places)


def controller(vehicles: int) -> Fmu:
    """The native controller for n vehicles, built if it is not there.

    Raises
    ------
    RuntimeError : where it cannot be built
    """
    folder = _kept(f"controller_{vehicles}")
    note = folder / "fmu.json"
    if not note.exists():
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        arguments = ["--component", "controller", "--runtime", "native", "--vehicles", str(vehicles)]
        said = io.StringIO()
        with redirect_stdout(said):
            code = build([*arguments, "--output", str(folder)])
        if code:
            raise RuntimeError(f"build_fmu.py {' '.join(arguments)} gave {code}")
        unpacked = str(extract(str(next(folder.glob("*.fmu"))), str(folder / "unpacked")))
        model = read_model_description(unpacked, validate=False)
        outputs = [variable.valueReference for variable in model.modelVariables if variable.causality == "output"]
        made = Fmu(unpacked, model.coSimulation.modelIdentifier, model.guid, vehicles, len(outputs), outputs[0])
        note.write_text(json.dumps(asdict(made)))
    return Fmu(**json.loads(note.read_text()))


def _empty(kind: str, vehicles: int, folder: Path) -> Fmu:
    """An FMU that does nothing, with the outputs of the platoon FMU."""
    outputs = fmu(kind.split()[1], vehicles).outputs
    if kind == "empty native":
        files = {path.name: path.read_bytes() for path in (HOSTS / "empty_fmu.c", SOURCES / "fmi2Functions.h")}
        platform = host_platform()
        library = folder / "binaries" / platform / f"Empty.{ENDINGS[platform]}"
        library.parent.mkdir(parents=True)
        library.write_bytes(
            compile_library(platform, "Empty", files, [f"-DOUTPUTS={outputs}", "-Wno-unused-parameter"])
        )
        (folder / "resources").mkdir()
        return Fmu(str(folder), "Empty", "{empty}", vehicles, outputs, 0)
    from pythonfmu import FmuBuilder

    script = folder / "empty_slave.py"
    text = (HOSTS / "empty_slave.py").read_text(encoding="utf-8")
    script.write_text(text.replace("OUTPUTS = 1", f"OUTPUTS = {outputs}"), encoding="utf-8")
    with redirect_stdout(io.StringIO()):
        path = FmuBuilder.build_FMU(str(script), dest=str(folder))
    unpacked = str(extract(str(path), str(folder / "unpacked")))
    model = read_model_description(unpacked, validate=False)
    return Fmu(unpacked, model.coSimulation.modelIdentifier, model.guid, vehicles, outputs, 0)


def compiled(source: str, vehicles: int = 0) -> Path:
    """A C program of `hosts`, by the compiler and the flags of the native FMU."""
    program = _kept(f"{source}_{vehicles}" if vehicles else source)
    if not program.exists():
        program.parent.mkdir(parents=True, exist_ok=True)
        flags = [flag for flag in FLAGS if flag not in ("-shared", "-fvisibility=hidden")]
        command = [sys.executable, "-m", "ziglang", "cc", "-target", "x86_64-linux-gnu.2.17", *flags]
        command += [f"-DN={vehicles}"] if vehicles else []
        command += ["-I", str(FMI_HEADERS), "-o", str(program), str(HOSTS / f"{source}.c"), "-lm", "-ldl"]
        if not run_compiler(command, program.parent):
            raise RuntimeError(f"{source}.c cannot be compiled, the compiler's messages are above")
    return program


def libpython() -> str:
    """The shared library of this Python, which pythonfmu's own library does not find by itself."""
    import sysconfig

    folder, name = sysconfig.get_config_var("LIBDIR"), sysconfig.get_config_var("INSTSONAME")
    return str(Path(folder) / name)


def host(kind: str, under: Fmu, which: str, spacing: float) -> Worker:
    """A worker that steps an FMU: which = C host, ctypes or fmpy."""
    errors = CACHE / f"{which} {kind} {under.vehicles}.log".replace(" ", "_")
    if which != "C host":
        command = [sys.executable, str(HOSTS / "python_host.py"), which, under.folder, under.model]
        return Worker([*command, *under.arguments(spacing)], errors)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {"PATH": path} | ({"LD_PRELOAD": libpython()} if kind == "empty python" else {})
    return Worker([str(compiled("step_host")), *under.arguments(spacing)], errors, environment)


def loop(vehicles: int, spacing: float) -> Worker:
    """A worker that runs the hand-written loop."""
    return Worker([str(compiled("step_loop", vehicles)), str(spacing)], CACHE / f"loop_{vehicles}.log")
