#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What a gateway learns of a line's echo, nobody having said whether there is one: from a drive that answers one write
oddly, and from a line that echoes while its drive is switched off."""

import os
import select
import unittest

from fault_plant import NO_ANSWER, FaultCase, exception, write_of
from scripted_line import ScriptedLine, answer_to, framed

WRITES = 39
WRITE_MULTIPLE = 16
READ = b"\x03\x00\x00\x00\x01"
MULTIPLE = bytes([WRITE_MULTIPLE, 0, 0, 0, 1, 2, 0, 1])


class Line(ScriptedLine):
    """A line whose requests have their own lengths. `answer(number, request)` is what comes back, at once."""

    def __init__(self, answer):
        super().__init__(None)
        self._answer = answer
        self.requests = 0

    def _serve(self):
        heard = b""
        while not self.ended.is_set():
            if not select.select([self._ours], [], [], 0.05)[0]:
                continue
            heard += os.read(self._ours, 4096)
            while len(heard) >= 8 and len(heard) >= (size := 9 + heard[6] if heard[1] == WRITE_MULTIPLE else 8):
                request, heard = heard[:size], heard[size:]
                self.ended.wait(self.EMISSION)
                self.requests += 1
                self.say(self._answer(self.requests, request))


def answered(request):
    return framed(request[:6]) if request[1] == WRITE_MULTIPLE else answer_to(request)


class EchoLearning(FaultCase):
    def attach(self, answer):
        line = self.enterContext(Line(answer))
        self.configure(line.path, keys='echo = "auto"')
        text = self.configuration.read_text(encoding="utf-8").replace('"2s"', '"300ms"')
        self.configuration.write_text(text, encoding="utf-8")
        self.start()
        return line

    def test_one_odd_answer_is_no_echo(self):
        """The second request is answered with the whole of it."""
        self.attach(lambda number, request: request if number == 2 else answered(request))
        client = self.client()
        self.assertEqual(client.ask(READ), b"\x03\x02\x12\x34")
        client.ask(MULTIPLE)  # its drive has done it, and nobody knows
        done = sum(client.ask(write_of(value)) == write_of(value) for value in range(WRITES))
        self.assertEqual(done, WRITES)
        self.assertEqual(client.ask(READ), b"\x03\x02\x12\x34")
        self.assertEqual(self.lines("receives what it sends"), [])

    def test_an_echo_without_a_drive_acknowledges_nothing(self):
        line = self.attach(lambda _, request: request)
        client = self.client()
        for value in (1, 2):
            self.assertEqual(client.ask(write_of(value)), exception(6, NO_ANSWER))
        self.assertEqual(line.requests, 2)
        self.gateway.wait_for("a write came back unchanged, and no read has shown yet")

    def test_a_drive_behind_an_echo_is_understood(self):
        self.attach(lambda _, request: request + answered(request))
        client = self.client()
        self.assertEqual(client.ask(READ), b"\x03\x02\x12\x34")
        for value in (1, 2):
            self.assertEqual(client.ask(write_of(value)), write_of(value))
        self.assertEqual(client.ask(MULTIPLE), MULTIPLE[:5])
        self.gateway.wait_for("the adapter receives what it sends")


if __name__ == "__main__":
    unittest.main()
