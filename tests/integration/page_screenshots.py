#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Pictures of the status page for docs/status.md, of simulated drives: one that does not answer, and a slow one.

usage: page_screenshots.py FOLDER; ./dev screenshots does it."""

import base64
import pathlib
import sys

from page_browser import PHONE, Browser, missing
from page_plant import PagePlant

MOST_BYTES = 150_000
PICTURE = (1040, 800)
FULL_PLOT = 40  # transactions of each device, so that there is something to see


def take(browser, file, top, height):
    """The page from the top of this element on."""
    box = browser.js("""
        const box = document.querySelector(arguments[0]).getBoundingClientRect();
        return { y: box.top + scrollY, width: document.documentElement.clientWidth };""", top)
    clip = {"x": 0, "y": max(0, box["y"] - 8), "width": box["width"], "height": height, "scale": 1}
    shot = browser.driver.execute_cdp_cmd("Page.captureScreenshot", {"clip": clip, "captureBeyondViewport": True})
    picture = base64.b64decode(shot["data"])
    assert len(picture) <= MOST_BYTES, f"{file} has {len(picture)} bytes"
    file.write_bytes(picture)
    print(f"{file}: {len(picture)} bytes")


def overview(browser, plant, folder):
    browser.wait_for("enough answers", lambda: sum(
        int(label.split(": ")[1].split()[0]) >= FULL_PLOT
        for label in browser.js("return [...document.querySelectorAll('article canvas')].slice(3).map((it) => it.ariaLabel)")
        if "answers" in label) == 4)
    plant.switch_off("line-c")
    browser.wait_for("the lift as offline", lambda: "offline" in browser.card("lift")["state"] and browser.text("#finding-list"))
    take(browser, folder / "overview.png", "header", 780)
    take(browser, folder / "devices.png", "#devices", 800)


def timeline(browser, folder):
    """Two requests that follow each other closely."""
    browser.choose("#timeline-bus", "line-a")
    browser.wait_for("requests", lambda: len(browser.rows("timeline-rows")) > 4)
    closest = """
        document.getElementById("timeline-pause").click();
        const rows = [...document.getElementById("timeline-rows").rows];
        const silences = rows.map((row) => parseFloat(row.cells[3].textContent));
        const best = silences.indexOf(Math.min(...silences));
        rows[best].querySelector("button").click();
        const out = document.getElementById("timeline-out");
        out.click();
        document.getElementById("decoded-close").click();
        document.activeElement.blur();"""
    browser.js(closest)
    take(browser, folder / "timeline.png", "#timeline", 520)


def main():
    if reason := missing():
        sys.exit(f"page_screenshots.py: {reason}")
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    with PagePlant() as plant, Browser() as browser:
        plant.poll(1, 2, 17, 5)
        browser.open(plant.url, PICTURE)
        overview(browser, plant, folder)
        timeline(browser, folder)
        browser.open(plant.url, PHONE, "dark")
        browser.wait_for("a trace", lambda: browser.rows("timeline-rows") and browser.text("#finding-list"))
        take(browser, folder / "phone.png", "header", 1300)


if __name__ == "__main__":
    main()
