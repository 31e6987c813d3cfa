"""Workers that measure how an FMU begins."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from .fmus import CACHE, HOSTS, Fmu, compiled, libpython
from .worker import Worker


def beginner(kind: str, under: Fmu, which: str, source: int) -> Worker:
    """A worker that initialises an FMU with a parameter_source: which = C host or fmpy."""
    errors = CACHE / f"begin {which} {kind}.log".replace(" ", "_")
    arguments = [*under.arguments(0.0)[:3], str(under.source), str(source)]
    if which == "fmpy":
        return Worker([sys.executable, str(HOSTS / "init_host.py"), under.folder, under.model, *arguments], errors)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {"PATH": path} | ({"LD_PRELOAD": libpython()} if kind == "empty python" else {})
    return Worker([str(compiled("init_host")), *arguments], errors, environment)
