"""A page in real Chromium, driven with selenium: what a reader sees and does."""

from __future__ import annotations

import base64
import json
import os
import shutil
import time
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.remote.webelement import WebElement

PATIENCE = 60.0  # seconds for a page to be ready; how fast it is here is no matter of tests
FLAGS = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
         "--disable-component-update", "--disable-sync", "--window-size=1280,900")  # fmt: skip


def chromium(profile: Path) -> webdriver.Chrome:
    """A browser with an empty profile; without Chromium the test is skipped, in CI it fails."""
    programs = [shutil.which(name) for name in ("chromium", "chromedriver")]
    if not all(programs):
        if os.environ.get("CI") == "true":
            pytest.fail("Chromium is missing; apt-get install chromium chromium-driver")
        pytest.skip("no chromium and chromedriver here (apt-get install chromium chromium-driver)")
    options = webdriver.ChromeOptions()
    options.binary_location = str(programs[0])
    for flag in (*FLAGS, f"--user-data-dir={profile}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    return webdriver.Chrome(options=options, service=webdriver.ChromeService(str(programs[1])))


class Reader:
    """One who opens ``page`` and looks at it."""

    def __init__(self, driver: webdriver.Chrome, page: Path) -> None:
        self.driver, self.address = driver, page.resolve().as_uri()
        for kind in ("browser", "performance"):
            driver.get_log(kind)  # what was said before is not of this page
        driver.get("about:blank")
        driver.get(self.address)
        end = time.monotonic() + PATIENCE
        while not self.run("return document.documentElement.dataset.ready"):
            assert time.monotonic() < end, self.complaints()
            time.sleep(0.02)

    def run(self, script: str, *arguments: Any) -> Any:
        return self.driver.execute_script(script, *arguments)

    def find(self, selector: str) -> WebElement:
        """The first that is displayed."""
        return next(one for one in self.driver.find_elements(By.CSS_SELECTOR, selector) if one.is_displayed())

    def control(self, name: str) -> WebElement:
        return self.find(f'[data-control="{name}"]')

    def settle(self) -> None:
        """Until two more pictures were drawn."""
        self.driver.execute_async_script("const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(done));")

    def point(self, element: WebElement, x: float, y: float) -> ActionChains:
        """The mouse at (x, y) from the upper left corner of ``element``; more can follow."""
        self.run("arguments[0].scrollIntoView({block: 'center'})", element)
        size = element.rect
        return ActionChains(self.driver, duration=0).move_to_element_with_offset(
            element, round(x - size["width"] / 2), round(y - size["height"] / 2)
        )

    def pixels(self, canvas: WebElement) -> np.ndarray:
        """(H, W, 3) bytes of a canvas as it is now."""
        self.settle()
        data = self.run("return arguments[0].toDataURL('image/png')", canvas).split(",", 1)[1]
        return np.asarray(Image.open(BytesIO(base64.b64decode(data))).convert("RGB"))

    def cdp(self, command: str, **arguments: Any) -> Any:
        return self.driver.execute_cdp_cmd(command, arguments)

    def complaints(self) -> list[str]:
        """Errors and warnings in the console since the page was opened."""
        return [entry["message"] for entry in self.driver.get_log("browser")]

    def requests(self) -> list[str]:
        """What the page asked for, from anywhere."""
        events = [json.loads(entry["message"])["message"] for entry in self.driver.get_log("performance")]
        asked = [event["params"]["request"]["url"] for event in events if event["method"] == "Network.requestWillBeSent"]
        # the browser's own empty tab is no part of the page
        return [url for url in asked if not url.startswith(("data:", "about:blank", "chrome"))]
