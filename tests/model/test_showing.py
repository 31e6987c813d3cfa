"""What a run shows of itself: a table where it is printed, a picture in a notebook, both of the run's own numbers."""

from __future__ import annotations

import re
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from psp_model import Lemma1Policy, Sampling, simulate
from psp_model.figures import Figure, figures_table, largest, smallest, warned
from psp_model.run import Run
from psp_model.show import COLOURS, figure, picture
from strategies import paper_start

SVG = "{http://www.w3.org/2000/svg}"


def run_of(n: int, duration: float = 0.3) -> Run:
    return simulate(paper_start(n, n), "fixed", duration=duration, sampling=Sampling(policy=Lemma1Policy.WARN))


def lines_of(html: str) -> list[list[Any]]:
    """The lines of each panel, in order; that the whole is well-formed is checked on the way."""
    root = ElementTree.fromstring(html)
    panels = [group for group in root.iter(f"{SVG}g") if group.find(f"{SVG}rect") is not None]
    return [panel.findall(f"{SVG}polyline") for panel in panels]


def shown(text: str) -> dict[str, str]:
    """Label and value of each line of a table."""
    found = (re.fullmatch(r"  (.*?) {2,}(.*)", line) for line in text.splitlines()[1:])
    return {one[1]: one[2] for one in found if one}


@pytest.mark.parametrize("n", [1, 2, 7, 100])
def test_printed_a_run_is_the_table_of_its_figures(n: int) -> None:
    run = run_of(n)
    assert str(run) == repr(run) and repr(run).splitlines()[0].startswith(f"Run of {n} vehicle")
    table = shown(repr(run))
    assert list(table) == [one.label for one in run.figures()]
    for one in run.figures():
        value, _, unit = table[one.label].partition(" ")
        assert unit == ("" if one.unit == "1" else one.unit)
        assert np.isnan(one.value) == (value == "nan") and (n > 1 or "spacing" in one.label or value != "nan")
        assert value == "nan" or float(value) == pytest.approx(one.value, rel=1e-3)


@pytest.mark.parametrize("n", [2, 5])
def test_figures_are_the_numbers_of_the_run(n: int) -> None:
    run = run_of(n, 3.0)
    found = {one.label: one.value for one in run.figures()}
    assert found == {
        "smallest final spacing": min(run.s[-1].tolist()),
        "largest final spacing": max(run.s[-1].tolist()),
        "smallest spacing": min(run.s.ravel().tolist()),
        "peak |acceleration|": max(abs(a) for a in run.a.ravel().tolist()),
        "largest speed": max(run.v.ravel().tolist()),
        "J": run.cost[-1, 0] + run.cost[-1, 1],
        "J, acceleration term": run.cost[-1, 0],
        "J, spacing term": run.cost[-1, 1],
        "smallest T_max": min(run.T_max.tolist()),
        "instants not certified": run.violations,
    }
    assert found["J"] == run.J


@pytest.mark.parametrize("n", [1, 2, 7, 100])
def test_the_picture_has_a_line_for_every_vehicle_and_says_whose(n: int) -> None:
    run = run_of(n)
    panels = lines_of(run._repr_html_())
    assert [len(lines) for lines in panels] == [n - 1, n, n]
    for lines, first in zip(panels, (2, 1, 1), strict=True):
        named = [line.find(f"{SVG}title").text for line in lines]
        assert named == [f"vehicle {i}" for i in range(first, n + 1)]
        drawn = [(line.get("stroke"), line.get("stroke-dasharray")) for line in lines]
        expected = [COLOURS[(i - 1) % len(COLOURS)] for i in range(first, n + 1)]
        assert [colour for colour, _ in drawn] == expected
        assert len(set(drawn)) == min(len(drawn), 21) or n == 100
    if n > 1:  # a vehicle has one colour in all panels
        assert [line.get("stroke") for line in panels[0]] == [line.get("stroke") for line in panels[1]][1:]


def test_lines_go_where_the_numbers_are() -> None:
    time, table = np.array([0.0, 1.0, 2.0]), np.array([[0.0, 10.0], [5.0, 10.0], [10.0, 0.0]])
    ((one, two),) = lines_of(picture(time, {"speed [m/s]": table}))
    first, second = ([tuple(map(float, p.split(","))) for p in line.get("points").split()] for line in (one, two))
    assert [x for x, _ in first] == [x for x, _ in second] == [0.0, 150.0, 300.0]
    assert first[0][1] > first[1][1] > first[2][1] and second[0][1] == second[1][1] == first[2][1]
    assert first[0][1] == second[2][1] and first[1][1] == pytest.approx((first[0][1] + first[2][1]) / 2, abs=0.1)
    assert all(0 <= y <= 180 for _, y in first + second)


@pytest.mark.parametrize(
    ("time", "values"),
    [([0.0], [[3.0, 4.0]]), ([0.0, 1.0], [[5.0], [5.0]]), ([1e6, 1e6 + 1], [[1e-9], [2e-9]]), ([0.0, 1.0], [[], []])],
)
def test_a_picture_of_one_instant_of_equal_numbers_or_of_none_is_one_still(time: Any, values: Any) -> None:
    html = picture(np.array(time), {"spacing [m]": np.array(values), "speed [m/s]": np.zeros((len(time), 2))})
    assert [len(lines) for lines in lines_of(html)] == [len(values[0]), 2] and "nan" not in html and "inf" not in html


def test_long_runs_are_drawn_with_as_many_points_as_can_be_seen() -> None:
    time = np.linspace(0.0, 200.0, 20_001)
    ((line,),) = lines_of(picture(time, {"speed [m/s]": np.sin(time)[:, None]}))
    assert 400 <= len(line.get("points").split()) <= 801


def test_text_around_a_picture_cannot_become_markup() -> None:
    root = ElementTree.fromstring(figure(picture(np.array([0.0, 1.0]), {"x": np.ones((2, 1))}), ["a < b & c > d"]))
    assert "a < b & c > d" in "".join(root.itertext())


def test_a_table_lines_up_and_leaves_out_units_of_1() -> None:
    figures = [Figure("J", "1", 12.34567), Figure("peak |acceleration|", "m/s²", 0.0), Figure("T", "s", float("nan"))]
    assert figures_table("title", figures).splitlines() == [
        "title",
        "  J                    12.35",
        "  peak |acceleration|  0 m/s²",
        "  T                    nan s",
    ]


def test_the_first_warning_is_shown_and_the_others_counted() -> None:
    assert warned([]) == []
    assert warned(["one"]) == ["  warning: one"] and warned(["one", "two", "three"]) == ["  warning: one (and 2 more)"]


def test_smallest_and_largest_of_nothing_are_no_numbers() -> None:
    nothing, some = np.empty((3, 0)), np.array([[2.0, -1.0], [7.0, 3.0]])
    assert np.isnan([smallest(nothing), largest(nothing)]).all()
    assert (smallest(some), largest(some)) == (-1.0, 7.0)
