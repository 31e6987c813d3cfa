"""Report and explorer in headless Chromium: they work, their numbers are the model's, the console stays silent."""

from __future__ import annotations

import os
import re
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from psp_cli.settings import setup
from psp_model import BEST_FIXED, PlatoonState, PotentialParameters, StartDomain, simulate
from psp_model.analysis.cases import comparison, figures, run_case
from psp_view.report import write_report
from view.browser import browser, errors, resize, set_dark

pytestmark = pytest.mark.system("chromium")
pytest.importorskip("selenium")

THINNING = 6e-4  # of a plot's range: what the report promises, and rounding


def eventually(true: Callable[[], object], patience: float = 120.0) -> object:
    """Wait for the page; what it shows comes back."""
    deadline = time.monotonic() + patience
    while not (found := true()):
        assert time.monotonic() < deadline, "the page did not get there"
        time.sleep(0.05)
    return found


@pytest.fixture(scope="module")
def cases():
    one = setup({}, 7, has_network=False)
    return [run_case(name, each, None) for name, each in comparison(one, None).items()]


@pytest.fixture(scope="module")
def report(cases, tmp_path_factory):
    """The report, open in a browser."""
    path = tmp_path_factory.mktemp("report") / "report.html"
    write_report(cases, path, "psp report")
    with browser() as driver:
        driver.get(path.as_uri())
        eventually(lambda: driver.execute_script("return document.documentElement.dataset.ready") == "yes")
        yield driver
        assert errors(driver) == []


def text(driver, selector: str) -> str:
    return driver.execute_script("return document.querySelector(arguments[0]).textContent", selector)


def number(words: str) -> float:
    return float(re.search(r"-?\d+\.\d+", words)[0])


def test_the_summary_on_the_page_is_the_models(report, cases):
    rows = report.execute_script(
        "return [...document.querySelectorAll('#summary tbody tr')].map(r => [...r.children].map(c => c.textContent))"
    )
    columns = [figures(case) for case in cases]
    for row, line in zip(rows, zip(*columns, strict=True), strict=True):
        assert row[0].startswith(line[0].label)
        assert [float(cell) for cell in row[1:]] == pytest.approx([figure.value for figure in line], rel=1e-5)


@pytest.mark.parametrize("moment", [0.0, 0.77, 12.3])
def test_scrubbing_shows_the_runs_at_that_time(report, cases, moment):
    report.execute_script(
        "const scrub = document.getElementById('scrub'); scrub.value = arguments[0];"
        "scrub.dispatchEvent(new Event('input'))",
        moment,
    )
    assert text(report, "#clock") == f"{moment:.2f} s"
    for k, case in enumerate(cases):
        run = case.run
        row = int(np.argmin(np.abs(run.time - moment)))
        spacing, push = number(text(report, f"#now-{k}-spacing")), number(text(report, f"#now-{k}-acceleration"))
        assert spacing == pytest.approx(run.s[row].min(), abs=THINNING * np.ptp(run.s) + 0.006)
        assert push == pytest.approx(np.abs(run.a[row]).max(), abs=THINNING * np.ptp(run.a) + 0.006)
        assert number(text(report, f"#now-{k}-T_max")) == pytest.approx(run.T_max[row], rel=0.01, abs=6e-5)


def test_the_animation_plays_pauses_and_ends(report):
    report.execute_script("psp.road.show(0)")
    play = report.find_element("id", "play")
    before = report.execute_script("return document.querySelector('#lanes canvas').toDataURL()")
    play.click()
    eventually(lambda: number(text(report, "#clock")) > 0.3)
    play.click()
    paused = text(report, "#clock")
    assert play.text == "Play"
    time.sleep(0.3)
    assert text(report, "#clock") == paused
    assert report.execute_script("return document.querySelector('#lanes canvas').toDataURL()") != before
    report.execute_script("psp.road.show(19.9)")
    play.click()
    eventually(lambda: text(report, "#clock") == "20.00 s")
    assert play.text == "Play"


@pytest.mark.parametrize("rate", ["0.25", "1", "5"])
def test_the_speed_of_the_animation_is_that_chosen(report, rate):
    """With a clock and frames of the test's own: three frames, 100 ms apart."""
    film = report.execute_script(
        """
        const road = psp.road, frame = window.requestAnimationFrame, now = performance.now;
        let clock = 1000, next = null;
        performance.now = () => clock;
        window.requestAnimationFrame = (callback) => { next = callback; };
        document.getElementById("rate").value = arguments[0];
        road.show(2);
        road.toggle();
        for (let k = 0; k < 3; k++) { clock += 100; next(clock); }
        road.toggle();
        [performance.now, window.requestAnimationFrame] = [now, frame];
        document.getElementById("rate").value = "1";
        return road.time;
        """,
        rate,
    )
    assert film == pytest.approx(2.0 + 0.3 * float(rate), abs=1e-9)


def test_zooming_one_plot_zooms_all_and_chips_hide_vehicles(report):
    report.execute_script("psp.plots.plots.forEach((plot) => psp.plots.draw(plot))")
    eventually(lambda: report.execute_script("return psp.plots.plots.every((plot) => plot.chart.status === 1)"))
    report.execute_script("psp.plots.plots[0].chart.setScale('x', { min: 2, max: 5 })")
    spans = "return psp.plots.plots.filter((p) => p.timed).map((p) => [p.chart.scales.x.min, p.chart.scales.x.max])"
    eventually(lambda: all(span == [2, 5] for span in report.execute_script(spans)))
    report.find_element("id", "whole").click()
    eventually(lambda: all(span == [0, 20] for span in report.execute_script(spans)))
    chip = "document.querySelectorAll('.chip')[2]"
    report.execute_script(f"{chip}.click()")
    shown = "return psp.plots.plots.filter((p) => !p.dashed).map((p) => p.chart.series[4 - p.first].show)"
    assert not any(report.execute_script(shown))
    report.execute_script(f"{chip}.click()")
    assert all(report.execute_script(shown))


