"""A real browser without a window, for the tests of pages."""

import json
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

FLAGS = """--headless=new --no-sandbox --disable-gpu --disable-dev-shm-usage --disable-quic --no-first-run
--disable-background-networking --disable-component-update --disable-sync --hide-scrollbars --window-size=1280,860"""


@contextmanager
def opened_browser(folder: Path) -> Iterator[Any]:
    """Chromium with a profile in the folder; skips the test where there is none."""
    program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    driver = shutil.which("chromedriver")
    if not (program and driver):
        assert os.environ.get("CI") != "true", "no chromium and chromedriver, expected both where CI=true"
        pytest.skip("no chromium and chromedriver here")
    from selenium.webdriver import Chrome, ChromeOptions
    from selenium.webdriver.chrome.service import Service

    options = ChromeOptions()
    options.binary_location = program
    for flag in (*FLAGS.split(), f"--user-data-dir={folder}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    with Chrome(options=options, service=Service(executable_path=driver)) as chrome:
        chrome.set_page_load_timeout(100)  # [s]; selenium itself gives up after 120
        chrome.set_script_timeout(100)
        yield chrome


def addresses_asked(chrome: Any) -> set[str]:
    """What pages asked for since the last call: not what they hold themselves, nor what the browser asks of itself."""
    events = [json.loads(entry["message"])["message"] for entry in chrome.get_log("performance")]
    asked = {event["params"]["request"]["url"] for event in events if event["method"] == "Network.requestWillBeSent"}
    return {address for address in asked if not address.startswith(("data:", "about:", "chrome:"))}
