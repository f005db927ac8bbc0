#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""mbgatectl scan on a simulated bus with a drive of every series: each is named, and the configuration that comes of it
is one that mbgated takes."""

import json
import pathlib
import re
import subprocess
import sys
import tempfile
import tomllib
import unittest

from demo_plant import CONFIGURATION, PATIENCE, Process, program

PROFILES = CONFIGURATION / "profiles"
# By address: keys of the simulated drive; profiles that must be found, functions that gave data, word order.
DRIVES = {
    1: ('model = "moons"\nseries = "st"\nword_order = "little"', ["moons-st"], "03", "unknown"),
    2: ('model = "moons"\nseries = "stb"', ["moons-ssdc", "moons-stb"], "03", "big"),
    3: ('model = "moons"\nseries = "stf"\nword_order = "little"', ["moons-stf"], "03", "little"),
    4: ('model = "moons"\nseries = "ssdc"\nword_order = "little"', ["moons-ssdc", "moons-stb"], "03", "little"),
    5: ('model = "moons"\nseries = "m2"', ["moons-m2"], "03", "big"),
    6: ('model = "moons"\nseries = "m3"\nword_order = "big"', ["moons-m3"], "03", "big"),
    7: ('model = "moons"\nseries = "m3"\nword_order = "little"', ["moons-m3"], "03", "little"),
    8: ('model = "moons"\nseries = "mdx"\nword_order = "little"', ["moons-mdx"], "03", "little"),
    9: ('model = "moons"\nseries = "bldc"', ["moons-bldc"], "03", "unknown"),
    12: ('model = "stepper"', ["rs485-stepper"], "03 04", "little"),
    14: ('model = "aic"\nresponse_wait = "5ms"', ["autonics-aic"], "01 02 03 04", "big"),
    15: ('model = "fda6000"', ["higen-fda6000"], "03", "-"),
}
TEXTS = {
    12: 'hardware version "170", software version "105"',
    14: 'model name "AiC-D-56LA"',
}
# Answers that fit no profile: the FDA6000's manual writes to 0x0001 in its examples, but its address map, and so the
# profile, begins at 0x000A.
MISFITS = {15: 1}
ROW = re.compile(r"(?m)^  (\d+)  +(\S+(?: \S+)*)  +(\S+)  +(\S+(?: or \S+)*)  +(\d+) of (\d+)  +(\S+)  +(\S.*)$")


def simulator_configuration():
    text = '[[bus]]\nname = "line"\nlink = "line"\nbaud = 115200\nparity = "none"\npaced = false\n'
    for address, (keys, *_) in DRIVES.items():
        text += f'[[device]]\nname = "drive-{address}"\nbus = "line"\naddress = {address}\n{keys}\n'
    return text


GATEWAY = """
[[listen]]
name = "through"
port = 0
bus = "line"
[[bus]]
name = "line"
device = "line"
baud = 115200
parity = "none"
listen_first = "0ms"
response_timeout = "500ms"
"""


class ScanOfABusOfAllFamilies(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        (cls.folder / "sim.toml").write_text(simulator_configuration(), encoding="utf-8")
        (cls.folder / "mbgate.toml").write_text(GATEWAY, encoding="utf-8")
        drives = Process(cls.folder, "mbgate-sim", "sim.toml")
        cls.addClassCleanup(drives.end)
        drives.wait_for("^ready")
        gateway = Process(cls.folder, "mbgated", "--config", "mbgate.toml")
        cls.addClassCleanup(gateway.end)
        cls.port = gateway.wait_for(r"listening through 127\.0\.0\.1:(\d+)$").group(1)

    def scan(self, *options):
        command = [program("mbgatectl"), "scan", "--port", self.port, "--profiles", PROFILES, *options]
        return subprocess.run(command, cwd=self.folder, capture_output=True, text=True, timeout=4 * PATIENCE, check=False)

    def check(self, name):
        command = [program("mbgated"), "--check", "--config", name, "--profiles", PROFILES]
        return subprocess.run(command, cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE, check=False)

    def test_names_every_drive_and_writes_a_configuration_that_is_taken(self):
        done = self.scan("--units", "1-16", "--bus", "hall-3", "--config", "found.toml")
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        rows = {int(row[0]): row[1:] for row in ROW.findall(done.stdout)}
        self.assertEqual(sorted(rows), sorted(DRIVES), done.stdout)
        for address, (_, profiles, functions, order) in DRIVES.items():
            found_functions, _, found, fitting, judged, found_order, texts = rows[address]
            self.assertEqual(found.split(" or "), profiles, done.stdout)
            self.assertEqual(found_functions, functions, done.stdout)
            self.assertEqual(int(judged) - int(fitting), MISFITS.get(address, 0), done.stdout)
            self.assertEqual(found_order, order, done.stdout)
            self.assertEqual(texts, TEXTS.get(address, "-"))
        self.check_configuration()

    def check_configuration(self):
        checked = self.check("found.toml")
        self.assertEqual(checked.returncode, 0, checked.stderr)
        text = (self.folder / "found.toml").read_text(encoding="utf-8")
        devices = {device["address"]: device for device in tomllib.loads(text)["device"]}
        self.assertEqual(sorted(devices), sorted(DRIVES))
        for address, (_, profiles, _, order) in DRIVES.items():
            self.assertEqual(devices[address]["bus"], "hall-3")
            self.assertEqual(devices[address].get("profile"), profiles[0] if len(profiles) == 1 else None)
            stated = len(profiles) == 1 and order in ("big", "little")
            self.assertEqual(devices[address].get("word_order"), order if stated else None)
        # Every choice can be made as the comments say, and then the configuration is still taken.
        chosen = re.sub(r'(?m)^# (profile = "moons-ssdc"|word_order = )', r"\1", text)
        (self.folder / "chosen.toml").write_text(chosen, encoding="utf-8")
        checked = self.check("chosen.toml")
        self.assertEqual(checked.returncode, 0, checked.stderr)

    def test_prints_the_configuration_where_no_file_is_named(self):
        done = self.scan("--units", "14")
        self.assertEqual(done.returncode, 0, done.stderr)
        (self.folder / "printed.toml").write_text(done.stdout[done.stdout.index("\n# ") :], encoding="utf-8")
        self.assertEqual(self.check("printed.toml").returncode, 0, done.stdout)

    def test_says_it_all_in_json(self):
        done = self.scan("--units", "12-14", "--json")
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        found = json.loads(done.stdout)
        self.assertEqual([unit["unit"] for unit in found["units"]], [12, 14])
        for unit in found["units"]:
            _, profiles, functions, order = DRIVES[unit["unit"]]
            self.assertEqual(unit["profiles"], profiles)
            self.assertEqual(unit["functions"], [int(function) for function in functions.split()])
            self.assertEqual(unit["word_order"], order)
            self.assertGreater(unit["slowest_ms"], 0)
        self.assertEqual(found["units"][1]["texts"], [{"name": "model name", "text": "AiC-D-56LA"}])
        (self.folder / "from-json.toml").write_text(found["configuration"], encoding="utf-8")
        self.assertEqual(self.check("from-json.toml").returncode, 0, done.stdout)

    def test_leaves_a_file_that_is_there_as_it_is(self):
        before = (self.folder / "mbgate.toml").read_text(encoding="utf-8")
        done = self.scan("--units", "14", "--config", "mbgate.toml")
        self.assertEqual(done.returncode, 2)
        self.assertEqual(done.stderr, "mbgatectl: mbgate.toml is there already\n")
        self.assertEqual((self.folder / "mbgate.toml").read_text(encoding="utf-8"), before)

    def test_says_when_nobody_answers(self):
        done = self.scan("--units", "20,21")
        self.assertEqual((done.returncode, done.stdout, done.stderr), (1, "", "mbgatectl: no unit answered\n"))


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
