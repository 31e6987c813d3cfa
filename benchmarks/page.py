"""docs/benchmarks.md gets the table and the picture of what lies in benchmarks/results."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from psp_model.whole_file import write_whole

from .registry import MEASUREMENTS
from .table import conditions, table

BEGIN, END = "<!-- figures: written by python -m benchmarks -->", "<!-- /figures -->"
PAGE, PICTURE = Path("docs/benchmarks.md"), Path("docs/images/benchmarks.png")


def kept_results(folder: Path) -> list[dict[str, Any]]:
    """What has been measured, in the order of the registry."""
    paths = [folder / f"{measurement.name}.json" for measurement in MEASUREMENTS]
    return [json.loads(path.read_text(encoding="utf-8")) for path in paths if path.exists()]


def figures(results: list[dict[str, Any]]) -> str:
    """What stands between the markers."""
    how = "ratio is the cost of ours over theirs, so below 1 ours is cheaper; each is the median of ratios taken round "
    how += "by round, beside its quartiles."
    return f"{conditions(results)}\n\n{how[0].upper()}{how[1:]}\n\n{table(results)}\n"


def write_page(root: Path, folder: Path) -> None:
    """Write the figures into the page, and the picture beside it.

    Parameters
    ----------
    root : of the project
    folder : with the JSON files
    """
    from .picture import draw

    results = kept_results(folder)
    if not results:
        return
    page = root / PAGE
    text = page.read_text(encoding="utf-8")
    before, _, rest = text.partition(BEGIN)
    after = rest.partition(END)[2]
    write_whole(page, f"{before}{BEGIN}\n\n{figures(results)}\n{END}{after}")
    draw(results, root / PICTURE)
