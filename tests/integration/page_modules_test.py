#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Modules of the status page in Chromium, without a gateway: what they make of hours, of clocks that differ, and of more than
they keep."""

import http.server
import pathlib
import sys
import threading
import unittest

from page_browser import Browser, missing

SKIPPED = 77
SOURCES = pathlib.Path(__file__).parents[2] / "src" / "app" / "page"
BEGINS = '<script type="module" src="/page/main.js"></script>'
TYPES = {".html": "text/html; charset=utf-8", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}

# A history to which told(at) tells of a transaction that began then by the clock of the gateway. `now` is the clock of the
# browser. All in microseconds.
HISTORY = """
const { History } = await import("/page/history.js");
let now = 0;
performance.now = () => now / 1000;
const began = 1.8e15;
const history = new History();
const told = (at) => history.add({
  bus: "line-a", address: 1, key: String(at), at, sentAt: at, leftAt: at, endedAt: at + 4000, outcome: "answered",
  heard: [{ at: at + 4000, bytes: ["01"] }] });
"""


class PageFiles(http.server.BaseHTTPRequestHandler):
    """The files of the page as mbgated has them, but nothing begins by itself."""

    def do_GET(self):
        file = SOURCES / ("index.html" if self.path == "/" else self.path.removeprefix("/page/"))
        if file.parent != SOURCES or not file.is_file():
            self.send_error(404)
            return
        content = file.read_bytes().replace(BEGINS.encode(), b"")
        self.send_response(200)
        self.send_header("Content-Type", TYPES[file.suffix])
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, *_):
        pass


class PageModules(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        server = cls.enterClassContext(http.server.ThreadingHTTPServer(("127.0.0.1", 0), PageFiles))
        cls.url = f"http://127.0.0.1:{server.server_port}/"
        serving = threading.Thread(target=server.serve_forever)
        serving.start()
        cls.addClassCleanup(serving.join)
        cls.addClassCleanup(server.shutdown)
        cls.browser = cls.enterClassContext(Browser())

    def setUp(self):
        self.browser.driver.get(self.url)

    def tearDown(self):
        self.assertEqual(self.browser.complaints(), [])

    def made(self, script):
        """What the script returns, which may import modules of the page."""
        return self.browser.js(f"return (async () => {{ {script} }})()")

    def test_nothing_begins_by_itself_here(self):
        self.assertIn(BEGINS, (SOURCES / "index.html").read_text(encoding="utf-8"))

    def test_the_clock_of_the_gateway_may_be_set_back(self):
        for seconds in (3, 90):
            with self.subTest(seconds=seconds):
                behind, shown, later = self.made(HISTORY + f"""
                    const go_on = (seconds, ahead) => {{
                      for (const end = now + seconds * 1e6; now < end; now += 10000) {{
                        told(began + ahead + now - 4000);
                      }}
                    }};
                    go_on(70, 0);
                    go_on(25, -{seconds}e6);
                    const at = history.now();
                    const wires = history.of(history.wires, "line-a");
                    const points = history.of(history.points, "line-a 1");
                    return [began - {seconds}e6 + now - at, wires.filter((it) => it.at >= at - 2e6).length,
                            [...wires, ...points].filter((it) => it.at > at).length];""")
                self.assertAlmostEqual(behind, 0, delta=5000)
                self.assertAlmostEqual(shown, 200, delta=5)
                self.assertEqual(later, 0)

    def test_the_clock_of_the_browser_may_be_faster(self):
        behind = self.made(HISTORY + """
            for (; now < 11 * 3600e6; now += 10e6) {
              told(began + Math.round(now * (1 - 50e-6)) - 4000);
            }
            return began + now * (1 - 50e-6) - history.now();""")
        self.assertAlmostEqual(behind, 0, delta=20000)

    def test_what_comes_late_is_no_clock_that_was_set_back(self):
        kept = self.made(HISTORY + """
            for (; now < 30e6; now += 100000) {
              // Two seconds in which nothing came, and then all of it.
              const waited = now > 20e6 && now < 22e6;
              told(began + (waited ? 20e6 + (now - 20e6) / 20 : now) - 4000);
            }
            return history.of(history.wires, "line-a").length;""")
        self.assertEqual(kept, 300)

    def test_the_plot_says_which_time_it_shows(self):
        for rate, words in ((1, "two minutes: 1(19|2[01]) answers"), (130, "23 s: 3000 answers")):
            with self.subTest(rate=rate):
                label = self.made(HISTORY + f"""
                    const {{ plotLatency }} = await import("/page/plot.js");
                    for (; now < 180e6; now += 1e6 / {rate}) {{
                      told(began + Math.round(now) - 4000);
                    }}
                    const canvas = document.createElement("canvas");
                    plotLatency(canvas, "axis-x", history.of(history.points, "line-a 1"), history.now());
                    return canvas.ariaLabel;""")
                self.assertRegex(label, f"^How long axis-x took to answer, in the last {words}, half of them within 4.00 ms")

    def test_addresses_of_clients_are_not_kept_for_ever(self):
        counts, chosen, last = self.made("""
            const { Trace } = await import("/page/trace.js");
            const trace = new Trace(null, null);
            const select = document.getElementById("trace-client");
            const status = { clients: [{ address: "192.0.2.1" }], buses: [], devices: [] };
            const ask = (address) => trace.add({
              client: { address }, wire: [], targets: [], failed: false,
              request: { at: "2026-11-25T00:00:01Z", bytes: "00 01 00 00 00 06 01 03 00 00 00 01", text: "a read" },
              answer: { at: "2026-11-25T00:00:02Z", text: "an answer" } });
            const counts = [];
            for (let at = 0; at < 10000; at += 1) {
              ask(`10.0.${Math.floor(at / 100)}.${at % 100}`);
              if (at % 1000 === 0) {
                trace.status(status);
                select.value = "10.0.0.0";
                counts.push(select.options.length);
              }
            }
            trace.status(status);
            return [counts, select.value, [...select.options].map((it) => it.value)];""")
        # All, one that is connected, one that is chosen, and those of the last transactions.
        self.assertEqual(counts[-1], 1 + 1 + 1 + 2000)
        self.assertEqual(chosen, "10.0.0.0")
        self.assertIn("192.0.2.1", last)
        self.assertIn("10.0.99.99", last)
        self.assertNotIn("10.0.1.0", last)


if __name__ == "__main__":
    if reason := missing():
        print(f"skipped: {reason}")
        sys.exit(SKIPPED)
    sys.exit(unittest.main())
