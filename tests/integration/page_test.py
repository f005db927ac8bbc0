#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The status page in Chromium, over mbgated and simulated drives. Everything that is looked at is waited for; a violation of
the page's policy, or anything on the console of the browser, fails the test in which it comes."""

import http.client
import pathlib
import re
import signal
import sys
import unittest
import urllib.parse

import page_rules
from control_case import TRACE, EventStream
from demo_plant import PATIENCE
from page_browser import PHONE, WIDE, Browser, missing
from page_plant import ABSENT, LINES, PagePlant

SKIPPED = 77
SOURCES = pathlib.Path(__file__).parents[2] / "src" / "app" / "page"
# What a port may be called: the page shows it as it is.
MARKUP = "line-c <img src=x onerror=window.broken=1>"
NEEDED = {"line-a": 1.75, "line-b": 3.5 * 11 / 19200 * 1000, "line-c": 1.75}  # ms of silence: t3.5


class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.plant = cls.enterClassContext(PagePlant(links={"line-c": MARKUP}, keys="max_streams = 2"))
        cls.browser = cls.enterClassContext(Browser())
        cls.plant.poll(1, 2, 17, 5)

    def setUp(self):
        self.open()

    def tearDown(self):
        self.assertEqual(self.browser.complaints(), [])

    def open(self, size=WIDE, scheme="light"):
        self.browser.open(self.plant.url, size, scheme)

    def wait_for_state(self, device, state):
        self.browser.wait_for(f"{device} as {state}", lambda: state in self.browser.card(device)["state"])
        return self.browser.card(device)

    def traced(self, fits, what):
        """The rows of the trace, once there are some and all of them fit."""
        def rows():
            shown = self.browser.rows("trace-rows")
            return shown if shown and all(fits(row) for row in shown) else None
        return self.browser.wait_for(what, rows)

    def test_a_device_goes_offline_and_comes_back(self):
        self.wait_for_state("lift", "answering")
        self.plant.switch_off("line-c")
        self.addCleanup(self.plant.switch_on, "line-c")
        card = self.wait_for_state("lift", "offline")
        self.assertRegex(card["state"], r"^✕ offline for \d")
        self.assertRegex(card["why"], r"\d requests in a row without an answer")
        self.browser.wait_for("a finding", lambda: (
            "device lift: it does not answer any more" in self.browser.text("#finding-list")))
        self.assertIn("Look at: its power", self.browser.text("#finding-list"))
        self.browser.wait_for("an event", lambda: any(
            row["Event"].startswith("device lift: does not answer any more") for row in self.browser.rows("event-rows")))
        self.assertRegex(self.browser.card("line-c")["why"], "1 of 1 device does not answer")
        self.plant.switch_on("line-c")
        card = self.wait_for_state("lift", "answering")
        self.assertRegex(card["state"], r"^✓ answering for \d")
        self.browser.wait_for("no finding any more", lambda: "lift" not in self.browser.text("#finding-list"))

    def test_a_slow_device_is_pointed_out(self):
        self.browser.wait_for("that the turntable is slow", lambda: self.browser.card("turntable")["slow"])
        self.assertRegex(self.browser.card("turntable")["slow"], r"^! slow: half of its answers take [\d.]+ ms or longer")

    def test_each_bus_and_device_has_a_plot_in_words_too(self):
        def labels():
            found = self.browser.js("return [...document.querySelectorAll('article canvas')].map((it) => it.ariaLabel)")
            return found if len(found) == 7 and all(re.search(r"\d+ (%|answers)", label) for label in found) else None
        found = self.browser.wait_for("seven plots with figures", labels)
        self.assertIn("Load of line-a in the last two minutes: now", found[0])
        self.assertRegex(found[3], r"How long axis-x took to answer, in the last two minutes: \d+ answers, half of them within")

    def test_filters_of_the_trace_are_kept_to(self):
        self.plant.poll(ABSENT)
        self.traced(lambda row: row["Time"], "a trace")
        self.browser.choose("#trace-failed", True)
        self.traced(lambda row: row["Answer"].startswith("✕"), "failures alone")
        self.browser.wait_for("what has no route", lambda: any(
            "unit 31" in row["Request"] for row in self.browser.rows("trace-rows")))
        self.assertRegex(self.browser.text("#trace-count"), r"^\d+ of the last \d+ transactions match")
        self.browser.choose("#trace-failed", False)
        self.browser.choose("#trace-device", "turntable")
        self.traced(lambda row: row["Device"] == "turntable", "the turntable alone")
        self.browser.choose("#trace-device", "")
        self.browser.choose("#trace-function", "4")
        self.traced(lambda row: "read input registers" in row["Request"], "function 4 alone")
        self.browser.choose("#trace-function", "four")
        self.assertEqual(self.browser.js("return document.getElementById('trace-function').ariaInvalid"), "true")
        self.browser.choose("#trace-function", "")
        self.browser.choose("#trace-bus", "line-a")
        self.browser.choose("#trace-text", "216..217")
        self.traced(lambda row: row["Device"] == "feeder", "what has this text")

    def test_any_transaction_can_be_seen_decoded(self):
        self.browser.choose("#trace-device", "axis-x")
        self.traced(lambda row: row["Device"] == "axis-x", "axis-x alone")
        # The first one may have begun before the page looked.
        self.browser.wait_for("one that is answered", lambda: len(self.browser.rows("trace-rows")) > 2)
        self.browser.find("#trace-pause").click()
        opener = self.browser.find("#trace-rows button")
        opener.send_keys("\ue007")  # Enter
        decoded = self.browser.text("#decoded")
        self.assertEqual(self.browser.js("return document.activeElement.id"), "decoded-title")
        for part in ("Request of 127.0.0.1", "unit 1: read holding registers 30..31", "On the line: request to line-a, axis-x",
                     "CRC\nA4 0D", "2 registers:", "✓ answered", "Answer to the client"):
            self.assertIn(part, decoded)
        self.browser.find("#decoded-close").send_keys("\ue007")
        self.assertTrue(self.browser.js("return document.activeElement === arguments[0]", opener))
        self.assertTrue(self.browser.js("return document.getElementById('decoded').hidden"))

    def test_the_timeline_shows_the_silence_before_each_request(self):
        for name, *_ in LINES:
            self.browser.choose("#timeline-bus", name)
            shown = self.browser.wait_for(f"requests on {name}", lambda: [
                row for row in self.browser.rows("timeline-rows") if row["Silence before (needed)"] != "–"][3:])
            for row in shown:
                figures = re.fullmatch(r"([\d.]+) ms \(([\d.]+) ms\)", row["Silence before (needed)"])
                silence, needed = map(float, figures.groups())
                self.assertAlmostEqual(needed, NEEDED[name], places=3)
                self.assertGreaterEqual(silence, needed, row)

    def pixels(self, name, y):
        """The first and the last column of the timeline that has this colour at this height, and how many columns there are."""
        return self.browser.js("""
            const canvas = document.getElementById("timeline-canvas");
            const probe = document.body.appendChild(document.createElement("i"));
            probe.style.color = `var(--${arguments[0]})`;
            const wanted = getComputedStyle(probe).color.match(/\\d+/g).map(Number);
            probe.remove();
            const copy = new OffscreenCanvas(canvas.width, 1).getContext("2d", { willReadFrequently: true });
            copy.drawImage(canvas, 0, -arguments[1]);
            const data = copy.getImageData(0, 0, canvas.width, 1).data;
            const at = [...Array(canvas.width).keys()].filter((x) => wanted.every((it, part) => data[4 * x + part] === it));
            return [at[0], at[at.length - 1], canvas.width];""", name, y)

    def test_the_timeline_is_to_scale_and_zooms_to_a_character(self):
        self.browser.choose("#timeline-bus", "line-b")
        self.browser.wait_for("a request on line-b", lambda: any(
            row["Outcome"] == "✓ answered" for row in self.browser.rows("timeline-rows")))
        self.browser.find("#timeline-previous").click()
        while "answered" not in (chosen := self.browser.js("return document.querySelector('#timeline-rows .chosen').innerText")):
            self.browser.find("#timeline-previous").click()
        self.assertEqual(self.browser.js("return document.getElementById('timeline-pause').ariaPressed"), "true")
        # Eight characters of 11 bits at 19200 baud.
        self.assertIn("4.58 ms", chosen)
        span = float(re.match(r"([\d.]+) ms shown", self.browser.text("#timeline-span")).group(1))
        first, last, width = self.pixels("request", 36)
        self.assertAlmostEqual((last + 1 - first) / width * span, 8 * 11 / 19200 * 1000, delta=span / width * 3 + 0.05)
        # The answer begins as much later as the table says.
        thought = float(re.search(r"4\.58 ms\s+([\d.]+) ms", chosen).group(1))
        begins, _, _ = self.pixels("response", 84)
        self.assertAlmostEqual((begins - last) / width * span, thought, delta=span / width * 6 + 0.5)
        canvas = self.browser.find("#timeline-canvas")
        while span > 2 * 0.573 + 0.01:
            canvas.send_keys("+")
            closer = float(re.match(r"([\d.]+) ms shown", self.browser.text("#timeline-span")).group(1))
            self.assertLess(closer, span)
            span = closer
        first, last, width = self.pixels("request", 36)
        self.assertGreater(last - first, width / 4)  # the first characters fill what is shown of them
        canvas.send_keys("\ue012")  # left: still paused
        canvas.send_keys("\ue011")  # Home
        self.assertEqual(self.browser.js("return document.getElementById('timeline-pause').ariaPressed"), "false")

    def test_the_timeline_shows_timeouts_and_quarantine(self):
        self.wait_for_state("lift", "answering")
        self.browser.choose("#timeline-bus", "line-c")
        self.plant.switch_off("line-c")
        self.addCleanup(self.plant.switch_on, "line-c")
        rows = self.browser.wait_for("a timeout", lambda: [
            row for row in self.browser.rows("timeline-rows") if "no response" in row["Outcome"]])
        self.assertRegex(rows[0]["Outcome"], r"^✕ no response.*; quarantine [\d.]+ ms at most$")
        self.browser.wait_for("its hatching", lambda: self.pixels("warn", 182)[0] is not None)
        self.plant.switch_on("line-c")
        self.wait_for_state("lift", "answering")

    def assert_keeps(self, rule, least):
        kept = self.browser.js(rule)
        self.assertEqual(kept["found"], [])
        self.assertGreater(kept["looked"], least)

    def test_it_can_be_read_by_everybody(self):
        for size in (WIDE, PHONE):
            for scheme in ("light", "dark"):
                with self.subTest(size=size, scheme=scheme):
                    self.open(size, scheme)
                    self.traced(lambda row: row["Time"], "a trace")
                    self.browser.wait_for("a timeline", lambda: self.browser.rows("timeline-rows"))
                    self.browser.find("#trace-pause").click()
                    self.browser.find("#timeline-pause").click()
                    self.browser.js("document.querySelector('#trace-rows button').click()")
                    is_dark = self.browser.js("return matchMedia('(prefers-color-scheme: dark)').matches")
                    self.assertEqual(is_dark, scheme == "dark")
                    self.assert_keeps(page_rules.CONTRAST, 100)
                    self.assert_keeps(page_rules.FIT, 100)
                    self.assert_keeps(page_rules.LABELS, 30)
                    # On a phone a row looks like a card; to a screen reader it is a row all the same.
                    tree = self.browser.driver.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]
                    roles = [node["role"]["value"] for node in tree if not node["ignored"]]
                    self.assertEqual(roles.count("table"), 4)
                    self.assertGreater(roles.count("cell"), 20)
                    self.assertEqual(roles.count("columnheader"), 8 + 6 + 5 + 3)

    def test_everything_is_reached_by_keyboard_and_seen_to_be(self):
        self.browser.choose("#trace-device", "axis-x")
        self.traced(lambda row: row["Device"] == "axis-x", "axis-x alone")
        self.browser.find("#trace-pause").click()
        self.browser.find("#timeline-pause").click()
        wanted = self.browser.js("""
            document.activeElement.blur();
            window.reached = new Set();
            window.unseen = [];
            window.reachable = () => [...document.querySelectorAll(
              "a[href], button, select, input, canvas[tabindex], [role=region]")].filter((it) => it.getClientRects().length > 0);
            return window.reachable().length;""")
        for _ in range(wanted + 5):
            self.browser.driver.switch_to.active_element.send_keys("\ue004")  # Tab
            self.browser.js("""
                const at = document.activeElement;
                window.reached.add(at);
                if (at !== document.body && getComputedStyle(at).outlineStyle === "none") {
                  window.unseen.push(at.outerHTML);
                }""")
        missed = "return window.reachable().filter((it) => !window.reached.has(it)).map((it) => it.outerHTML)"
        self.assertEqual(self.browser.js(missed), [])
        self.assertEqual(self.browser.js("return window.unseen"), [])

    def test_what_is_named_like_markup_is_text(self):
        self.browser.wait_for("the name of the port", lambda: MARKUP in self.browser.text("#bus-list"))
        self.browser.wait_for("it in an event", lambda: any(MARKUP in row["Event"] for row in self.browser.rows("event-rows")))
        self.assertEqual(self.browser.js("return [document.querySelectorAll('img').length, window.broken]"), [0, None])
        unsafe = re.compile(
            r"innerHTML|outerHTML|insertAdjacent|document\.write|\beval\b|\bFunction\(|https?://(?!www\.w3\.org/2000/svg)")
        files = [file for file in SOURCES.iterdir() if file.suffix in (".js", ".html", ".css", ".svg")]
        self.assertGreater(len(files), 10)
        for file in files:
            self.assertIsNone(unsafe.search(file.read_text(encoding="utf-8")), file.name)

    def test_it_says_when_what_it_shows_is_old(self):
        self.browser.wait_for("that it is live", lambda: self.browser.text("#contact") == "✓ Live.")
        self.plant.gateway.signal(signal.SIGSTOP)
        self.addCleanup(self.plant.gateway.signal, signal.SIGCONT)
        self.browser.wait_for("that mbgated is silent", lambda: (
            self.browser.text("#contact") == "✕ mbgated does not answer. The figures below are old."))
        self.plant.gateway.signal(signal.SIGCONT)
        self.browser.wait_for("that it is live again", lambda: self.browser.text("#contact") == "✓ Live.")

    def test_a_violation_of_its_policy_is_seen(self):
        self.browser.js("""
            const script = document.createElement("script");
            script.textContent = "window.broken = 1";
            document.head.append(script);""")
        self.browser.wait_for("the violation", lambda: self.browser.js("return window.violations.length > 0"))
        self.assertTrue(any("script-src" in complaint for complaint in self.browser.complaints()))
        self.assertIsNone(self.browser.js("return window.broken"))

    def stream_status(self):
        """What another one gets who wants to read along over TCP, where there is one place."""
        where = urllib.parse.urlsplit(self.plant.url)
        stream = EventStream(http.client.HTTPConnection(where.hostname, where.port, timeout=PATIENCE), path=TRACE)
        stream.close()
        return stream.status

    def test_it_reads_one_stream_and_none_while_it_is_hidden(self):
        self.browser.wait_for("its stream", lambda: self.stream_status() == 503)
        self.traced(lambda row: row["Time"], "a trace")
        driver = self.browser.driver
        shown = driver.current_window_handle
        driver.switch_to.new_window("window")
        driver.minimize_window()
        hidden = driver.current_window_handle
        driver.switch_to.window(shown)
        driver.execute_cdp_cmd("Emulation.setFocusEmulationEnabled", {"enabled": False})
        driver.minimize_window()
        self.browser.wait_for("that it is hidden", lambda: self.browser.js("return document.hidden"))
        self.browser.wait_for("no stream", lambda: self.stream_status() == 200)
        driver.switch_to.window(hidden)
        driver.close()
        driver.switch_to.window(shown)
        driver.maximize_window()
        self.browser.wait_for("its stream again", lambda: self.stream_status() == 503)
        self.browser.complaints()  # another one may have had its place for a moment


if __name__ == "__main__":
    if reason := missing():
        print(f"skipped: {reason}")
        sys.exit(SKIPPED)
    sys.exit(unittest.main())
