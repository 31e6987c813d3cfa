"""The small picture that a run shows of itself in a notebook, as SVG without any drawing library."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#888888")  # Okabe and Ito (2008)
_WIDTH, _HEIGHT, _LEFT, _TOP, _BOTTOM, _BETWEEN = 300, 180, 44, 22, 30, 16
_MOST_POINTS = 400  # per line: more cannot be seen


def picture(time: NDArray[np.float64], panels: Mapping[str, NDArray[np.float64]]) -> str:
    """Panels side by side, a line per vehicle.

    Parameters
    ----------
    time : (K,) [s]
    panels : (K, n) arrays by title; where a panel has a line fewer, it is the leader's that is missing

    Returns
    -------
    an SVG element
    """
    most = max(table.shape[1] for table in panels.values())
    every = max(1, len(time) // _MOST_POINTS)
    step = _LEFT + _WIDTH + _BETWEEN
    parts = []
    for place, (title, table) in enumerate(panels.items()):
        lines = _panel(time[::every], table[::every], title, first=most - table.shape[1])
        parts.append(f'<g transform="translate({place * step + _LEFT},{_TOP})">{lines}</g>')
    width, height = step * len(panels), _TOP + _HEIGHT + _BOTTOM
    style = "font:11px sans-serif;max-width:100%;height:auto"
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" style="{style}">'
    return head + "".join(parts) + "</svg>"


def _panel(time: NDArray[np.float64], table: NDArray[np.float64], title: str, first: int) -> str:
    """One panel, its corner at the origin."""
    low, high = (float(table.min()), float(table.max())) if table.size else (0.0, 1.0)
    margin = 0.05 * (high - low) or 0.5
    low, high = low - margin, high + margin
    begin, end = float(time[0]), float(time[-1])
    x = (time - begin) / ((end - begin) or 1.0) * _WIDTH
    y = (high - table) / (high - low) * _HEIGHT
    grey = 'fill="currentColor" opacity="0.75"'
    parts = [f'<rect width="{_WIDTH}" height="{_HEIGHT}" fill="none" stroke="currentColor" opacity="0.4"/>']
    parts.append(f'<text x="{_WIDTH / 2}" y="-7" text-anchor="middle" {grey}>{title}</text>')
    for value, place in ((high, 10), (low, _HEIGHT)):
        parts.append(f'<text x="-4" y="{place}" text-anchor="end" {grey}>{value:.3g}</text>')
    for value, place, anchor in ((begin, 0, "start"), (end, _WIDTH, "end")):
        parts.append(f'<text x="{place}" y="{_HEIGHT + 14}" text-anchor="{anchor}" {grey}>{value:g} s</text>')
    for i, line in enumerate(y.T):
        points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, line, strict=True))
        colour, name = COLOURS[(first + i) % len(COLOURS)], f"<title>vehicle {first + i + 1}</title>"
        parts.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="1.4">{name}</polyline>')
    return "".join(parts)
