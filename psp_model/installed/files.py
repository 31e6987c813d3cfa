"""Where the networks and the licence are: in a checkout at its root, in a wheel inside this package."""

from __future__ import annotations

from pathlib import Path

from ..errors import ModelError

PACKED = Path(__file__).parent / "packed"
"""In a wheel only: `setup.py` puts `onnx/` and LICENSE there, because a package `onnx` is on PyPI already."""

_CHECKOUT = Path(__file__).parents[2]


def checkout() -> Path | None:
    """The root of the checkout that this code runs from, None where it runs from a wheel."""
    return None if PACKED.is_dir() else _CHECKOUT


def project_file(name: str) -> Path:
    """Where a file or folder of the project's root is.

    Parameters
    ----------
    name : `onnx` or `LICENSE`
    """
    return (checkout() or PACKED) / name


def networks_folder() -> Path:
    """The folder with this project's networks and their model cards.

    Raises
    ------
    ModelError : where it is missing, so that a damaged installation is not taken for a platoon without a network
    """
    folder = project_file("onnx")
    if not any(folder.glob("*.onnx")):
        raise ModelError("networks", str(folder))
    return folder


def licence() -> bytes:
    """The project's licence, as every FMU carries it."""
    return project_file("LICENSE").read_bytes()
