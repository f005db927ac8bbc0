#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Failsafe writes on the line of a drive: whose leaving sends them, and that they go on until the drive has acknowledged
them. What is judged is the order of the writes on the line."""

import os
import signal
import threading
import time
import unittest

from demo_plant import PATIENCE
from fault_plant import DRIVE, Client, FaultCase, NotedLine, exception, read_of, write_of

STOP = 0xE2
OTHER = 2  # the unit of another drive
GRACE = os.environ.get("MBGATE_TEST_GRACE", 'failsafe_grace = "{}"')  # empty: a program that does not know the key


class Drives(NotedLine):
    """Two drives, of which the first does not take its failsafe write as long as it is deaf."""

    deaf = False

    def say(self, data):
        is_failsafe = data[0] == DRIVE and data[1:6] == write_of(STOP)
        if not (self.deaf and is_failsafe):
            super().say(data)


class Failsafe(FaultCase):
    def begin(self, grace="100ms"):
        self.drives = self.enterContext(Drives())
        self.configure(self.drives.path)
        text = self.configuration.read_text(encoding="utf-8")
        text = text.replace('response_timeout = "2s"', 'response_timeout = "200ms"\nprobe_interval = "500ms"')
        text += f'[[device]]\nname = "axis"\nbus = "line-a"\naddress = {DRIVE}\n{GRACE.format(grace)}\n'
        text += f"failsafe = [{{ address = 0, value = {STOP} }}]\n"
        text += f'[[route]]\nunit = {OTHER}\nbus = "line-a"\naddress = {OTHER}\n'
        self.configuration.write_text(text, encoding="utf-8")
        self.start()

    def written(self, count=1):
        """The writes on the line, once the drive has got so many failsafe writes."""
        limit = time.monotonic() + PATIENCE
        while self.drives.writes.count(STOP) < count:
            self.assertLess(time.monotonic(), limit, f"only {self.drives.writes}")
            time.sleep(0.01)
        return self.drives.writes

    def write(self, client, value):
        self.assertEqual(client.write(value), write_of(value))

    def reload(self, old, new):
        text = self.configuration.read_text(encoding="utf-8")
        self.configuration.write_text(text.replace(old, new), encoding="utf-8")
        self.gateway.signal(signal.SIGHUP)
        self.gateway.wait_for("reload: done")

    def test_a_drive_that_is_renamed_is_the_same(self):
        self.begin()
        client = self.client()
        self.write(client, 1)
        self.reload('name = "axis"', 'name = "axis-x"')
        self.write(client, 2)
        client.close()
        self.assertEqual(self.written(), [1, 2, STOP])
        self.gateway.wait_for("device axis-x: the client that counts for it has gone; the device has acknowledged")

    def test_they_go_on_until_the_drive_has_acknowledged_them_though_nobody_asks(self):
        self.begin()
        self.drives.deaf = True
        client = self.client()
        self.write(client, 1)
        client.close()
        self.gateway.wait_for("device axis: .* its failsafe writes are not acknowledged yet")
        self.written(8)  # more than the tries of a stop
        self.drives.deaf = False
        self.gateway.wait_for("the device has acknowledged its failsafe writes")
        count = len(self.drives.writes)
        with_other = self.client()
        self.write(with_other, 3)
        self.assertEqual(self.drives.writes[count:], [3])

    def test_who_reads_only_the_gateway_arms_nothing(self):
        self.begin()
        monitor = self.client()
        self.assertEqual(monitor.ask(b"\x04\x00\x00\x00\x01", 255)[:1], b"\x04")
        monitor.close()
        reader = self.client()
        reader.ask(read_of(0))
        reader.close()
        time.sleep(0.3)  # longer than the grace: what could be sent is sent before the write
        client = self.client()
        self.write(client, 1)
        self.assertEqual(self.drives.writes, [1])

    def test_a_connection_for_each_write_is_no_reason(self):
        self.begin(grace="3s")
        for value in range(1, 6):
            client = self.client()
            self.write(client, value)
            client.close()
        self.assertEqual(self.written(), [1, 2, 3, 4, 5, STOP])

    def test_a_panel_that_polls_another_drive_holds_nothing_off(self):
        self.begin()
        panel = Client(self.port, "127.0.0.2")
        self.addCleanup(panel.close)
        ended = threading.Event()

        def poll():
            while not ended.wait(0.02):
                panel.ask(read_of(0), OTHER)

        panel.ask(read_of(0), OTHER)
        thread = threading.Thread(target=poll)
        thread.start()
        self.addCleanup(thread.join)
        self.addCleanup(ended.set)
        client = self.client()
        self.write(client, 1)
        client.close()
        self.assertEqual(self.written(), [1, STOP])


if __name__ == "__main__":
    unittest.main()
