#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Stops on the line of a drive: what is one, and what becomes of those that the drive refuses."""

import time
import unittest

from demo_plant import CONFIGURATION
from fault_plant import BUSY, DEAF, DRIVE, FaultCase, NotedLine, exception, registers_of
from scripted_line import framed

JOG = 0x00CA  # the stepper's; torque mode is behind it
STOP_WAIT = 0.1  # seconds, the default
TRIES = 4


def jog_of(value):
    return b"\x06" + JOG.to_bytes(2, "big") + value.to_bytes(2, "big")


class Drive(NotedLine):
    """Answers the next writes with these PDUs, then as asked; notes what it heard, and when it had answered."""

    def __init__(self):
        super().__init__()
        self.answers = []
        self.pdus = []
        self.gaps = []  # seconds from an answer of `answers` to the next write
        self._answered_at = None
        self._on_request = Drive._answer_write

    def _answer_write(self, request):
        unit, pdu = request[0], request[1:-2]
        if unit == DEAF:
            self.heard.set()
            return
        self.pdus.append(pdu)
        if self._answered_at is not None:
            self.gaps.append(time.monotonic() - self._answered_at)
        given = self.answers.pop(0) if self.answers else None
        # Before it says anything: what is measured is never shorter than what passed.
        self._answered_at = time.monotonic() if given else None
        self.say(framed(bytes([unit]) + (given or pdu[:5])))


class Stops(FaultCase):
    def begin(self, profile, more=""):
        self.drive = self.enterContext(Drive())
        self.configure(self.drive.path, route='deadline = "20s"')
        text = self.configuration.read_text(encoding="utf-8")
        text = text.replace('response_timeout = "2s"', 'response_timeout = "600ms"\nretries = 0')
        text += f'[gateway]\nprofiles = "{CONFIGURATION}/profiles"\n'
        text += f'[[device]]\nname = "axis"\nbus = "line-a"\naddress = {DRIVE}\nprofile = "{profile}"\n{more}\n'
        self.configuration.write_text(text, encoding="utf-8")
        self.start()
        return self.client()

    def behind_a_jog(self, write):
        """What the drive has heard, and the answers to the jog and the write behind it, which waited for a deaf one."""
        client = self.begin("rs485-stepper")
        client.send(b"\x03\x00\x00\x00\x01", DEAF)
        client.send(jog_of(1))
        client.send(write)
        answers = [client.receive() for _ in range(3)]
        self.assertTrue(self.drive.heard.is_set())
        return self.drive.pdus, [pdu for pdu in answers if pdu[0] & 0x7F != 3]

    def test_a_write_of_several_registers_that_all_stop_takes_the_jog_back_that_waits(self):
        stop = registers_of(JOG, 0, 0)
        heard, answers = self.behind_a_jog(stop)
        self.assertEqual(heard, [stop])
        self.assertCountEqual(answers, [exception(6, BUSY), stop[:5]])

    def test_one_of_which_a_register_moves_something_waits_for_its_turn(self):
        write = registers_of(JOG, 1, 0)
        heard, answers = self.behind_a_jog(write)
        self.assertEqual(heard, [jog_of(1), write])
        self.assertEqual(answers, [jog_of(1), write[:5]])

    def test_a_stop_that_is_refused_is_sent_again_and_its_client_gets_the_echo(self):
        client = self.begin("rs485-stepper")
        self.drive.answers = [exception(6, code) for code in (0x05, 0x0A, 0x0B)]
        self.assertEqual(client.ask(jog_of(0)), jog_of(0))
        self.assertEqual(self.drive.pdus, [jog_of(0)] * TRIES)
        self.assertGreaterEqual(min(self.drive.gaps), STOP_WAIT)

    def test_one_that_is_refused_to_the_end_is_told(self):
        client = self.begin("rs485-stepper")
        self.drive.answers = [exception(6, BUSY)] * TRIES
        self.assertEqual(client.ask(jog_of(0)), exception(6, BUSY))
        self.assertEqual(self.drive.pdus, [jog_of(0)] * TRIES)
        self.gateway.wait_for(r"device axis: a stop command was refused with exception 0x06")
        findings = [finding["finding"] for finding in self.ask("GET", "/api/v1/status")[1]["diagnoses"]]
        self.assertIn("it has refused a stop", findings)
        self.assertEqual(client.ask(jog_of(0)), jog_of(0))
        self.assertEqual(self.ask("GET", "/api/v1/status")[1]["diagnoses"], [])

    def test_an_exception_that_the_profile_calls_an_acceptance_is_one(self):
        client = self.begin("higen-fda6000", "stops = [{ address = 1100, value = 0 }]")
        stop = b"\x06" + (1100).to_bytes(2, "big") + bytes(2)
        self.drive.answers = [exception(6, 0x05)]
        self.assertEqual(client.ask(stop), exception(6, 0x05))
        self.assertEqual(client.ask(registers_of(200, 1))[:1], b"\x10")  # a stop would go before it
        self.assertEqual(self.drive.pdus.count(stop), 1)
        self.assertEqual(self.lines("a stop command"), [])


if __name__ == "__main__":
    unittest.main()