def test_a_click_on_a_plot_moves_the_animation(report):
    from selenium.webdriver.common.action_chains import ActionChains

    over = report.execute_script(
        "const plot = psp.plots.plots[0]; psp.plots.draw(plot); plot.box.scrollIntoView(); return plot.chart.over"
    )
    x = report.execute_script(
        "const c = psp.plots.plots[0].chart; return c.valToPos(7.5, 'x') - c.over.clientWidth / 2"
    )
    ActionChains(report).move_to_element_with_offset(over, round(x), 0).click().perform()
    assert report.execute_script("return psp.road.time") == pytest.approx(7.5, abs=0.1)
    assert text(report, ".plot .head span").startswith("7.")


@pytest.mark.parametrize("width", [1280, 400])
@pytest.mark.parametrize("dark", [False, True])
def test_the_page_fits_and_follows_the_theme(report, width, dark):
    resize(report, width, 900)
    set_dark(report, dark)
    sizes = report.execute_script("return [document.documentElement.scrollWidth, innerWidth]")
    assert sizes == [width, width]
    ground = report.execute_script("return getComputedStyle(document.body).backgroundColor")
    assert (sum(map(int, re.findall(r"\d+", ground)[:3])) < 200) is dark


def test_a_hundred_vehicles_stay_usable(tmp_path):
    """Drawn lines are those of the run, and a frame of the animation does not keep the page busy."""
    case = run_case("V_new", setup({}, 100, has_network=False), None, 5.0)
    path = tmp_path / "many.html"
    write_report([case, case], path, "psp report -n 100")
    with browser() as driver:
        driver.get(path.as_uri())
        eventually(lambda: driver.execute_script("return document.documentElement.dataset.ready") == "yes")
        assert driver.execute_script("return psp.data.runs[0].spacing.y.length") == 99
        driver.execute_script("psp.plots.plots.forEach((plot) => psp.plots.draw(plot))")
        driver.find_element("id", "play").click()
        eventually(lambda: text(driver, "#clock") == "5.00 s")
        assert errors(driver) == []


@pytest.fixture(scope="module")
def explorer() -> Iterator[str]:
    """Address of a running explorer."""
    pytest.importorskip("nicegui")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = [sys.executable, "-m", "psp_cli", "explore", "--no-show", "--port", str(port), "--seed", "1"]
    # nicegui changes its behaviour where it sees that pytest runs it
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST", "NICEGUI"))}
    server = subprocess.Popen(command, env=environment)
    address = f"http://127.0.0.1:{port}/"

    def answers() -> bool:
        assert server.poll() is None, "the explorer ended"
        try:
            return bool(urllib.request.urlopen(address, timeout=5).read())
        except (urllib.error.URLError, TimeoutError):
            return False

    try:
        eventually(answers)
        yield address
    finally:
        server.terminate()
        server.wait(20)


def shown(driver) -> dict[str, float]:
    pairs = driver.execute_script(
        "return [...document.querySelectorAll('[data-figure]')].map(e => [e.dataset.figure, e.textContent])"
    )
    return {name: float(value) for name, value in pairs}


def test_a_slider_of_the_explorer_moves_the_model(explorer):
    from selenium.webdriver.common.keys import Keys

    s, v = StartDomain().draw(np.random.default_rng(1), 7, 1)
    start = PlatoonState(s[:, 0], v[:, 0])
    with browser() as driver:
        driver.get(explorer)
        plots = "return document.querySelectorAll('.js-plotly-plot .main-svg').length"
        eventually(lambda: driver.execute_script(plots) >= 6)
        fixed = simulate(start, BEST_FIXED)
        assert eventually(lambda: shown(driver))["J"] == pytest.approx(fixed.J, rel=1e-5)
        thumb = driver.find_element("css selector", ".slider-r [tabindex]")
        for _ in range(3):
            thumb.send_keys(Keys.ARROW_LEFT)
        eventually(lambda: text(driver, ".value-r") == "10.7")
        moved = simulate(start, PotentialParameters(1e-3, 10.7, 5.5))
        assert abs(moved.J / fixed.J - 1.0) > 1e-4
        eventually(lambda: shown(driver).get("J") == pytest.approx(moved.J, rel=1e-5))
        assert shown(driver)["peak |acceleration|"] == pytest.approx(np.abs(moved.a).max(), rel=1e-5)
        lines = driver.execute_script(
            "return document.querySelectorAll('.js-plotly-plot')[0].data.map(d => d.y.at(-1))"
        )
        assert [lines[i] for i in range(6)] == pytest.approx(moved.s[-1].tolist(), abs=1e-9)
        assert driver.execute_script("return document.documentElement.scrollWidth <= innerWidth")
        assert errors(driver) == []


def test_the_explorer_says_what_is_not_feasible(explorer):
    from selenium.webdriver.common.keys import Keys

    with browser(400, 900, dark=True) as driver:
        driver.get(explorer)
        eventually(lambda: shown(driver))
        driver.find_element("css selector", ".slider-p [tabindex]").send_keys(
            Keys.PAGE_UP, Keys.PAGE_UP
        )  # ten steps each
        words = eventually(lambda: text(driver, ".problem"))
        assert "must not exceed z = 4 m/s2" in words
        assert driver.execute_script("return document.documentElement.scrollWidth <= innerWidth")
        assert errors(driver) == []
