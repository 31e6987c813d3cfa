"""The packages that the default install does without: checked before anything is written, named in one sentence."""

from __future__ import annotations

import io
import json
import warnings
from collections.abc import Iterable
from contextlib import redirect_stdout
from importlib import import_module
from importlib.metadata import PackageNotFoundError, distribution

from ..errors import PspError
from .files import checkout

BRINGS = {
    "report": ("matplotlib",),
    "native": ("casadi", "onnx", "ziglang"),
    "sumo": ("libsumo", "sumo"),
    "film": ("matplotlib", "imageio_ffmpeg"),
    "explore": ("nicegui", "matplotlib"),
    "offline": ("casadi", "ziglang", "jax", "optax", "onnx", "pyarrow", "scipy", "dask", "distributed", "matplotlib"),
}
"""The modules that each extra brings, the smaller extras first."""


class MissingExtra(PspError, ImportError):
    """One sentence: what needs which package, and how to install it."""


def require(what: str, extra: str, modules: Iterable[str]) -> None:
    """Refuse where packages are missing, or are there and cannot be loaded.

    Parameters
    ----------
    what : needs them, as the subject of the sentence
    extra : brings them
    modules : names of them

    Raises
    ------
    MissingExtra : with the sentence
    """
    missing: list[str] = []
    for module in modules:
        try:
            with warnings.catch_warnings(), redirect_stdout(io.StringIO()):  # libsumo prints what it thinks of pyarrow
                warnings.simplefilter("ignore")
                import_module(module)
        except ModuleNotFoundError as error:
            missing.append((error.name or module).partition(".")[0])
        except (ImportError, OSError) as error:
            raise _broken(what, module, error) from None
    if missing:
        raise _missing(what, list(dict.fromkeys(missing)), extra)


def explained(error: ImportError, what: str) -> MissingExtra | None:
    """The sentence for an import that failed where no check had asked before; None for modules of no extra.

    Parameters
    ----------
    error : from the import
    what : needed it, as the subject of the sentence
    """
    module = (error.name or "").partition(".")[0]
    extra = next((extra for extra, modules in BRINGS.items() if module in modules), None)
    if extra is None:
        return None
    gone = isinstance(error, ModuleNotFoundError)
    return _missing(what, [module], extra) if gone else _broken(what, module, error)


def _missing(what: str, modules: list[str], extra: str) -> MissingExtra:
    *most, last = modules
    names = f"{', '.join(most)} and {last}" if most else last
    return MissingExtra(
        f"{what} needs {names}, which the extra {extra} brings", f"install it by {install_command(extra)}"
    )


def _broken(what: str, module: str, error: Exception) -> MissingExtra:
    reason = " ".join(str(error).split())
    problem = f"{what} needs {module}, which is installed but cannot be loaded ({reason})"
    return MissingExtra(problem, f"install what that names, or {module} anew")


def install_command(extra: str) -> str:
    """How to install an extra here: from where this project was installed, as no index has it.

    Parameters
    ----------
    extra : its name
    """
    if checkout() is not None:
        return f"`pip install --editable '.[{extra}]'` in {checkout()}"
    try:
        origin = json.loads(distribution("psp-platoon").read_text("direct_url.json") or "{}")
    except (PackageNotFoundError, ValueError):
        origin = {}
    if "url" not in origin:
        return f"`pip install '.[{extra}]'` in a checkout of the project"
    version_control = origin.get("vcs_info", {}).get("vcs", "")
    url = f"{version_control}+{origin['url']}" if version_control else origin["url"]
    return f"`pip install 'psp-platoon[{extra}] @ {url}'`"
