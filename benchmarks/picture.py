"""The picture: every ratio on one logarithmic axis; left of 1 ours is cheaper."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

COLOURS = ("#1f5fa8", "#c0561a", "#2c8a4b", "#8a3fa0", "#7a6a20", "#b02a4c")


def groups(results: Sequence[dict[str, Any]]) -> list[tuple[str, list[tuple[str, list[dict[str, Any]]]]]]:
    """Lines of the picture: per measurement, rows that differ in size only share a line."""
    found = []
    for result in results:
        lines: dict[str, list[dict[str, Any]]] = {}
        for row in result["rows"]:
            if row["ratio"] is not None and min(row["ratio"], row["low"]) > 0:
                peer = row["peer"].partition(", step")[0]
                lines.setdefault(f"{row['what'].partition(', step')[0]}  /  {peer}", []).append(row)
        if lines:
            found.append((result["title"], list(lines.items())))
    return found


def draw(results: Sequence[dict[str, Any]], path: Path) -> None:
    """Write the picture.

    Parameters
    ----------
    results : of the measurements
    path : of the PNG file
    """
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    parts = groups(results)
    height = sum(len(lines) + 1.6 for _, lines in parts)
    figure, axes = plt.subplots(figsize=(11, 0.24 * height + 1.2))
    y, ticks, names = 0.0, [], []
    for number, (title, lines) in enumerate(parts):
        colour = COLOURS[number % len(COLOURS)]
        axes.text(0.0, y, f" {title}", transform=axes.get_yaxis_transform(), weight="bold", color=colour, va="center")
        y += 1
        for name, rows in lines:
            ratios = [row["ratio"] for row in rows]
            axes.plot([min(ratios), max(ratios)], [y, y], color=colour, lw=0.8, alpha=0.5)
            for place, row in enumerate(rows):
                axes.plot([row["low"], row["high"]], [y, y], color=colour, lw=3, alpha=0.35, solid_capstyle="butt")
                axes.plot(row["ratio"], y, "o", color=colour, ms=3 + 4 * place / max(1, len(rows) - 1))
            ticks.append(y)
            names.append(name)
            y += 1
        y += 0.6
    axes.axvline(1.0, color="black", lw=0.8)
    axes.set(xscale="log", ylim=(y, -1.0), xlabel="cost of ours over cost of theirs; larger dots: larger size")
    axes.set_yticks(ticks, names, fontsize=7)
    axes.grid(axis="x", alpha=0.3)
    axes.spines[["top", "right"]].set_visible(False)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110, bbox_inches="tight", metadata={"Software": None})
    plt.close(figure)
