"""Headless Chromium for the tests of pages."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from shutil import which
from typing import Any

CHROMIUM, DRIVER = which("chromium"), which("chromedriver")


@contextmanager
def browser(width: int = 1280, height: int = 900, dark: bool = False) -> Iterator[Any]:
    """Debian's Chromium with an empty profile and no wish to talk to the network."""
    from selenium import webdriver
    from selenium.webdriver.chrome.options import Options
    from selenium.webdriver.chrome.service import Service

    options = Options()
    options.binary_location = str(CHROMIUM)
    quiet = "--disable-quic --no-first-run --disable-background-networking --disable-component-update --disable-sync"
    for flag in f"--headless --no-sandbox --disable-dev-shm-usage {quiet} --hide-scrollbars".split():
        options.add_argument(flag)
    options.add_argument("--enable-unsafe-swiftshader")  # WebGL without a graphics card
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        options.add_argument(f"--user-data-dir={profile}")
        driver = webdriver.Chrome(options=options, service=Service(str(DRIVER)))
        try:
            resize(driver, width, height)
            set_dark(driver, dark)
            yield driver
        finally:
            driver.quit()


def resize(driver: Any, width: int, height: int) -> None:
    """Give the page a size of its own, narrower than a window may be."""
    metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)


def set_dark(driver: Any, dark: bool) -> None:
    """Make the page believe that the user prefers dark, or light, colours."""
    feature = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [feature]})


def errors(driver: Any) -> list[str]:
    """What the page complained of in the console so far."""
    return [entry["message"] for entry in driver.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")]


def screenshot(driver: Any, path: Path) -> None:
    """The whole page as a PNG, however long it is."""
    import base64

    size = driver.execute_script("return [innerWidth, document.documentElement.scrollHeight]")
    resize(driver, size[0], size[1])
    shot = driver.execute_cdp_cmd("Page.captureScreenshot", {"captureBeyondViewport": True})
    path.write_bytes(base64.b64decode(shot["data"]))
