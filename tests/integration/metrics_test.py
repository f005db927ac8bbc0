#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The metrics of the demo's gateway, as Prometheus and its promtool see them; docs/metrics.md, the alerts and the
dashboard are held to them.

With --update docs/metrics.md is written anew."""

import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.error
import urllib.parse
import urllib.request

from control_case import MOONS, HttpCase, UnixConnection
from demo_plant import PATIENCE, program

ROOT = pathlib.Path(__file__).parents[2]
DOCUMENT = ROOT / "docs" / "metrics.md"
RULES = ROOT / "conf" / "prometheus" / "mbgate.rules.yml"
DASHBOARD = ROOT / "conf" / "grafana" / "mbgate.json"
SCRAPES = 4  # a rate needs two
SAMPLE = re.compile(r"^(\w+)(?:\{(.*)\})? (\S+)$")
LABEL = re.compile(r'(\w+)="((?:[^"\\]|\\.)*)"')


def parsed(text):
    """Each family: its type, its help and its samples, (name, labels, value)."""
    families = {}
    for line in text.splitlines():
        if line.startswith("# HELP "):
            name, _, words = line.removeprefix("# HELP ").partition(" ")
            families[name] = {"help": words, "samples": []}
        elif line.startswith("# TYPE "):
            name, _, kind = line.removeprefix("# TYPE ").partition(" ")
            families[name]["type"] = kind
        else:
            name, labels, value = SAMPLE.match(line).groups()
            family = name if name in families else re.sub(r"_(bucket|sum|count)$", "", name)
            families[family]["samples"].append((name, dict(LABEL.findall(labels or "")), float(value)))
    return families


def table(families):
    """The families as the rows of docs/metrics.md."""
    rows = ["| metric | type | labels | what it counts |", "|---|---|---|---|"]
    for name, family in families.items():
        labels = dict.fromkeys(label for sample in family["samples"] for label in sample[1] if label != "le")
        rows.append(f"| `{name}` | {family['type']} | {', '.join(f'`{it}`' for it in labels)} | {family['help']} |")
    return rows


def without_variables(query):
    """A query of the dashboard as Grafana would ask it, for all buses, devices and listeners."""
    query = query.replace("$__rate_interval", f"{10 * SCRAPES}s")
    return re.sub(r'=~"\$\w+"', '=~".*"', query)


class Metrics(HttpCase):
    def setUp(self):
        super().setUp()
        self.assertEqual(self.read(MOONS).returncode, 0)
        self.assertNotEqual(self.read(MOONS, 65535).returncode, 0)

    def scraped(self):
        connection = UnixConnection(self.plant.control)
        connection.request("GET", "/metrics")
        answer = connection.getresponse()
        text = answer.read().decode()
        connection.close()
        self.assertEqual((answer.status, answer.headers["Content-Type"]),
                         (200, "text/plain; version=0.0.4; charset=utf-8"))
        return text

    def value(self, name, **labels):
        """The sum of the samples with these labels."""
        families = parsed(self.scraped())
        family = name if name in families else re.sub(r"_(bucket|sum|count)$", "", name)
        return sum(value for sample, has, value in families[family]["samples"]
                   if sample == name and labels.items() <= has.items())

    def tool(self, *arguments, **options):
        if shutil.which("promtool") is None:
            self.skipTest("promtool, of Debian's prometheus, is not installed")
        done = subprocess.run(["promtool", *map(str, arguments)], capture_output=True, text=True, check=False,
                              timeout=PATIENCE, **options)
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)

    def test_promtool_has_nothing_to_say_of_them(self):
        self.tool("check", "metrics", input=self.scraped())

    def test_promtool_has_nothing_to_say_of_the_alerts(self):
        self.tool("check", "rules", RULES)
        self.tool("test", "rules", ROOT / "tests" / "prometheus" / "rules_test.yml")

    def test_every_alert_is_tested_and_of_metrics_that_there_are(self):
        rules = RULES.read_text(encoding="utf-8")
        tests = (ROOT / "tests" / "prometheus" / "rules_test.yml").read_text(encoding="utf-8")
        for alert in re.findall(r"- alert: (\w+)", rules):
            self.assertGreaterEqual(len(re.findall(rf"alertname: {alert}\b", tests)), 2, alert)
        names = parsed(self.scraped()).keys()
        for name in re.findall(r"\bmbgate_\w+", re.sub(r"#.*", "", rules)):
            self.assertIn(name, names)

    def test_the_document_names_all_of_them(self):
        documented = [line for line in DOCUMENT.read_text(encoding="utf-8").splitlines() if line.startswith("|")]
        self.assertEqual(documented, table(parsed(self.scraped())), "tests/integration/metrics_test.py --update")

    def test_they_count_what_the_status_counts(self):
        for bus in self.status()["buses"]:
            for key, name in (("transmissions", "transmissions"), ("bad_crcs", "crc_errors"), ("losses", "losses")):
                self.assertEqual(self.value(f"mbgate_bus_{name}_total", bus=bus["name"]), bus["counters"][key])
        for device in self.status()["devices"]:
            labels = {"bus": device["bus"], "device": device["name"], "address": str(device["address"])}
            self.assertEqual(self.value("mbgate_device_responses_total", **labels), device["counters"]["responses"])
            self.assertEqual(self.value("mbgate_device_state", state=device["state"].replace(" ", "_"), **labels), 1)

    def test_a_read_is_counted(self):
        before = self.value("mbgate_listener_requests_total", listener="demo")
        silences = self.value("mbgate_bus_silence_seconds_count")
        busy = self.value("mbgate_bus_busy_seconds_total")
        by_device = self.value("mbgate_device_wire_seconds_total")
        self.assertEqual(self.read(MOONS).returncode, 0)
        self.assertEqual(self.value("mbgate_listener_requests_total", listener="demo"), before + 1)
        self.assertEqual(self.value("mbgate_bus_silence_seconds_count"), silences + 1)
        self.assertGreater(self.value("mbgate_bus_busy_seconds_total"), busy)
        self.assertGreater(self.value("mbgate_device_wire_seconds_total"), by_device)

    # At 38400 baud and below 3.5 characters, above that 1.75 ms; the demo's lines are slower than that.
    def test_no_silence_is_shorter_than_the_specification_asks_for(self):
        for _ in range(5):
            self.assertEqual(self.read(MOONS).returncode, 0)
        self.assertGreaterEqual(self.value("mbgate_bus_silence_seconds_count"), 5)
        self.assertEqual(self.value("mbgate_bus_silence_seconds_bucket", le="0.0015"), 0)

    def test_clients_are_named_only_if_asked(self):
        self.assertNotIn("127.0.0.1", self.scraped())
        self.configure("client_metrics = true")
        reading = subprocess.Popen([program("mbgatectl"), "read", "holding", "0", "--unit", str(MOONS), "--port",
                                    str(self.plant.port), "--every", "100ms"], stdout=subprocess.DEVNULL)
        self.enterContext(reading)
        self.addCleanup(reading.kill)
        limit = time.monotonic() + PATIENCE
        while 'client="127.0.0.1"' not in self.scraped():
            self.assertLess(time.monotonic(), limit, "no client is named")
        document = DOCUMENT.read_text(encoding="utf-8")
        for name in parsed(self.scraped()):
            self.assertIn(f"`{name}`", document)

    def test_over_tcp_for_those_who_may_read(self):
        self.listen('hosts = ["gateway.plant"]')
        connection = self.tcp()
        connection.request("GET", "/metrics", headers={"Host": "gateway.plant"})
        self.assertEqual(connection.getresponse().status, 200)
        self.assertEqual(self.ask("GET", "/metrics", self.tcp(), {"Host": "elsewhere.plant"})[0], 421)
        self.assertEqual(self.ask("POST", "/metrics")[0], 405)

    def start_prometheus(self):
        if shutil.which("prometheus") is None:
            self.skipTest("Debian's prometheus is not installed")
        folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        (folder / "prometheus.yml").write_text(
            f"rule_files: [{json.dumps(str(RULES))}]\n"
            "scrape_configs:\n"
            "  - job_name: mbgate\n"
            "    scrape_interval: 1s\n"
            "    scrape_timeout: 1s\n"
            f'    static_configs: [{{targets: ["{self.address[0]}:{self.address[1]}"]}}]\n', encoding="utf-8")
        log = self.enterContext((folder / "log").open("w+", encoding="utf-8"))
        running = subprocess.Popen(
            ["prometheus", "--config.file=prometheus.yml", "--storage.tsdb.path=data",
             "--web.listen-address=127.0.0.1:0"], cwd=folder, stdout=log, stderr=log)
        self.enterContext(running)
        self.addCleanup(running.kill)
        limit = time.monotonic() + PATIENCE
        while True:
            listening = re.search(r'"Listening on" address=(\S+)', (folder / "log").read_text(encoding="utf-8"))
            if listening:
                return f"http://{listening.group(1)}"
            self.assertLess(time.monotonic(), limit, (folder / "log").read_text(encoding="utf-8"))
            time.sleep(0.1)

    def test_each_list_of_the_dashboard_has_what_to_choose_from(self):
        families = parsed(self.scraped())
        lists = json.loads(DASHBOARD.read_text(encoding="utf-8"))["templating"]["list"]
        queries = [it["query"] for it in lists if it["type"] == "query"]
        self.assertEqual(len(queries), 3)
        for query in queries:
            metric, label = re.fullmatch(r"label_values\((\w+), (\w+)\)", query).groups()
            self.assertIn(metric, families)
            self.assertTrue(any(labels.get(label) for _, labels, _ in families[metric]["samples"]), query)

    def test_each_query_of_the_dashboard_returns_data(self):
        self.listen()
        server = self.start_prometheus()

        def result(query):
            url = f"{server}/api/v1/query?{urllib.parse.urlencode({'query': query})}"
            try:
                with urllib.request.urlopen(url, timeout=PATIENCE) as answer:
                    return json.load(answer)["data"]["result"]
            except urllib.error.HTTPError as error:
                self.assertEqual(error.code, 503)  # it listens before it is ready
                return []

        limit = time.monotonic() + 2 * PATIENCE
        while not result(f'count_over_time(up{{job="mbgate"}}[1m]) >= {SCRAPES}'):
            self.assertEqual(self.read(MOONS).returncode, 0)
            self.assertLess(time.monotonic(), limit, "Prometheus does not scrape")
            time.sleep(0.2)
        names = parsed(self.scraped())
        queries = [target["expr"] for panel in json.loads(DASHBOARD.read_text(encoding="utf-8"))["panels"]
                   for target in panel.get("targets", [])]
        self.assertGreater(len(queries), 20)
        for query in queries:
            for name in re.findall(r"\b(?:mbgate|process)_\w+", query):
                self.assertTrue(name in names or name.removesuffix("_bucket") in names, name)
            self.assertTrue(result(without_variables(query)), query)


def update():
    case = Metrics()
    case.setUp()
    try:
        text = DOCUMENT.read_text(encoding="utf-8")
        kept = [line for line in text.splitlines() if not line.startswith("|")]
        DOCUMENT.write_text("\n".join([*kept, *table(parsed(case.scraped())), ""]), encoding="utf-8")
    finally:
        case.doCleanups()


if __name__ == "__main__":
    sys.exit(update() if sys.argv[1:] == ["--update"] else unittest.main())
