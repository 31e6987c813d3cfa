"""pytest plugin: native FMUs are compiled by clang so that they count which branches run (PSP_COVERAGE names a folder).

Sources lie in one place for all of them, so that what several FMUs share is counted together; generated headers do not.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

from fmu_src.native import build
from fmu_src.toolchain.compile import FMI_HEADERS, host_platform

FOLDER = Path(os.environ["PSP_COVERAGE"])
FLAGS = ["-std=c11", "-O1", "-g", "-fPIC", "-shared", "-fvisibility=hidden", "-ffp-contract=off"]
COUNTING = ["-fprofile-instr-generate", "-fcoverage-mapping"]


def compile_counting(platform: str, name: str, files: Mapping[str, bytes], extra: Sequence[str] = ()) -> bytes:
    """What `compile_library` does, with counters, for this machine's platform."""
    assert platform == host_platform(), "only this machine's platform can be counted"
    digest = hashlib.sha256(repr(sorted(files.items())).encode()).hexdigest()[:16]
    sources, headers = FOLDER / "sources", FOLDER / "headers" / digest
    for file, content in files.items():
        path = (headers if file.startswith("psp_") else sources) / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    library = FOLDER / "libraries" / f"{name}-{digest}.so"
    library.parent.mkdir(exist_ok=True)
    includes = ["-I", str(headers), "-I", str(FMI_HEADERS)]
    units = [str(sources / file) for file in sorted(files) if file.endswith(".c")]
    command = ["clang", *FLAGS, *COUNTING, *extra, *includes, "-o", str(library), *units, "-lm", "-ldl"]
    subprocess.run(command, check=True)
    return library.read_bytes()


build.compile_library = compile_counting
