# SPDX-License-Identifier: Apache-2.0
"""Chromium without a window, for tests of the status page: what it shows, and what it says was wrong."""

import os
import shutil
import time

from demo_plant import PATIENCE

try:
    from selenium import webdriver
    from selenium.common.exceptions import StaleElementReferenceException
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.by import By
except ImportError:
    webdriver = None

FLAGS = (
    "--headless=new --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --disable-dev-shm-usage --hide-scrollbars --force-color-profile=srgb"
).split()
WIDE, PHONE = (1280, 900), (390, 844)
# Runs before the page does, whatever its policy says.
WATCH = """
window.violations = [];
document.addEventListener("securitypolicyviolation", (event) =>
  window.violations.push(`${event.violatedDirective}: ${event.blockedURI}`));
window.addEventListener("error", (event) => window.violations.push(`error: ${event.message}`));
window.addEventListener("unhandledrejection", (event) => window.violations.push(`rejection: ${event.reason}`));
"""


def missing():
    """Why there can be no browser here, or nothing."""
    if webdriver is None:
        return "python3-selenium is not installed"
    for program in ("chromium", "chromedriver"):
        if shutil.which(program) is None:
            return f"{program} is not installed (chromium-driver)"
    return ""


class Browser:
    """with Browser() as browser: ..."""

    def __enter__(self):
        options = webdriver.ChromeOptions()
        options.binary_location = shutil.which("chromium")
        # Its sandbox is not for root, and the page is our own.
        for flag in FLAGS + (["--no-sandbox"] if os.geteuid() == 0 else []):
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
        self.driver.set_script_timeout(PATIENCE)
        self.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": WATCH})
        return self

    def __exit__(self, *_):
        self.driver.quit()

    def open(self, url, size=WIDE, scheme="light"):
        self.resize(size)
        self.emulate(**{"prefers-color-scheme": scheme})
        self.driver.get(url)
        self.wait_for("the first status", lambda: self.js("return document.querySelector('#device-list article') !== null"))

    def resize(self, size):
        width, height = size
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600})

    def emulate(self, **features):
        listed = [{"name": name, "value": value} for name, value in features.items()]
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": listed})

    def js(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def wait_for(self, what, holds):
        """What `holds` gives, once that is something."""
        limit = time.monotonic() + PATIENCE
        while True:
            try:
                if found := holds():
                    return found
            except StaleElementReferenceException:
                pass  # the page has gone on
            if time.monotonic() >= limit:
                raise AssertionError(f"the page does not show {what}, but:\n{self.text('body')}")
            time.sleep(0.05)

    def find(self, selector):
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def text(self, selector):
        return self.js("return document.querySelector(arguments[0])?.innerText ?? ''", selector)

    def rows(self, body):
        """The cells of the rows of a table, by the words above them, all read at the same moment."""
        return self.js("""
            return [...document.getElementById(arguments[0]).rows].map((row) => Object.fromEntries(
              [...row.cells].map((cell) => [cell.dataset.label, cell.textContent])));""", body)

    def card(self, name):
        """The text of the card of a bus or device, and whether it is called slow."""
        return self.js("""
            const cards = [...document.querySelectorAll("article")];
            const card = cards.find((it) => it.querySelector("h3").textContent === arguments[0]);
            const text = (part) => card?.querySelector(part)?.textContent ?? "";
            return { state: text(".state"), why: text(".why"), slow: text(".slow:not([hidden])") };
            """, name)

    def choose(self, selector, value):
        self.js("""
            const [field, value] = [document.querySelector(arguments[0]), arguments[1]];
            if (field.type === "checkbox") { field.checked = value; } else { field.value = value; }
            field.dispatchEvent(new Event("input", { bubbles: true }));
            field.dispatchEvent(new Event("change", { bubbles: true }));""", selector, value)

    def complaints(self):
        """What was against the policy of the page, and what its console says, since the last call."""
        told = self.js("return window.violations.splice(0)")
        return told + [entry["message"] for entry in self.driver.get_log("browser")]
