#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Who gives commands to the demo's gateway over its control socket, or by a signal: the journal says so, and no more often
than it can be read."""

import os
import signal
import socket
import sys
import time
import unittest

from control_case import MOONS, RELOAD, ControlCase, UnixConnection
from demo_plant import PATIENCE

CLEAR = "/api/v1/clear-counters"
ME = f"uid {os.getuid()}, pid {os.getpid()}"


class ControlAskers(ControlCase):
    def test_the_journal_says_who_asked(self):
        self.assertEqual(self.ask("POST", RELOAD)[0], 200)
        self.plant.wait_for(f"^notice: reload: asked for by the control socket: {ME}$")
        self.plant.wait_for("^info: reload: nothing has changed$")
        self.assertEqual(self.ask("POST", CLEAR)[0], 200)
        self.plant.wait_for(f"^notice: counters cleared over the control socket: {ME}$")
        shown = self.mbgatectl("reload", "--control", self.plant.control)
        self.assertEqual(shown.returncode, 0, shown.stderr)
        pid = int(self.plant.wait_for(rf"asked for by the control socket: uid {os.getuid()}, pid (\d+)$").group(1))
        self.assertNotEqual(pid, os.getpid())
        os.kill(self.plant.pid(), signal.SIGHUP)
        self.plant.wait_for("^notice: reload: asked for by SIGHUP$")

    def test_the_journal_says_who_was_refused(self):
        self.assertEqual(self.ask("POST", RELOAD, headers={"Origin": "http://elsewhere"})[0], 403)
        self.plant.wait_for(
            f"^warning: control socket: POST {RELOAD} was answered 403 Forbidden, asked by {ME}$")
        self.assertEqual(self.ask("POST", "/other?x")[0], 404)
        self.plant.wait_for(f"POST /other was answered 404 Not Found, asked by {ME}$")
        self.assertEqual(self.ask("GET", "/other")[0], 404)  # of which nothing is said
        self.assertEqual(self.ask("POST", "/healthz")[0], 405)
        self.plant.wait_for(f"POST /healthz was answered 405 Method Not Allowed, asked by {ME}$")

    def flood(self, path, seconds):
        """Asks for that long on one connection: how often it was answered what, and how often that may be 200."""
        request = f"POST {path} HTTP/1.1\r\nHost: x\r\nContent-Length: 0\r\n\r\n".encode()
        answered = {}
        with socket.socket(socket.AF_UNIX) as connection:
            connection.settimeout(PATIENCE)
            connection.connect(str(self.plant.control))
            answers = connection.makefile("rb")
            begin = time.monotonic()
            while time.monotonic() < begin + seconds:
                connection.sendall(request)
                code = int(answers.readline().split()[1])
                length, retry = 0, None
                while (line := answers.readline().strip().lower()) != b"":
                    name, _, value = line.partition(b":")
                    length = int(value) if name == b"content-length" else length
                    retry = value.strip() if name == b"retry-after" else retry
                answers.read(length)
                self.assertEqual(retry, b"1" if code == 429 else None)
                answered[code] = answered.get(code, 0) + 1
            return answered, 10 * (2 + int(time.monotonic() - begin))

    def test_a_flood_of_commands_is_refused_and_fills_no_journal(self):
        before = len(self.plant.lines())
        for path, code in ((CLEAR, 200), (RELOAD, 200), ("/other", 404)):
            answered, most = self.flood(path, 2)
            self.assertLessEqual(answered.keys(), {code, 429})
            self.assertLessEqual(answered[code], most)
        # What comes of it is at most ten lines a minute of: cleared, asked, nothing has changed, refused.
        self.assertEqual(self.read(MOONS).returncode, 0)
        lines = self.plant.lines()[before:]
        self.assertLessEqual(len(lines), 2 * 4 * 10, "".join(lines))
        time.sleep(1.1)  # another second
        self.assertEqual(self.ask("POST", CLEAR)[0], 200)
        self.assertEqual(self.ask("GET", "/api/v1/status", UnixConnection(self.plant.control))[0], 200)


if __name__ == "__main__":
    sys.exit(unittest.main())
