"""Measure what the project costs beside floors and peers: `python -m benchmarks [NAME...]`.

Each measurement writes NAME.json when it is done.  A run that was interrupted goes on where it stopped; a run that was
finished starts anew.  Without names all are measured, and docs/benchmarks.md gets its table and its picture.
"""

from __future__ import annotations

if __name__ == "__main__":  # before the imports that take time
    from psp_cli.interrupt import install

    install("benchmarks")

import argparse
import json
import os
import shlex
import sys
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from psp_cli import interrupt
from psp_model.installed.extras import BRINGS, require
from psp_model.whole_file import write_whole

from .fmus import CACHE, ROOT, sources_digest
from .machine import machine, versions
from .page import write_page
from .registry import MEASUREMENTS, Context, Measurement
from .table import table

RESULTS = Path(__file__).parent / "results"
UNFINISHED = "unfinished.json"


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    names = [measurement.name for measurement in MEASUREMENTS]
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(names)} (all)")
    parser.add_argument("--quick", action="store_true", help="a smoke run whose figures mean nothing")
    parser.add_argument("--fresh", action="store_true", help="forget what an interrupted run had measured")
    parser.add_argument(
        "--output", type=Path, help="folder for the JSON (benchmarks/results; quick: build/bench/quick)"
    )
    default = Path(os.environ.get("PSP_BENCH_PEERS", CACHE / "peers"))
    text = (
        "folder with virtual environments of the peers, made there if missing ($PSP_BENCH_PEERS, or build/bench/peers)"
    )
    parser.add_argument("--peers", type=Path, default=default, help=text)
    options = parser.parse_args(arguments)
    if unknown := set(options.names) - set(names):
        parser.error(f"there is no measurement {', '.join(sorted(unknown))}: choose of {', '.join(names)}")
    options.output = options.output or (CACHE / "quick" if options.quick else RESULTS)
    return options


def say(text: str) -> None:
    """Progress, on stderr."""
    print(f"  {text}", file=sys.stderr, flush=True)


def run(measurement: Measurement, options: argparse.Namespace) -> dict[str, Any]:
    """Measure and describe; refused before it begins where packages are missing."""
    require(f"the measurement {measurement.name}", measurement.extra, BRINGS.get(measurement.extra, ()))
    began = time.perf_counter()
    load = os.getloadavg()[0]
    rows = measurement.measure(Context(options.quick, say, options.peers))
    command = f"python -m benchmarks {measurement.name}" + (" --quick" if options.quick else "")
    return {
        "name": measurement.name,
        "title": measurement.title,
        "command": command,
        "date": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "seconds": round(time.perf_counter() - began, 1),
        "machine": machine() | {"load_average_before": round(load, 2)},
        "versions": versions(),
        "rows": [row.as_dict() for row in rows],
    }


def already_done(options: argparse.Namespace) -> list[str]:
    """What an interrupted run of the same sources has measured."""
    note = options.output / UNFINISHED
    if options.fresh or not note.exists():
        return []
    kept = json.loads(note.read_text())
    return list(kept["done"]) if kept["sources"] == sources_digest() else []


def main(arguments: list[str] | None = None) -> int:
    """Measure what is asked for; exit code 1 if one of the measurements failed."""
    options = parse(arguments)
    options.output.mkdir(parents=True, exist_ok=True)
    CACHE.mkdir(parents=True, exist_ok=True)
    chosen = [one for one in MEASUREMENTS if not options.names or one.name in options.names]
    done, note, failed = already_done(options), options.output / UNFINISHED, False
    words = [word for word in (sys.argv[1:] if arguments is None else arguments) if word != "--fresh"]
    again = shlex.join(["python", "-m", "benchmarks", *words])
    interrupt.can_go_on(lambda: again if note.exists() and not options.names else None)
    for number, measurement in enumerate(chosen, start=1):
        heading = f"[{number}/{len(chosen)}] {measurement.title}"
        if measurement.name in done and not options.names:
            print(f"{heading}: measured before the interruption", file=sys.stderr)
            continue
        print(heading, file=sys.stderr, flush=True)
        try:
            result = run(measurement, options)
        except (ImportError, OSError, RuntimeError) as error:
            print(f"  not measured: {error}", file=sys.stderr)
            failed = True
            continue
        content = json.dumps(result, indent=1, ensure_ascii=False) + "\n"
        write_whole(options.output / f"{measurement.name}.json", content)
        print(table([result]), flush=True)
        if not options.names:
            done.append(measurement.name)
            write_whole(note, json.dumps({"sources": sources_digest(), "done": done}))
    if not failed and not options.names:
        note.unlink(missing_ok=True)
    if not options.quick:
        write_page(ROOT, options.output)
    return int(failed)


if __name__ == "__main__":
    interrupt.run("benchmarks", main)
