"""The tables of `psp sumo`: drawn on a terminal, as Markdown where they are piped on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from .output import console, say

if TYPE_CHECKING:
    from psp_traffic.measures import Measures
    from psp_traffic.sweep import Case, Tolerance


def show_measures(title: str, drivers: Mapping[str, Sequence[Measures]]) -> None:
    """A table of one situation; on a terminal a column for each driver, which is narrower than a line for each.

    Parameters
    ----------
    title : of the table
    drivers : the starts' measures by name of the driver
    """
    from psp_traffic.summary import cells, table

    screen = console()
    if not screen.is_terminal:
        say(f"{title}\n\n{table(drivers)}\n")
        return
    titles, *rows = cells(drivers).values()
    _draw(screen, title.replace("**", ""), ["", *drivers], zip(titles, *rows, strict=True))


def show_tolerances(title: str, found: Mapping[Case, Tolerance]) -> None:
    """The tables of a sweep, one for each driver, with how contacts were announced below each.

    Parameters
    ----------
    title : of the sweep
    found : from `psp_traffic.sweep.sweep`
    """
    from psp_traffic.sweep import cells, sweep_text, swept_of, told_of

    screen = console()
    if not screen.is_terminal:
        say(f"**{title}**\n\n{sweep_text(found)}\n")
        return
    for driver in swept_of(found):
        head, *rows = cells(found, driver)
        _draw(screen, f"{title}: {driver}", head, rows)
        say(told_of(found, driver) + "\n")


def _draw(screen: Any, title: str, head: Sequence[str], rows: Any) -> None:
    from rich.markup import escape
    from rich.table import Table

    drawn = Table(title=escape(title), title_justify="left")
    for number, name in enumerate(head):
        drawn.add_column(escape(name), justify="right" if number else "left")
    for row in rows:
        drawn.add_row(*map(escape, row))
    screen.print(drawn)
