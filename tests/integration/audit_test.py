#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Who did it: what the journal of the demo's gateway says of writes, stops, denials and cleared counters."""

import re
import socket
import struct
import unittest

from control_case import MOONS, ControlCase, EventStream, UnixConnection
from demo_plant import PATIENCE

CLEAR = bytes([8, 0, 10, 0, 0])
OWN = 255
WRITE = bytes([16, 0, 0x1E, 0, 2, 4, 0, 3, 0x0D, 0x40])  # a target position of axis-x
WRITTEN = "function 16 at unit 1, holding registers 30..31 = 3 3392"
WRITES = rf"^notice: listener demo: client 127\.0\.0\.1 writes \(device axis-x\): {WRITTEN}$"


class AuditTest(ControlCase):
    def setUp(self):
        super().setUp()
        self.client = socket.create_connection(("127.0.0.1", self.plant.port), PATIENCE)
        self.addCleanup(self.client.close)

    def request(self, unit, pdu):
        """The PDU of the answer."""
        self.client.sendall(struct.pack(">HHHB", 1, 0, len(pdu) + 1, unit) + pdu)
        head = self.client.recv(7, socket.MSG_WAITALL)
        return self.client.recv(struct.unpack(">HHHB", head)[2] - 1, socket.MSG_WAITALL)

    def configure(self, line, changed):
        text = self.plant.configuration.read_text(encoding="utf-8")
        text = re.sub(r"^\[gateway\]\n.*\n", "", text)
        self.plant.configuration.write_text(f"[gateway]\n{line}\n" + text, encoding="utf-8")
        _, body = self.ask("POST", "/api/v1/reload")
        self.assertIn(f"reload: gateway: {changed}", body["messages"])

    def test_the_journal_says_who_has_written(self):
        self.assertEqual(self.request(MOONS, WRITE)[0], 16)
        self.configure("audit = true", "audit false -> true")
        stream = EventStream(UnixConnection(self.plant.control))
        self.addCleanup(stream.close)
        for _ in range(30):  # more than the log takes of one kind
            self.assertEqual(self.request(MOONS, WRITE)[0], 16)
        for _ in range(30):
            self.plant.wait_for(WRITES)
        self.configure("audit = false", "audit true -> false")
        self.assertEqual(self.request(MOONS, WRITE)[0], 16)
        # Those who read along keep their room for what somebody has to act on.
        seen = stream.find("configuration in force")
        self.assertEqual([it for it in seen if "writes" in it["data"]["text"]], [])
        self.assertEqual(self.request(OWN, CLEAR), CLEAR)
        self.plant.wait_for("has cleared all counters")
        self.assertEqual(len([line for line in self.plant.printed() if re.search(WRITES, line)]), 30)

    def test_the_journal_says_who_has_cleared_the_counters(self):
        self.assertEqual(self.request(OWN, CLEAR), CLEAR)
        self.plant.wait_for(r"^notice: listener demo: client 127\.0\.0\.1 has cleared all counters: "
                            "function 8 at unit 255, sub-function 10$")

    def test_a_denied_stop_is_told_though_writes_are_denied_without_end(self):
        self.edit("port = 0\n", 'port = 0\nread_only = ["127.0.0.1"]\n')
        self.assertEqual(self.ask("POST", "/api/v1/reload")[0], 200)
        for _ in range(30):
            self.assertEqual(self.request(MOONS, WRITE), bytes([0x90, 1]))
        self.assertEqual(self.request(MOONS, bytes([6, 0, 0x7C, 0, 0xE1])), bytes([0x86, 1]))
        why = "denied by read_only of listener demo$"
        self.plant.wait_for(rf"^warning: listener demo: client 127\.0\.0\.1: {WRITTEN}, {why}")
        self.plant.wait_for(r"^warning: listener demo: client 127\.0\.0\.1: a stop, function 6 at unit 1, "
                            f"holding register 124 = 225, {why}")
        self.assertEqual(len([line for line in self.plant.printed() if WRITTEN in line]), 1)


if __name__ == "__main__":
    unittest.main()
