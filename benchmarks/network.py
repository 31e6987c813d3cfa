"""What asking the network costs at initialisation, beside onnxruntime, for 7 vehicles."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack

import numpy as np

from psp_model import StartDomain
from psp_model.selection.network import INPUT, PARAMETERS, ParameterNetwork, import_onnxruntime

from .begin import beginner
from .fmus import ROOT, fmu
from .registry import Context
from .rounds import Row, interleave, row

FILE = ROOT / "onnx" / "platoon_7.onnx"


def session() -> object:
    """An onnxruntime session set up for one row at a time."""
    onnxruntime = import_onnxruntime()
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    return onnxruntime.InferenceSession(str(FILE), options, providers=["CPUExecutionProvider"])


def repeated(call: Callable[[], object], times: int) -> Callable[[], float]:
    """Gives the seconds per call."""

    def measure() -> float:
        began = time.perf_counter()
        for _ in range(times):
            call()
        return (time.perf_counter() - began) / times

    return measure


def measure(context: Context) -> list[Row]:
    """All lines of this measurement."""
    s, v = StartDomain().draw(np.random.default_rng(3), 7, 1)
    inputs = {INPUT: np.concatenate([s, v]).T.astype(np.float32)}
    ready, ours = session(), ParameterNetwork(FILE)
    times = 20 if context.quick else 1000
    measures = {
        "onnxruntime": repeated(lambda: ready.run([PARAMETERS], inputs), times),  # type: ignore[attr-defined]
        "session": repeated(lambda: session().run([PARAMETERS], inputs), 2),  # type: ignore[attr-defined]
        "ParameterNetwork": repeated(lambda: ours.evaluate(s[:, 0], v[:, 0]), times),
    }
    with ExitStack() as stack:
        for kind, which in (("native", "C host"), ("python", "fmpy")):
            for source in (1, 2):
                worker = stack.enter_context(beginner(kind, fmu(kind, 7), which, source))
                measures[f"{kind} {source}"] = worker.seconds
        found = interleave(measures, context.rounds(15), 40.0)
    native, python = (
        [with_it - without for with_it, without in zip(found[f"{kind} 1"], found[f"{kind} 2"], strict=True)]
        for kind in ("native", "python")
    )
    run, whole = found["onnxruntime"], found["session"]
    return [
        row("native FMU: network and projection", "n = 7", "onnxruntime, run", native, run, "µs", scale=1e6),
        row(
            "psp_model.selection.network, evaluate",
            "n = 7",
            "onnxruntime, run",
            found["ParameterNetwork"],
            run,
            "µs",
            scale=1e6,
        ),
        row("Python FMU: network and projection", "n = 7", "onnxruntime, open and run", python, whole, "ms", scale=1e3),
    ]
