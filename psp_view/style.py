"""What all figures share: captions, and files on disk."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.figure import Figure

from psp_model.errors import PspError
from psp_model.whole_file import whole_file


class PictureError(PspError, ValueError):
    """A picture of a kind that cannot be written."""


LINE_STYLES = ("-", "--", ":", "-.")

RC: Any = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.grid": True,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "lines.linewidth": 1.4,
    "legend.frameon": False,
    "svg.hashsalt": "psp-platoon",  # the same picture gives the same file
    "pdf.fonttype": 42,
}


def new_figure(width: float, height: float) -> Figure:
    """An empty figure in the common style, apart from pyplot's global state.

    Parameters
    ----------
    width, height : size in inches
    """
    return Figure(figsize=(width, height), layout="constrained")


def caption(figure: Figure, text: str, command: str) -> None:
    """Put what is shown, and the command that shows it, below a figure.

    Parameters
    ----------
    figure : the figure
    text : one or two sentences
    command : the command that makes this very picture
    """
    width = int(figure.get_figwidth() * 17)
    lines = textwrap.wrap(text, width) + textwrap.wrap("$ " + command, width, break_on_hyphens=False)
    # not mathtext: a command may hold dollar signs
    figure.supxlabel("\n".join(lines), x=0.01, ha="left", fontsize=7.5, color="#444444", parse_math=False)


def save(figure: Figure, path: str | Path, command: str = "") -> Path:
    """Write a figure in the format given by the suffix: PNG, SVG or PDF.

    Parameters
    ----------
    figure : the figure
    path : where to, ending in .png, .svg or .pdf; missing folders are made
    command : noted in the file's metadata

    Returns
    -------
    the file written

    Raises
    ------
    PictureError : for any other suffix
    """
    path = Path(path)
    metadata: dict[str, dict[str, Any]] = {
        ".png": {"Description": command},
        ".svg": {"Date": None, "Description": command},
        ".pdf": {"CreationDate": None, "Subject": command},
    }
    kind = path.suffix.lower()
    if kind not in metadata:
        raise PictureError(f"{path} is not a supported picture file", "give it a name that ends in .png, .svg or .pdf")
    with matplotlib.rc_context(RC), whole_file(path) as partial:
        figure.savefig(partial, dpi=150, metadata=metadata[kind], format=kind[1:])
    return path
