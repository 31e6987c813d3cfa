"""Which packages of the extras each command needs: asked before the command begins, so that no file is touched."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from typer.core import TyperCommand


def _always(options: Mapping[str, Any]) -> bool:
    return True


@dataclass(frozen=True)
class Need:
    """Packages that a command, or one of its options, does not work without.

    Attributes
    ----------
    extra : brings them
    modules : their names
    option : what of the command needs them, as in its sentence; empty for the command itself
    when : whether these options of the command do
    """

    extra: str
    modules: tuple[str, ...]
    option: str = ""
    when: Callable[[Mapping[str, Any]], bool] = _always


def _given(name: str) -> Callable[[Mapping[str, Any]], bool]:
    return lambda options: bool(options[name])


def _mp4_without_ffmpeg(options: Mapping[str, Any]) -> bool:
    from shutil import which

    path = options["animate"]
    return path is not None and path.suffix.lower() == ".mp4" and which("ffmpeg") is None


_NATIVE = ("casadi", "onnx", "ziglang")
_ENGINE = ("casadi", "ziglang")
_RUNTIME = Need("native", _NATIVE, "--runtime native", lambda options: options["runtime"] == "native")
_PLOT = Need("report", ("matplotlib",), "--plot", _given("plot"))
NEEDS: dict[str, tuple[Need, ...]] = {
    "build": (_RUNTIME,),
    "simulate": (_PLOT, _RUNTIME),
    "compare": (_PLOT,),
    "certify": (),
    "figures": (Need("report", ("matplotlib",)),),
    "report": (
        Need("film", ("matplotlib",), "--animate", _given("animate")),
        Need("film", ("imageio_ffmpeg",), "--animate", _mp4_without_ffmpeg),
    ),
    "explore": (Need("explore", ("nicegui", "matplotlib")),),
    "dataset": (
        Need("offline", (*_ENGINE, "pyarrow")),
        Need("offline", ("distributed",), "--scheduler", _given("scheduler")),
    ),
    "optimize": (Need("offline", _ENGINE),),
    "train": (Need("offline", ("jax", "optax", "onnx", "pyarrow", "scipy", "matplotlib")),),
    "evaluate": (
        Need("offline", (*_ENGINE, "pyarrow", "matplotlib")),
        Need("offline", ("onnx",), "--card", _given("card")),
    ),
    "doctor": (),
    "sumo": (
        Need("sumo", ("libsumo", "sumo")),
        Need(
            "native", _NATIVE, "--runtime native", lambda options: options["runtime"] == "native" and not options["fmu"]
        ),
        _PLOT,
    ),
}
"""By command; what a command always needs comes first."""


class CheckedCommand(TyperCommand):
    """A command that begins only where the packages that it needs are there."""

    def invoke(self, ctx: Any) -> Any:
        """Ask for the packages, then run the command."""
        needs = [need for need in NEEDS.get(str(self.name), ()) if need.when(ctx.params)]
        if needs:
            from psp_model.installed.extras import require

            for need in needs:
                require(f"psp {self.name} {need.option}".strip(), need.extra, need.modules)
        return super().invoke(ctx)
