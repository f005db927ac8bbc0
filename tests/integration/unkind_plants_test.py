#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Plants as they should not be, side by side on one gateway, which is killed, and whose lines get other names, while
answers are owed. No client gets a value that is not that of its register, no write is acknowledged that its drive did not
carry out, and nothing goes after a stop that was sent before it; beyond the five that two drives at one address may cost
each time their line is opened. `--seconds 1200` is the long trial. Prints a table."""

import os
import pathlib
import signal
import sys
import tempfile
import time
import unittest

from demo_plant import CONFIGURATION, Process
from fault_plant import registers_of
from tcp_server import TcpServer
from unkind_drives import (
    Asker, Drive, Jogger, LimitingDrive, LossyDrive, RefusingDrive, SerialLine, around, reads, writes,
)

ARGUMENTS = dict(zip(sys.argv[1::2], map(float, sys.argv[2::2]), strict=False))
SECONDS = ARGUMENTS.get("--seconds", 16)
STARTS = max(2, int(SECONDS / 60))
FEW = 5
JOG = 0x00CA  # the stepper's; torque mode is behind it
FEED = 30
EVERY = range(1, 65536)

HEAD = f"""
[gateway]
profiles = "{CONFIGURATION}/profiles"
[http]
socket = ""
[[listen]]
name = "plant"
address = "127.0.0.1"
port = 0
max_requests_per_second = 0
"""
LINE = """
[[bus]]
name = "{name}-{round}"
device = "{path}"
baud = 115200
parity = "none"
echo = false
{keys}
[[device]]
name = "{name}"
bus = "{name}-{round}"
address = 1
{more}
[[route]]
unit = {unit}
device = "{name}"
"""
CELL = """
[[bus]]
name = "cell"
mode = "tcp"
host = "127.0.0.1"
port = {port}
[[device]]
name = "cell"
bus = "cell"
stops = [{{ address = 30, value = 0 }}]
[[route]]
unit = {unit}
device = "cell"
[[route]]
unit = {other}
bus = "cell"
address = 7
"""


def blocking(pdu):
    return 0.05 if pdu == Jogger.BLOCKER else 0.003


def owed(pdu):
    return 1.9 if pdu[2] == 100 else 0.003


STOP_OF_FEED = f"stops = [{{ address = {FEED}, value = 0 }}]"
# drive, keys of its line, keys of the device
DRIVES = {
    "slow": (Drive(around(0.17)), 'response_timeout = "100ms"\nlisten_first = "2s"', ""),
    "double": (Drive(around(0.005), around(0.009)), "", ""),
    "repeats": (Drive(around(0.003), around(0.008)), "", ""),
    "owes": (Drive(owed), "retries = 0", ""),
    "limits": (LimitingDrive(around(0.003)), "", ""),
    "refuses": (RefusingDrive(blocking), "", f'profile = "rs485-stepper"\nresponse_timeout = "1s"'),
    "jogs": (Drive(blocking), "", f'profile = "rs485-stepper"\nresponse_timeout = "1s"'),
    "feeds": (LossyDrive(), 'response_timeout = "200ms"\nretries = 0', STOP_OF_FEED),
}


class UnkindPlants(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.lines = {}
        for name, (drive, _, _) in DRIVES.items():
            self.lines[name] = SerialLine(drive)
            self.addCleanup(self.lines[name].end)
        self.units = {name: 1 + number for number, name in enumerate(DRIVES)}
        cell = Drive(blocking)
        self.server = TcpServer(lambda _, pdu: cell.serve(pdu))
        self.addCleanup(self.server.end)
        self.units |= {"cell": 20, "cell's other": 21}
        stop = registers_of(FEED, 0)
        self.askers = {
            "slow, read 1": self.asker("slow", reads(100)),
            "slow, read 2": self.asker("slow", reads(7)),
            "slow, write": self.asker("slow", writes(16, 5, EVERY), 1.0),
            "double, read 1": self.asker("double", reads(0, 10)),
            "double, read 2": self.asker("double", reads(20)),
            "double, write": self.asker("double", writes(16, 5, EVERY), 0.05),
            "repeats, read": self.asker("repeats", reads(0, 10)),
            "owes, read": self.asker("owes", reads(100, 7)),
            "limits, read": self.asker("limits", reads(0, 10)),
            "limits, write": self.asker("limits", writes(6, 5, range(900, 65536)), 0.05),
            "refuses, jog": Jogger(DRIVES["refuses"][0], self.units["refuses"], registers_of(JOG, 1, 0), registers_of(JOG, 0, 0)),
            "jogs, jog": Jogger(DRIVES["jogs"][0], self.units["jogs"], registers_of(JOG, 1, 0), registers_of(JOG, 0, 0)),
            "feeds, feed and stop": self.asker("feeds", self.feeds(stop), 0.01),
            "cell, jog": Jogger(cell, 20, registers_of(FEED, 1), stop, stop_unit=21),
        }

    @staticmethod
    def feeds(stop):
        for value in EVERY:
            yield registers_of(FEED, value)
            yield stop

    def asker(self, drive, requests, pause=0.0):
        return Asker(DRIVES[drive][0], self.units[drive], requests, pause)

    def configure(self, name_of_round):
        text = HEAD
        for name, (_, keys, more) in DRIVES.items():
            text += LINE.format(name=name, path=self.lines[name].path, keys=keys, more=more, unit=self.units[name],
                                round=name_of_round)
        text += CELL.format(port=self.server.port, unit=20, other=21)
        (self.folder / "mbgate.toml").write_text(text, encoding="utf-8")

    def start(self):
        self.configure("first")
        self.gateway = Process(self.folder, "mbgated", "--config", self.folder / "mbgate.toml")
        self.addCleanup(self.gateway.end)
        return int(self.gateway.wait_for(r"listening plant 127\.0\.0\.1:(\d+)$").group(1))

    def wait_for_a_debt(self, end):
        """Just after the drive got a request that it answers much later."""
        time.sleep(max(0, end - time.monotonic()))
        asked = DRIVES["owes"][0].asked
        asked.clear()
        asked.wait(10)
        time.sleep(0.3)

    def test_nothing_is_wrong(self):
        for number in range(STARTS):
            port = self.start()
            begun = time.monotonic()
            for asker in self.askers.values():
                asker.begin(port)
            self.wait_for_a_debt(begun + SECONDS / STARTS / 2)
            self.configure("second")
            self.gateway.signal(signal.SIGHUP)
            self.wait_for_a_debt(begun + SECONDS / STARTS)
            self.gateway.signal(signal.SIGKILL if number + 1 < STARTS else signal.SIGTERM)
            for asker in self.askers.values():
                asker.end()
            self.gateway.wait()
        for line in self.gateway.unseen():
            print(line.rstrip())
        for name, asker in self.askers.items():
            print(f"{name:<22}", dict(asker.counts), "wrong", len(asker.wrong))
        for name, asker in self.askers.items():
            few = FEW * 2 * STARTS if name.startswith(("double", "repeats")) else 0
            self.assertLessEqual(len(asker.wrong), few, f"{name}: {asker.wrong[:20]}")
            self.assertGreater(sum(asker.counts.values()), 0, name)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
