"""The small picture that a run shows of itself in a notebook, as SVG without any drawing library."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#888888")  # Okabe and Ito (2008)
DASHES = ("", "6 3", "2 2")  # for vehicles beyond as many as there are colours
_WIDTH, _HEIGHT, _LEFT, _TOP, _BOTTOM, _BETWEEN = 300, 180, 44, 22, 34, 16
_ENTRY, _ROW = 58, 18  # width and height of an entry of the legend
_MOST_POINTS = 400  # per line: more cannot be seen
_MOST_NAMED = 21  # vehicles in the legend: colours and dashes repeat beyond


def figure(picture: str, lines: Sequence[str]) -> str:
    """A picture below lines of text, as HTML.

    Parameters
    ----------
    picture : an SVG element
    lines : plain text
    """
    text = "".join(f"<div>{escape(line)}</div>" for line in lines)
    return f'<div><div style="font:13px sans-serif;margin:4px 0">{text}</div>{picture}</div>'


def picture(time: NDArray[np.float64], panels: Mapping[str, NDArray[np.float64]]) -> str:
    """Panels side by side, a line per vehicle, and a legend below them.

    Text and frames have the colour of the text around the picture, so that it can be read on light and dark pages.

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
    legend, rows = _legend(most, width - _LEFT)
    parts.append(f'<g transform="translate({_LEFT},{height + 12})">{legend}</g>')
    height += _ROW * rows + 6
    style = "font:12px sans-serif;max-width:100%;height:auto"
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" style="{style}">'
    return head + "".join(parts) + "</svg>"


def _stroke(vehicle: int) -> str:
    """How the line of a vehicle is drawn; vehicles count from 0."""
    dashes = DASHES[vehicle // len(COLOURS) % len(DASHES)]
    dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
    return f'stroke="{COLOURS[vehicle % len(COLOURS)]}"{dashed}'


def _text(words: str, x: float, y: float, anchor: str = "start", weight: str = "normal") -> str:
    return f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}" font-weight="{weight}" fill="currentColor">{words}</text>'


def _legend(vehicles: int, width: int) -> tuple[str, int]:
    """Which line is which vehicle's, its corner at the origin, and how many rows that takes."""
    named = min(vehicles, _MOST_NAMED)
    parts, in_a_row = [_text("vehicle", 0, 4)], width // _ENTRY - 1
    for vehicle in range(named):
        x, y = _ENTRY * (1 + vehicle % in_a_row), _ROW * (vehicle // in_a_row)
        parts.append(f'<line x1="{x}" x2="{x + 20}" y1="{y}" y2="{y}" {_stroke(vehicle)} stroke-width="2.5"/>')
        last = f" ... {vehicles}" if vehicle + 1 == named < vehicles else ""
        parts.append(_text(f"{vehicle + 1}{last}", x + 25, y + 4))
    return "".join(parts), -(-named // in_a_row)


def _panel(time: NDArray[np.float64], table: NDArray[np.float64], title: str, first: int) -> str:
    """One panel, its corner at the origin."""
    low, high = (float(table.min()), float(table.max())) if table.size else (0.0, 1.0)
    margin = 0.05 * (high - low) or 0.5
    low, high = low - margin, high + margin
    begin, end = float(time[0]), float(time[-1])
    x = (time - begin) / ((end - begin) or 1.0) * _WIDTH
    y = (high - table) / (high - low) * _HEIGHT
    parts = [f'<rect width="{_WIDTH}" height="{_HEIGHT}" fill="none" stroke="currentColor" stroke-opacity="0.5"/>']
    parts.append(_text(title, _WIDTH / 2, -8, "middle", "bold"))
    parts += [_text(f"{high:.3g}", -5, 11, "end"), _text(f"{low:.3g}", -5, _HEIGHT, "end")]
    parts += [_text(f"{begin:g}", 0, _HEIGHT + 16), _text(f"{end:g}", _WIDTH, _HEIGHT + 16, "end")]
    parts.append(_text("time [s]", _WIDTH / 2, _HEIGHT + 16, "middle"))
    if low < 0.0 < high:
        zero = high / (high - low) * _HEIGHT
        parts.append(f'<path d="M0 {zero:.1f}H{_WIDTH}" stroke="currentColor" stroke-opacity="0.3"/>')
    for i, line in enumerate(y.T):
        points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, line, strict=True))
        name = f"<title>vehicle {first + i + 1}</title>"
        parts.append(
            f'<polyline points="{points}" fill="none" {_stroke(first + i)} stroke-width="1.6">{name}</polyline>'
        )
    return "".join(parts)
