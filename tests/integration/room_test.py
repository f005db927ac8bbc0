#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Silent connections fill a listener beside a PLC that is idle between two polls: the PLC keeps its connection, and the
failsafe write of its drive is not sent."""

import re
import socket
import time
import unittest

from demo_plant import PATIENCE
from fault_plant import DRIVE, FaultCase, write_of

STOP = 0xE2


class Room(FaultCase):
    def begin(self, limits):
        """The PLC has written, and is idle."""
        self.drives = self.line()
        text = self.configuration.read_text(encoding="utf-8")
        text = re.sub(r"(?m)^max_.*\n", "", text).replace('name = "plant"\n', f'name = "plant"\n{limits}')
        text += f'[[device]]\nname = "axis"\nbus = "line-a"\naddress = {DRIVE}\n'
        text += f"failsafe = [{{ address = 0, value = {STOP} }}]\n"
        self.configuration.write_text(text, encoding="utf-8")
        self.start()
        plc = self.client()
        self.assertEqual(plc.write(1), write_of(1))
        return plc

    def come(self, address):
        """A connection that says nothing."""
        connection = socket.create_connection(("127.0.0.1", self.port), PATIENCE, (address, 0))
        self.addCleanup(connection.close)

    def wait_for_displaced(self, number):
        limit = time.monotonic() + PATIENCE
        while self.listener()["displaced"]["max_connections"] < number:
            self.assertLess(time.monotonic(), limit, self.listener())
            time.sleep(0.05)

    def listener(self):
        return self.ask("GET", "/api/v1/status")[1]["listeners"][0]

    def assert_plc_stayed(self, plc):
        self.assertEqual(plc.write(2), write_of(2))
        self.assertEqual(self.drives.writes, [1, 2])

    def test_silent_connections_do_not_displace_a_plc(self):
        plc = self.begin("max_connections = 32\n")
        for _ in range(33):
            self.come("127.0.0.9")
        self.wait_for_displaced(2)
        self.assert_plc_stayed(plc)
        self.assertTrue(self.gateway.wait_for(r"client 127\.0\.0\.9 closed for a newcomer: max_connections \(32\)"))

    def test_not_from_several_addresses_at_the_default_limits(self):
        plc = self.begin("max_connects_per_second = 0\n")
        for address in range(10, 14):
            for _ in range(64):
                self.come(f"127.0.0.{address}")
        self.wait_for_displaced(1)
        self.assert_plc_stayed(plc)


if __name__ == "__main__":
    unittest.main()
