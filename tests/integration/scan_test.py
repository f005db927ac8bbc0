#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""mbgatectl scan on a simulated bus with a drive of every series: each is named, and the configuration that comes of it
is one that mbgated takes."""

import fcntl
import json
import os
import pathlib
import re
import select
import signal
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
        self.assertEqual(done.stderr, "mbgatectl: mbgate.toml already exists\n")
        self.assertEqual((self.folder / "mbgate.toml").read_text(encoding="utf-8"), before)

    def test_says_when_nobody_answers(self):
        done = self.scan("--units", "20,21")
        self.assertEqual((done.returncode, done.stdout, done.stderr), (1, "", "mbgatectl: no unit answered\n"))


LINE = """
[[bus]]
name = "line"
link = "line"
baud = 19200
parity = "none"
[[device]]
name = "axis"
bus = "line"
address = 3
model = "moons"
series = "m3"
word_order = "little"
[[device]]
name = "turntable"
bus = "line"
address = 17
model = "aic"
response_wait = "5ms"
"""


class ScanOfASerialPort(unittest.TestCase):
    """Without a gateway. The drives hear 19200 baud only; a pty has no parity, so the first one is found."""

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        (cls.folder / "sim.toml").write_text(LINE, encoding="utf-8")
        drives = Process(cls.folder, "mbgate-sim", "sim.toml")
        cls.addClassCleanup(drives.end)
        drives.wait_for("^ready")

    def command(self, *options):
        return [program("mbgatectl"), "scan", "--device", "line", "--profiles", PROFILES, *options]

    def scan(self, *options):
        return subprocess.run(
            self.command(*options), cwd=self.folder, capture_output=True, text=True, timeout=4 * PATIENCE, check=False
        )

    def test_finds_the_rate_and_the_drives_and_writes_a_configuration_that_is_taken(self):
        done = self.scan("--units", "2-3,17", "--bauds", "9600,115200,19200", "--wait", "500ms", "--config", "found.toml")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(
            done.stderr, "asking 3 units at line in 9 modes, 9600 8E1 first: 14s at most, and some seconds for each that answers; "
            "only reads are sent\n", done.stdout
        )
        device = str(self.folder / "line")
        self.assertEqual(done.stdout.splitlines()[0], f"{device}, 19200 baud, parity even, stop bits 1:")
        rows = {int(row[0]): row[1:] for row in ROW.findall(done.stdout)}
        self.assertEqual({unit: row[2] for unit, row in rows.items()}, {3: "moons-m3", 17: "autonics-aic"}, done.stdout)
        found = tomllib.loads((self.folder / "found.toml").read_text(encoding="utf-8"))
        bus = found["bus"][0]
        self.assertEqual((bus["device"], bus["baud"], bus["parity"], bus["stop_bits"]), (device, 19200, "even", 1))
        self.assertEqual([unit["address"] for unit in found["device"]], [3, 17])
        command = [program("mbgated"), "--check", "--config", "found.toml", "--profiles", PROFILES]
        checked = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE, check=False)
        self.assertEqual(checked.returncode, 0, checked.stderr)

    def test_hears_no_answer_at_another_rate(self):
        done = self.scan("--units", "3", "--bauds", "9600", "--parities", "none", "--wait", "50ms", "--json")
        self.assertEqual((done.returncode, done.stderr), (1, ""), done.stdout)
        found = json.loads(done.stdout)
        self.assertEqual((found["units"], found["line"], found["notes"]), ([], None, []))
        self.assertEqual(found["error"], "no unit answered at line at 9600 8N1")

    def test_ends_with_what_was_found_when_it_is_interrupted(self):
        line, port = os.openpty()
        self.addCleanup(os.close, line)
        self.addCleanup(os.close, port)
        command = self.command("--units", "3-247", "--bauds", "19200", "--parities", "none", "--wait", "1s", "--json")
        command[command.index("line")] = os.ttyname(port)
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as scan:
            self.take_request(line, 3)
            os.write(line, bytes.fromhex("03 83 02 61 31"))  # unit 3, exception 02, CRC
            self.take_request(line, 4)
            scan.send_signal(signal.SIGINT)
            printed, _ = scan.communicate(timeout=PATIENCE)
        self.assertEqual(scan.returncode, 1)
        found = json.loads(printed)
        self.assertEqual(found["error"], "interrupted")
        self.assertEqual(found["notes"], ["at 19200 8N1 unit 3 answered, and was not identified"])

    def take_request(self, line, unit):
        """Function 03, register 0, count 1."""
        request = b""
        while len(request) < 8:
            self.assertTrue(select.select([line], [], [], PATIENCE)[0], "nothing was asked")
            request += os.read(line, 8 - len(request))
        self.assertEqual(request[:6], bytes([unit, 3, 0, 0, 0, 1]))

    def test_leaves_a_port_alone_that_another_program_holds(self):
        with open(self.folder / "line", "rb", buffering=0) as port:
            fcntl.flock(port, fcntl.LOCK_EX)
            done = self.scan()
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertEqual(
            done.stderr,
            "mbgatectl: a gateway or another program holds line: stop it first (systemctl stop mbgated), "
            "or scan through it with --host and --port\n",
        )


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
