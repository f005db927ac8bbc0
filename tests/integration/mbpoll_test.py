#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""mbpoll as the client of the demo's gateway: what a user types on a command line works, for every drive."""

import re
import subprocess
import sys
import unittest

from demo_plant import DemoPlant


class MbpollReadsAndWrites(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.plant = cls.enterClassContext(DemoPlant())

    def mbpoll(self, unit, *options, values=()):
        """The exit status, and what was printed. `values` are written; none: it reads."""
        command = ["mbpoll", "-m", "tcp", "-p", str(self.plant.port), "-a", str(unit), "-0", "-1", "-o", "10"]
        command += [*options, "127.0.0.1", *(["--", *values] if values else [])]
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
        return done.returncode, done.stdout + done.stderr

    def read(self, unit, *options):
        """The values that mbpoll prints as "[address]: value"."""
        status, text = self.mbpoll(unit, *options)
        self.assertEqual(status, 0, text)
        return re.findall(r"(?m)^\[\d+\]:\s+(\S+)", text)

    def write(self, unit, *options, values):
        status, text = self.mbpoll(unit, *options, values=values)
        self.assertEqual(status, 0, text)
        self.assertIn("Written", text)

    def test_a_moons_drive_has_the_high_word_first(self):
        self.write(1, "-r", "30", "-t", "4:int", "-B", values=["-200000"])
        self.assertEqual(self.read(1, "-r", "30", "-t", "4:int", "-B", "-c", "1"), ["-200000"])
        self.assertEqual(self.read(1, "-r", "30", "-t", "4:hex", "-c", "2"), ["0xFFFC", "0xF2C0"])

    def test_the_other_moons_drive_shows_it_first_too(self):
        self.write(3, "-r", "30", "-t", "4:int", "-B", values=["200000"])
        self.assertEqual(self.read(3, "-r", "30", "-t", "4:hex", "-c", "2"), ["0x0003", "0x0D40"])

    def test_the_stepper_has_the_low_word_first_and_does_not_show_it(self):
        self.write(2, "-r", "216", "-t", "4:int", "-B", values=["30001"])
        self.assertEqual(self.read(2, "-r", "216", "-t", "4:int", "-B", "-c", "1"), ["30001"])
        self.assertEqual(self.read(102, "-r", "216", "-t", "4:int", "-c", "1"), ["30001"])

    def test_the_aic_takes_coils_and_shows_inputs(self):
        self.write(17, "-r", "5", "-t", "0", values=["1"])
        self.assertEqual(self.read(17, "-r", "5", "-t", "0", "-c", "2"), ["1", "0"])
        self.assertEqual(self.read(17, "-r", "104", "-t", "3:hex", "-c", "1"), ["0x4169"])
        self.assertEqual(len(self.read(17, "-r", "0", "-t", "1", "-c", "8")), 8)

    def test_an_exception_is_reported(self):
        status, text = self.mbpoll(17, "-r", "28672", "-t", "3", "-c", "1")
        self.assertNotEqual(status, 0)
        self.assertIn("Illegal data address", text)

    def test_a_unit_without_a_route_is_reported(self):
        status, text = self.mbpoll(99, "-r", "0", "-t", "4", "-c", "1")
        self.assertNotEqual(status, 0)
        self.assertIn("Gateway path unavailable", text)


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
