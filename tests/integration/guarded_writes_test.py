#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes that lose a drive: its factory settings, an older layout, a mode without Modbus. They get 01 by whatever request
they come, and nothing of them reaches the line; with allow_reconfigure they pass, and the journal says so."""

import pathlib
import tempfile
import threading
import unittest

from demo_plant import PATIENCE, Process
from fault_plant import Client, exception
from scripted_line import ScriptedLine

STEPPER, MOONS, FDA = 1, 2, 3
RESTORE = bytes.fromhex("06 00DC 0000")
SAVE = bytes.fromhex("06 00DC 0001")
PLANT = """
[http]
socket = ""
[[listen]]
name = "plant"
address = "127.0.0.1"
port = 0
[[bus]]
name = "line-a"
device = "{path}"
baud = 115200
parity = "none"
listen_first = "0ms"
echo = false
response_timeout = "30s"
[[device]]
name = "stepper"
bus = "line-a"
address = 1
profile = "rs485-stepper"
{keys}
[[device]]
name = "moons"
bus = "line-a"
address = 2
profile = "moons-ssdc"
[[device]]
name = "fda"
bus = "line-a"
address = 3
profile = "higen-fda6000"
[[route]]
unit = 1
device = "stepper"
[[route]]
unit = 2
device = "moons"
[[route]]
unit = 3
device = "fda"
[[route]]
unit = 0
bus = "line-a"
{broadcasts}
"""
LOSING = [
    (STEPPER, "06 00DC 0000"),
    (STEPPER, "10 00DB 0003 06 0001 0000 0001"),  # in the middle of others
    (STEPPER, "06 0012 0400"),
    (STEPPER, "06 0012 FFFF"),
    (STEPPER, "10 0010 0003 06 0014 0000 0400"),
    (0, "06 00DC 0000"),
    (MOONS, "06 008A 0007"),
    (MOONS, "06 008A 000B"),
    (MOONS, "10 0089 0002 04 0001 0000"),
    (FDA, "06 00DF 0001"),
]


class NotedLine(ScriptedLine):
    def __init__(self):
        super().__init__(NotedLine._answer)
        self.heard = []
        self.broadcast = threading.Event()

    def _answer(self, request):
        self.heard.append(request[:-2])
        if request[0] == 0:
            self.broadcast.set()
        else:
            self.say(request)


class GuardedWrites(unittest.TestCase):
    def start(self, keys="", broadcasts="broadcast_mixed = true"):
        folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.line = self.enterContext(NotedLine())
        configuration = folder / "mbgate.toml"
        text = PLANT.format(path=self.line.path, keys=keys, broadcasts=broadcasts)
        configuration.write_text(text, encoding="utf-8")
        self.gateway = Process(folder, "mbgated", "--config", configuration)
        self.addCleanup(self.gateway.end)
        self.client = Client(int(self.gateway.wait_for(r"listening plant 127\.0\.0\.1:(\d+)$").group(1)))
        self.addCleanup(self.client.close)

    def test_nothing_of_them_reaches_the_line(self):
        self.start()
        for unit, text in LOSING:
            request = bytes.fromhex(text)
            self.assertEqual(self.client.ask(request, unit), exception(request[0], 1), f"unit {unit}: {text}")
        self.assertEqual(self.line.heard, [])

    def test_other_values_of_the_same_registers_pass(self):
        self.start()
        for unit, text in ((STEPPER, "06 00DC 0001"), (STEPPER, "06 0012 0009"), (MOONS, "06 008A 0008"),
                           (MOONS, "06 008A 000A"), (FDA, "06 00DF 0000")):  # fmt: skip
            request = bytes.fromhex(text)
            self.assertEqual(self.client.ask(request, unit), request)

    def test_whoever_may_reconfigure_may_restore(self):
        self.start(keys="allow_reconfigure = true")
        self.assertEqual(self.client.ask(RESTORE, STEPPER), RESTORE)
        self.gateway.wait_for("device stepper: client 127.0.0.1 has written a value that restores")

    def test_only_stops_are_broadcast_on_a_mixed_line(self):
        self.start(broadcasts="")
        save = self.client.ask(SAVE, 0)
        self.assertIn(save, (exception(6, 2), exception(6, 3)))
        stop = bytes.fromhex("06 00C8 0100")
        self.assertEqual(self.client.ask(stop, 0), stop)
        self.gateway.wait_for("stops by broadcast, but not devices moons, fda: function 6 at unit 0")
        self.assertTrue(self.line.broadcast.wait(PATIENCE))
        self.assertEqual(self.line.heard, [b"\x00" + stop])


if __name__ == "__main__":
    unittest.main()
