"""How quick is what people look at?  `python benchmarks/seeing.py` prints the table; needs chromium and selenium.

Every time stands beside a floor of the same run: bare Python for `psp --help`, an empty page for the reports.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from psp_cli.options import network_file  # noqa: E402
from psp_cli.settings import setup  # noqa: E402
from psp_view.cases import comparison, run_case  # noqa: E402
from psp_view.report import write_report  # noqa: E402
from view.browser import browser  # noqa: E402

REPEATS = 9
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


def median_of(call: Callable[[], float]) -> float:
    """The median of a few calls."""
    return statistics.median(call() for _ in range(REPEATS))


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
        write_report((cases * 2)[:4], found[name], "python benchmarks/seeing.py", trained)
    empty = folder / "empty.html"
    text = "<script>performance.mark('ready'); document.documentElement.dataset.ready = 'yes'</script>"
    empty.write_text(f"<!doctype html>{text}", encoding="utf-8")
    return {"an empty page": empty, **found}


def main() -> list[tuple[str, str]]:
    """Measure and print the table; its rows come back."""
    rows = [
        ("psp --help", f"{median_of(lambda: seconds('-m', 'psp_cli', '--help')):.3f} s"),
        ("python -c pass, the floor", f"{median_of(lambda: seconds('-c', 'pass')):.3f} s"),
    ]
    with tempfile.TemporaryDirectory() as folder, browser() as driver:
        for name, path in reports(Path(folder)).items():
            took = median_of(lambda path=path: opening(driver, path.as_uri()))
            rows.append((f"opening {name}, {path.stat().st_size / 1e6:.2f} MB", f"{took:.3f} s"))
            if "runs" in name:
                rows.append((f"animating {name}", f"{driver.execute_async_script(FRAMES):.0f} frames/s"))
    for row in rows:
        print("| " + " | ".join(row) + " |")
    return rows


if __name__ == "__main__":
    main()
