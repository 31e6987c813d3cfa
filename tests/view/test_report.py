"""The report: one file, the same each time, nothing from outside, and thinned lines within their bound."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from psp_cli.options import network_file
from psp_cli.settings import setup
from psp_model.analysis.cases import comparison, figures, run_case
from psp_view.film import FilmError, bodies, frame_times, write_film, writer_for
from psp_view.report import report_html
from psp_view.report.thin import kept, rounded

COMMAND = "psp report --set 'T=10 ms' -o <out>.html"


@pytest.fixture(scope="module")
def cases():
    one = setup({}, 7, has_network=False)
    return [run_case(name, each, None, 3.0) for name, each in comparison(one, None).items()]


@pytest.fixture(scope="module")
def page(cases):
    return report_html(cases, COMMAND)


def packed(page: str):
    text = re.search(r'id="data-packed">([^<]*)<', page)[1]
    return json.loads(gzip.decompress(base64.b64decode(text)))


def test_nothing_is_fetched_from_anywhere(page):
    assert not re.search(r"""(?:src|href)\s*=\s*["'](?!data:)""", page)
    assert not re.search(r"@import|url\(\s*['\"]?(?!data:)", page)
    assert '<link rel="icon" href="data:,">' in page


def test_a_report_of_four_runs_is_small():
    """4 runs, 7 vehicles, 20 s: far below 5 MB; the network of the repository makes it four."""
    network = network_file(7, None)
    four = comparison(setup({}, 7), network)
    assert len(four) == 4
    text = report_html([run_case(name, each, network) for name, each in four.items()], COMMAND, network)
    assert len(text.encode()) < 1e6
    assert hashlib.sha256(network.path.read_bytes()).hexdigest() in text


def test_the_licence_of_what_is_embedded_is_embedded(page):
    assert "Copyright (c) 2022 Leon Sorokin" in page


def test_the_same_runs_give_the_same_bytes(cases, page):
    assert report_html(cases, COMMAND) == page


def test_text_from_outside_is_escaped(page, cases):
    assert "psp report --set &#x27;T=10 ms&#x27; -o &lt;out&gt;.html" in page
    assert "<script>x" not in report_html(cases, COMMAND, title="<script>x")


def test_the_summary_holds_the_figures(cases, page):
    table = re.search(r"<table id='summary'>.*?</table>", page)[0]
    for case in cases:
        for figure in figures(case):
            assert f"<td>{figure.value:.6g}</td>" in table


def test_versions_hashes_and_sources_are_there(page):
    for text in (
        "psp-platoon",
        "commit ",
        "results, SHA-256",
        "paper, section V",
        "ours: equal to z",
        "alpha_fixed, r_fixed, p_fixed",
    ):
        assert text in page


def test_other_inputs_and_other_results_have_other_hashes(cases, page):
    other = [run_case(case.name, setup({"mu": 0.6}, 7, has_network=False), None, 3.0) for case in cases]
    find = re.compile(r"(\w+), SHA-256</th><td class='hash'>(\w+)")
    before, after = dict(find.findall(page)), dict(find.findall(report_html(other, COMMAND)))
    assert before["inputs"] != after["inputs"] and before["results"] != after["results"]
    assert "set by the user" in report_html(other, COMMAND)


def test_lines_on_the_page_are_the_runs_within_the_bound(cases, page):
    for case, drawn in zip(cases, packed(page)["runs"], strict=True):
        for field, table in (("spacing", case.run.s), ("acceleration", case.run.a), ("speed", case.run.v)):
            lines = np.array(drawn[field]["y"]).T
            back = np.column_stack([np.interp(case.run.time, drawn[field]["t"], line) for line in lines.T])
            assert np.abs(back - table).max() <= 6e-4 * np.ptp(table)


@settings(max_examples=50, deadline=None)
@given(st.lists(st.floats(-100, 100), min_size=2, max_size=60), st.floats(1e-4, 0.3))
def test_thinning_keeps_its_promise(values, tolerance):
    time = np.arange(len(values), dtype=float)
    lines = np.column_stack([values, np.cumsum(values)])
    keep = kept(time, lines, tolerance)
    assert keep[0] == 0 and keep[-1] == len(values) - 1
    back = np.column_stack([np.interp(time, time[keep], line[keep]) for line in lines.T])
    spread = np.ptp(lines) or 1.0
    assert np.abs(back - lines).max() <= tolerance * spread * (1 + 1e-9)
    assert np.abs(rounded(lines, tolerance) - lines).max() <= 0.1 * tolerance * spread


def test_a_straight_line_keeps_its_ends_only():
    time = np.linspace(0.0, 20.0, 2001)
    assert kept(time, np.column_stack([time, -time])).tolist() == [0, 2000]


def test_a_film_has_a_frame_per_time_and_drawn_vehicles_do_not_touch(cases, tmp_path):
    path = tmp_path / "road.gif"
    short = [run_case(case.name, case.setup, None, 0.4) for case in cases]
    write_film(short, path)
    film = Image.open(path)
    assert film.n_frames == len(frame_times(0.4)) == 7
    corners = bodies(np.array([10.0, 4.9]), 0.84 * 5.0)  # spacings above L
    assert corners[0][0][0] > corners[1][1][0]


def test_the_ending_of_a_film_is_read_in_any_case():
    from matplotlib.animation import PillowWriter

    assert isinstance(writer_for(Path("road.GIF")), PillowWriter)


def test_a_film_of_another_kind_is_refused():
    with pytest.raises(FilmError, match=r"neither \.mp4 nor \.gif"):
        writer_for(Path("road.avi"))
