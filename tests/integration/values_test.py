#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""mbgatectl read and write on the demo's gateway: values of 64 bits and texts, JSON, and reads that are repeated."""

import json
import re
import signal
import subprocess
import sys
import unittest

from demo_plant import PATIENCE, DemoPlant, program

MOONS, AIC, NOBODY = 1, 17, 9
USER_REGISTERS = 60  # of the MOONS' drive: any value


class Values(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.plant = cls.enterClassContext(DemoPlant())

    def command(self, name, *arguments):
        return [program("mbgatectl"), name, "--port", str(self.plant.port), *map(str, arguments)]

    def mbgatectl(self, *arguments):
        return subprocess.run(self.command(*arguments), capture_output=True, text=True, timeout=PATIENCE, check=False)

    def printed(self, *arguments):
        done = self.mbgatectl(*arguments)
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        return done.stdout

    def test_an_i64_is_read_back_as_it_was_written(self):
        place = ("holding", USER_REGISTERS, "--type", "i64", "--unit", MOONS)
        for order in ("big", "little"):
            for value in (-9007199254740993, 2**63 - 1, -(2**63)):
                wrote = self.printed("write", *place, "--order", order, "--json", value)
                self.assertEqual(
                    json.loads(wrote), {"unit": MOONS, "table": "holding", "address": USER_REGISTERS, "written": 1}
                )
                read = self.printed("read", *place, "--order", order, "--json")
                self.assertEqual(json.loads(read)["values"], [{"address": USER_REGISTERS, "value": value}])

    def test_the_order_mirrors_a_value_word_by_word(self):
        place = ("holding", USER_REGISTERS, "--type", "u64")
        self.printed("write", *place, "0x0001000200030004")
        self.assertIn("(0x0004000300020001)", self.printed("read", *place, "--order", "little"))

    def test_texts_are_read_and_written(self):
        model = self.printed("read", "input", "0x68", "--type", "string", "--count", 5, "--unit", AIC)
        self.assertEqual(model, '104: "AiC-D-56LA"\n')
        place = ("holding", USER_REGISTERS, "--type", "string")
        self.printed("write", *place, "[axis x]")
        self.printed("write", *place, "axis")  # a drive's values of 32 bits are written whole
        self.assertEqual(self.printed("read", *place, "--count", 4, "--quiet"), "axiss x]\n")
        self.printed("write", *place, "axi\n")
        self.assertEqual(self.printed("read", *place, "--count", 4, "--quiet"), "axi\\x0As x]\n")

    def test_a_closed_standard_output_is_not_the_connection(self):
        command = self.command("read", "holding", 0, "--every", "10ms", "--times", 3)
        closed = ["sh", "-c", 'exec "$@" >&-', "sh", *command]
        done = subprocess.run(closed, stderr=subprocess.PIPE, text=True, timeout=PATIENCE, check=False)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_what_cannot_be_printed_is_a_failure(self):
        for command in (self.command("read", "holding", 0), [program("mbgated"), "--version"]):
            with open("/dev/full", "w", encoding="ascii") as full:
                done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, timeout=PATIENCE, check=False)
            self.assertEqual(done.returncode, 1)
            self.assertIn("cannot be written", done.stderr)

    def test_a_failure_is_json_too(self):
        done = self.mbgatectl("read", "holding", 0, "--unit", NOBODY, "--json")
        self.assertEqual((done.returncode, done.stderr), (1, ""))
        failure = json.loads(done.stdout)
        self.assertEqual(failure["exception"], 0x0A)
        self.assertIn("unit 9: exception 0x0A", failure["error"])

    def test_a_read_is_repeated(self):
        lines = self.printed("read", "holding", 0, "--every", "20ms", "--times", 3, "--json").splitlines()
        self.assertEqual(len(lines), 3)
        for line in lines:
            self.assertEqual([value["address"] for value in json.loads(line)["values"]], [0])
        text = self.printed("read", "holding", 0, "--every", "20ms", "--times", 2)
        self.assertRegex(text, re.compile(r"\A(\d\d:\d\d:\d\d\.\d\d\d\n0: \d+ \(0x[0-9A-F]{4}\)\n){2}\Z"))

    def test_a_repeated_read_goes_on_after_a_failure(self):
        done = self.mbgatectl("read", "holding", 0, "--unit", NOBODY, "--every", "20ms", "--times", 3, "--quiet")
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertEqual(done.stderr.count("unit 9: exception 0x0A"), 3)

    def test_a_signal_ends_a_repeated_read_well(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(signal=number):
                reading = subprocess.Popen(
                    self.command("read", "holding", 0, "--every", "20ms", "--quiet"), stdout=subprocess.PIPE, text=True
                )
                with reading:
                    self.assertRegex(reading.stdout.readline(), r"^\d+\n$")
                    reading.send_signal(number)
                    self.assertEqual(reading.wait(PATIENCE), 0)


if __name__ == "__main__":
    sys.exit(unittest.main())
