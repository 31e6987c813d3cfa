"""The table, in Markdown."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

HEAD = "| what | size | beside | ours | theirs | unit | ratio | quartiles |\n|---|---|---|--:|--:|---|--:|---|"


def number(value: float | None) -> str:
    """Three digits, no exponent where it can be helped."""
    if value is None:
        return ""
    if value != 0 and not 1e-3 <= abs(value) < 1e6:
        return f"{value:.1e}"
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"


def line(row: dict[str, Any]) -> str:
    """One line."""
    quartiles = "" if row["low"] is None else f"{number(row['low'])} to {number(row['high'])}"
    ratio = "" if row["ratio"] is None else f"**{number(row['ratio'])}**"
    what = row["what"] + (f" ({row['note']})" if row["note"] else "")
    cells = [what, row["size"], row["peer"], number(row["ours"]), number(row["theirs"]), row["unit"], ratio, quartiles]
    return "| " + " | ".join(cells) + " |"


def table(results: Sequence[dict[str, Any]]) -> str:
    """All lines under one head; each measurement begins with its title and its command."""
    lines = [HEAD]
    for result in results:
        lines.append(f"| **{result['title']}** | | `{result['command']}` | | | | | |")
        lines += [line(row) for row in result["rows"]]
    return "\n".join(lines)


def conditions(results: Sequence[dict[str, Any]]) -> str:
    """Machine, versions, dates and load, in a sentence or two."""
    machine, versions = results[0]["machine"], {}
    for result in results:
        versions |= result["versions"]
    dates = sorted(result["date"] for result in results)
    loads = [result["machine"]["load_average_before"] for result in results]
    listed = ", ".join(f"{name} {version}" for name, version in versions.items())
    minutes = sum(result["seconds"] for result in results) / 60
    return (
        f"{machine['processor']}, {machine['cores']} cores, {machine['memory_gib']} GiB, {machine['system']}; "
        f"{listed}. Measured from {dates[0]} to {dates[-1]}, {minutes:.0f} minutes in all; "
        f"load average before each part {min(loads):.1f} to {max(loads):.1f}."
    )
