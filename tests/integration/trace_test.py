#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""mbgatectl trace reads along at the demo's gateway, and tshark is the witness of its capture: both sides are there,
with the right functions, and nothing is malformed."""

import collections
import shutil
import subprocess
import sys
import threading
import unittest

from control_case import ControlCase
from demo_plant import PATIENCE, program

SKIPPED = 77
COMMANDS = (
    ("write", "holding", "0x1E", "200000", "--type", "i32", "--unit", "1"),  # function 16
    ("read", "holding", "0x1E", "--type", "i32", "--unit", "1"),  # 3
    ("write", "holding", "0x1B", "55", "--unit", "2"),  # 6
    ("write", "coils", "3", "on", "--unit", "17"),  # 5
    ("read", "input", "0x7000", "--unit", "17"),  # 4, exception 02
)
FUNCTIONS = [16, 3, 6, 5, 4]


class Trace(ControlCase):
    def follow(self, *arguments):
        """mbgatectl trace, which ends after COMMANDS; it has begun to read along when this returns."""
        command = [program("mbgatectl"), "trace", "--control", str(self.plant.control), *map(str, arguments)]
        following = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.enterContext(following)
        self.addCleanup(following.kill)
        return following

    def carry_out(self):
        for command in COMMANDS:
            self.mbgatectl(*command, "--port", self.plant.port)

    def read_along(self, *arguments):
        """What mbgatectl trace prints; reads are repeated until it has printed its first line."""
        following = self.follow(*arguments)
        lines = []
        begun = threading.Event()

        def read():
            for line in following.stdout:
                lines.append(line)
                begun.set()

        reader = threading.Thread(target=read)
        reader.start()
        try:
            for _ in range(100):
                if begun.wait(0.1):
                    break
                self.read(1)
            self.assertTrue(begun.is_set(), "mbgatectl trace prints nothing")
            self.carry_out()
            self.read(99)  # refused: the last that is waited for
            for _ in range(PATIENCE * 10):
                if any("unit 99" in line for line in lines) or not reader.is_alive():
                    break
                reader.join(0.1)
        finally:
            following.terminate()
            following.wait(PATIENCE)
            reader.join()
        self.assertEqual(following.returncode, 0, following.stderr.read())
        return "".join(lines)

    def tshark(self, file, shown, *fields):
        options = ["-o", "mbrtu.tcp.port:20502", "-o", "mbrtu.crc_verification:TRUE", "-o", "ip.check_checksum:TRUE"]
        options += ["-o", "tcp.check_checksum:TRUE"]
        printed = [part for field in fields for part in ("-e", field)]
        command = ["tshark", "-r", str(file), *options, "-Y", shown, "-T", "fields", "-E", "separator=,", *printed]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()

    def test_the_capture_has_both_sides(self):
        file = self.plant.configuration.parent / "trace.pcapng"
        text = self.read_along("--pcapng", file)
        words = (" > 01 10 00 1E", " < 01 10 00 1E", "FAILED 127.0.0.1 demo unit 17", "FAILED: refused by the gateway")
        for word in words:
            self.assertIn(word, text)
        self.assertEqual(self.tshark(file, "_ws.malformed || _ws.expert.severity >= 6291456", "frame.number"), [])
        self.assertEqual(self.tshark(file, "tcp.checksum.status == 0 || ip.checksum.status == 0", "frame.number"), [])
        clients = 'mbtcp && frame.interface_name == "clients"'
        requests = self.tshark(file, f"{clients} && tcp.dstport == 502", "modbus.func_code")
        answers = self.tshark(file, f"{clients} && tcp.srcport == 502", "modbus.func_code")
        self.assertEqual(sorted(requests), sorted(answers))
        self.assertEqual(list(map(int, requests))[-len(FUNCTIONS) - 1 :], [*FUNCTIONS, 3])
        frames = collections.Counter(map(int, self.tshark(file, "mbrtu", "modbus.func_code")))
        for function in FUNCTIONS:
            self.assertGreaterEqual(frames[function], 2, frames)

    def test_a_filter_lets_only_its_own_through(self):
        text = self.read_along("--function", "3", "--json")
        self.assertIn('"event":"transaction"', text)
        self.assertNotIn("write", text)


if __name__ == "__main__":
    if shutil.which("tshark") is None:
        print("skipped: tshark is not installed (./dev test --all installs it)")
        sys.exit(SKIPPED)
    unittest.main()
