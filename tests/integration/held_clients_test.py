#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Clients that max_requests_per_second holds up, and the failsafe writes of their drive: a client that is held up is
there, and what it asked goes if it stays, never if it goes. What is judged is the order of the writes on the line."""

import signal
import time
import unittest

from demo_plant import PATIENCE
from fault_plant import DRIVE, FaultCase, write_of

STOP = 0xE2
HELD = range(2, 6)  # what clients that are held up write, one a second


class HeldClients(FaultCase):
    def begin(self, quiet="0s"):
        """A client has used the place of this second, and is connected."""
        self.drives = self.line()
        text = self.configuration.read_text(encoding="utf-8")
        text = text.replace("max_requests_per_second = 0", "max_requests_per_second = 1")
        text += f'[[device]]\nname = "axis"\nbus = "line-a"\naddress = {DRIVE}\nquiet = "{quiet}"\n'
        text += f"failsafe = [{{ address = 0, value = {STOP} }}]\n"
        # What is held up waits for longer than a write may.
        text = text.replace("[[route]]\n", '[[route]]\ndeadline = "60s"\n')
        self.configuration.write_text(text, encoding="utf-8")
        self.start()
        first = self.client()
        self.assertEqual(first.write(1), write_of(1))
        return first

    def written(self):
        """The writes on the line, once the drive has got its failsafe write."""
        limit = time.monotonic() + PATIENCE
        while STOP not in self.drives.writes:
            self.assertLess(time.monotonic(), limit, f"only {self.drives.writes}")
            time.sleep(0.01)
        return self.drives.writes

    def held_clients(self):
        """Each has sent a write, its first request."""
        clients = [self.client() for _ in HELD]
        for client, value in zip(clients, HELD, strict=True):
            client.send(write_of(value))
        self.gateway.wait_for("max_requests_per_second")
        return clients

    def test_one_that_is_held_up_is_not_silent(self):
        first = self.begin(quiet="3s")
        for value in HELD:
            first.send(write_of(value))
        self.assertEqual([first.receive() for _ in HELD], [write_of(value) for value in HELD])
        self.assertEqual(self.written(), [1, *HELD, STOP])

    def test_one_whose_first_request_is_held_up_is_there_after_a_reload(self):
        first = self.begin()
        clients = self.held_clients()
        first.close()
        text = self.configuration.read_text(encoding="utf-8")
        self.configuration.write_text(text + '[[route]]\nunit = 5\ndevice = "axis"\n', encoding="utf-8")
        self.gateway.signal(signal.SIGHUP)
        self.gateway.wait_for("reload: done")
        self.assertEqual([client.receive() for client in clients], [write_of(value) for value in HELD])
        for client in clients:
            client.close()
        self.assertEqual(self.written(), [1, *HELD, STOP])

    def test_what_one_asked_that_goes_is_never_sent(self):
        first = self.begin()
        clients = self.held_clients()
        for client in reversed(clients):
            client.close()
        first.close()
        writes = self.written()
        time.sleep(1.5)  # the next turn would come
        self.assertEqual(writes[-1], STOP)
        self.assertNotIn(HELD[-1], writes)


if __name__ == "__main__":
    unittest.main()
