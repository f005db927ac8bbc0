#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A Modbus TCP server that is one drive, over a route and over a transparent listener: its stops, the order of its writes
and its cache are the same under every unit. And two buses that would share a line, by whatever names."""

import os
import pathlib
import pty
import subprocess
import tempfile
import threading
import tty
import unittest

from demo_plant import PATIENCE, Process, program
from fault_plant import BUSY, Client, exception
from tcp_server import TcpServer

ROUTED = 11
OWN = 255
STOP = bytes.fromhex("06 00C8 0000")
FEED = bytes.fromhex("06 0010 0007")
FIRST = bytes.fromhex("03 0001 0001")
SPEED = bytes.fromhex("03 0010 0001")
PLANT = """
[http]
socket = ""
[[listen]]
name = "plant"
address = "127.0.0.1"
port = 0
[[listen]]
name = "service"
address = "127.0.0.1"
port = 0
bus = "cell"
[[bus]]
name = "cell"
mode = "tcp"
host = "127.0.0.1"
port = {port}
response_timeout = "30s"
stop_wait = "10s"
[[device]]
name = "axis"
bus = "cell"
cache = "1000s"
stops = [{{ address = 200, value = 0 }}]
[[route]]
unit = 11
device = "axis"
deadline = "60s"
"""
SERVER = """
[[bus]]
name = "{name}"
mode = "tcp"
host = "{host}"
port = {port}
reopen_min = "10ms"
"""


class Server:
    """A drive that is a Modbus TCP server. `heard`: unit and PDU of each request; while `goes_on` is not set, none is
    answered."""

    def __enter__(self):
        self.heard = []
        self.registers = {}
        self.goes_on = threading.Event()
        self.goes_on.set()
        self._news = threading.Condition()
        self._server = TcpServer(self._answer)
        self.port = self._server.port
        return self

    def __exit__(self, *_):
        self.goes_on.set()
        self._server.end()

    def wait_for(self, count):
        with self._news:
            assert self._news.wait_for(lambda: len(self.heard) >= count, PATIENCE), self.heard

    def _answer(self, unit, pdu):
        with self._news:
            self.heard.append((unit, pdu))
            self._news.notify_all()
        self.goes_on.wait(PATIENCE)
        return self._carry_out(pdu)

    def _carry_out(self, pdu):
        register = int.from_bytes(pdu[1:3], "big")
        if pdu[0] == 3:
            return b"\x03\x02" + self.registers.get(register, 0).to_bytes(2, "big")
        self.registers[register] = int.from_bytes(pdu[3:5], "big")
        return pdu


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.configuration = self.folder / "mbgate.toml"

    def start(self, text):
        self.configuration.write_text(text, encoding="utf-8")
        gateway = Process(self.folder, "mbgated", "--config", self.configuration)
        self.addCleanup(gateway.end)
        return gateway

    def check(self, text):
        self.configuration.write_text(text, encoding="utf-8")
        return subprocess.run([program("mbgated"), "--check", "--config", str(self.configuration)], check=False,
                              capture_output=True, text=True, timeout=PATIENCE)  # fmt: skip


class OneDevice(Case):
    def setUp(self):
        super().setUp()
        self.server = self.enterContext(Server())
        gateway = self.start(PLANT.format(port=self.server.port))
        ports = {}
        for _ in range(2):
            found = gateway.wait_for(r"listening (\w+) 127\.0\.0\.1:(\d+)$")
            ports[found.group(1)] = int(found.group(2))
        self.plant = Client(ports["plant"])
        self.addCleanup(self.plant.close)
        self.service = Client(ports["service"])
        self.addCleanup(self.service.close)

    def test_no_feed_leaves_after_its_stop(self):
        self.server.goes_on.clear()
        self.service.send(FIRST, 1)
        self.server.wait_for(1)
        self.plant.send(FEED, ROUTED)
        # Requests of a connection are understood in their order, and the gateway answers for itself at once.
        self.plant.send(bytes.fromhex("04 0000 0001"), OWN)
        self.assertEqual(self.plant.receive()[0], 4)
        self.service.send(STOP, 5)
        self.service.send(bytes.fromhex("04 0000 0001"), OWN)
        answers = {self.service.receive()[0]}
        self.server.goes_on.set()
        answers |= {self.service.receive()[0], self.service.receive()[0]}
        self.assertEqual(answers, {3, 4, 6})
        self.assertEqual(self.plant.receive(), exception(6, BUSY))
        self.assertEqual(self.service.ask(FIRST, 7)[0], 3)
        self.assertEqual([pdu for _, pdu in self.server.heard if pdu[0] == 6], [STOP])
        self.assertEqual({unit for unit, pdu in self.server.heard if pdu == STOP}, {5}, "its unit is its client's")

    def test_the_cache_knows_of_every_write(self):
        self.assertEqual(self.plant.ask(SPEED, ROUTED), b"\x03\x02\x00\x00")
        self.assertEqual(self.service.ask(FEED, 3), FEED)
        self.assertEqual(self.plant.ask(SPEED, ROUTED), b"\x03\x02\x00\x07")
        self.assertEqual(self.service.ask(SPEED, 9), b"\x03\x02\x00\x07")
        self.assertEqual(len(self.server.heard), 4, "each unit has its own place in the cache")

    def test_the_check_says_what_the_units_are(self):
        text = PLANT.format(port=self.server.port)
        self.assertIn("bus cell: every unit is device axis", self.check(text).stdout)
        alone = self.check(text.replace('cache =', "address = 5\ncache ="))
        self.assertIn("bus cell: device axis is unit 5 alone", alone.stdout)
        several = text.replace("stop_wait", "one_device = true\nstop_wait")
        several += '[[device]]\nname = "valve"\nbus = "cell"\naddress = 2\n'
        self.assertIn("one_device: true needs one [[device]] with this bus", self.check(several).stderr)


class SharedLines(Case):
    """Two buses on one line would talk into each other's transactions."""

    def test_one_port_by_two_paths(self):
        ours, theirs = pty.openpty()
        self.addCleanup(os.close, ours)
        self.addCleanup(os.close, theirs)
        tty.setraw(theirs)
        link = self.folder / "adapter"
        link.symlink_to(os.ttyname(theirs))
        text = '[http]\nsocket = ""\n[[listen]]\nname = "plant"\naddress = "127.0.0.1"\nport = 0\nbus = "line-a"\n'
        line = '[[bus]]\nname = "{}"\ndevice = "{}"\nparity = "none"\n'
        text += line.format("line-a", os.ttyname(theirs)) + line.format("line-b", link)
        refused = self.check(text)
        self.assertEqual(refused.returncode, 78)
        self.assertIn('by bus "line-a"', refused.stderr)
        # What --check cannot see: the link leads there only later.
        link.unlink()
        link.symlink_to("/dev/nowhere")
        gateway = self.start(text)
        gateway.wait_for("bus line-a is open")
        link.unlink()
        link.symlink_to(os.ttyname(theirs))
        gateway.wait_for("adapter: bus line-a has this port open")

    def test_one_server_by_two_names(self):
        with Server() as server:
            text = '[http]\nsocket = ""\n[[listen]]\nname = "plant"\naddress = "127.0.0.1"\nport = 0\nbus = "cell-a"\n'
            text += SERVER.format(name="cell-a", host="127.0.0.1", port=server.port)
            refused = self.check(text + SERVER.format(name="cell-b", host="127.0.0.1", port=server.port))
            self.assertEqual(refused.returncode, 78)
            self.assertIn('by bus "cell-a"', refused.stderr)
            gateway = self.start(text + SERVER.format(name="cell-b", host="localhost", port=server.port))
            gateway.wait_for(r"cell-[ab].*is already open as bus cell-[ab]")


if __name__ == "__main__":
    unittest.main()
