"""How quick is what people look at: bare Python is the floor for `psp --help`, an empty page for the reports.

Needs chromium and selenium.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from psp_cli.options import network_file  # noqa: E402
from psp_cli.settings import setup  # noqa: E402
from psp_model.analysis.cases import comparison, run_case  # noqa: E402
from psp_view.report import write_report  # noqa: E402
from view.browser import browser  # noqa: E402

from .registry import Context  # noqa: E402
from .rounds import Row, interleave, row  # noqa: E402

READY = "return document.documentElement.dataset.ready === 'yes'"
FRAMES = """
const done = arguments[0], began = performance.now();
let frames = 0;
psp.road.show(0);
psp.road.toggle();
(function count() {
  frames += 1;
  if (performance.now() - began < 3000) return requestAnimationFrame(count);
  psp.road.toggle();
  done(frames / 3);
})();
"""


def seconds(*arguments: str) -> float:
    """How long Python runs with these arguments."""
    began = time.perf_counter()
    subprocess.run([sys.executable, *arguments], cwd=ROOT, capture_output=True, check=True)
    return time.perf_counter() - began


def opening(driver: Any, address: str) -> float:
    """From asking for a page to its being ready, by the page's own clock."""
    driver.get(address)
    while not driver.execute_script(READY):
        time.sleep(0.01)
    return float(driver.execute_script("return performance.getEntriesByName('ready')[0].startTime / 1000"))


def reports(folder: Path) -> dict[str, Path]:
    """The reports to open, by what they hold."""
    network = network_file(7, None)
    found = {}
    for name, vehicles, trained in (("4 runs of 7 vehicles", 7, network), ("4 runs of 100 vehicles", 100, None)):
        cases = [
            run_case(k, s, trained) for k, s in comparison(setup({}, vehicles, trained is not None), trained).items()
        ]
        found[name] = folder / f"{vehicles}.html"
        write_report((cases * 2)[:4], found[name], "python -m benchmarks seeing", trained)
    empty = folder / "empty.html"
    text = "<script>performance.mark('ready'); document.documentElement.dataset.ready = 'yes'</script>"
    empty.write_text(f"<!doctype html>{text}", encoding="utf-8")
    return {"an empty page": empty, **found}


def measure(context: Context) -> list[Row]:
    """All lines of this measurement."""
    shell = {"psp": lambda: seconds("-m", "psp_cli", "--help"), "python": lambda: seconds("-c", "pass")}
    found = interleave(shell, context.rounds(9))
    rows = [row("psp --help", "", "python -c pass", found["psp"], found["python"], "s")]
    with tempfile.TemporaryDirectory() as folder, browser() as driver:
        pages = reports(Path(folder))
        opened = {name: (lambda path=path: opening(driver, path.as_uri())) for name, path in pages.items()}
        found = interleave(opened, context.rounds(9))
        for name, path in list(pages.items())[1:]:
            size, pair = f"{path.stat().st_size / 1e6:.2f} MB", (found[name], found["an empty page"])
            rows.append(row(f"opening a report of {name}", size, "an empty page", *pair, "s"))
            opening(driver, path.as_uri())
            frames = driver.execute_async_script(FRAMES)
            rows.append(Row(f"animating {name}", size, "", frames, None, "frames/s", None, None, None, 1))
    return rows
