#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""mbgatectl doctor at a line whose other end is the test: what is there besides a device, and how it ends."""

import json
import os
import re
import select
import signal
import subprocess
import sys
import termios
import threading
import unittest

from demo_plant import PATIENCE, program
from doctor_lines import ANSWERS, NO_ECHO, QUIET, TIMES, Doctor, beginning, without_figures

READ = bytes.fromhex("05 03 00 00 00 01 85 8e")  # unit 5, holding register 0
ANSWER = bytes.fromhex("05 03 02 12 34 44 f3")
OTHER_READ = bytes.fromhex("09 03 00 00 00 01 85 42")  # unit 9
SECOND_ANSWER = bytes.fromhex("05 03 02 00 07 08 46")


class DoctorAtAScriptedLine(Doctor):
    """The other end of the line is this test."""

    def setUp(self):
        self.folder = "/"
        self.line, self.port = os.openpty()
        self.addCleanup(os.close, self.line)
        self.addCleanup(os.close, self.port)
        self.device = os.ttyname(self.port)

    def follow(self, work):
        """Does `work` again and again in a thread, until the test is over."""
        over = threading.Event()

        def repeat():
            while not over.is_set():
                work()

        thread = threading.Thread(target=repeat)
        thread.start()
        self.addCleanup(thread.join)
        self.addCleanup(over.set)

    def take_request(self):
        request = b""
        while len(request) < len(READ):
            request += os.read(self.line, len(READ) - len(request))
        self.assertEqual(request, READ)

    def reply(self, answer):
        if select.select([self.line], [], [], 0.01)[0]:
            self.take_request()
            os.write(self.line, answer)

    def chatter(self):
        os.write(self.line, READ + ANSWER)
        select.select([], [], [], 0.01)

    def test_knows_two_devices_at_one_address_by_two_answers(self):
        self.follow(lambda: self.reply(ANSWER + SECOND_ANSWER))
        done = self.examine("--device", self.device, "--address", "5", "--timeout", "10s")
        self.check_lines(
            done,
            1,
            [
                *beginning(self.device, "19200 8E1"),
                QUIET,
                NO_ECHO,
                f"ok       answers of unit 5: {ANSWERS}",
                "fault    addresses: 5 of 5 requests to unit 5 had two whole answers, and no request but ours was "
                "heard; two devices at address 5, or another client whose requests are not heard here, or an adapter that "
                "receives what it sends: switch the device off, and see whether something still answers",
            ],
        )

    def test_does_not_send_among_the_frames_of_another_client(self):
        self.follow(self.chatter)
        done = self.examine("--device", self.device, "--address", "5")
        # The first frame may have lost its begin when the port was opened.
        text = re.sub(r"\d+ frames heard in 200ms, the first: .*?;", "FRAMES;", done.stdout)
        self.assertEqual(
            (text.splitlines()[5:], done.returncode),
            (
                [
                    "fault    idle line: another client is on this line: FRAMES; an RS-485 line has one client: let "
                    "the other one (a gateway, a PLC, a tool) connect to the gateway instead",
                    "unknown  answers: no device was asked: requests would damage the frames of the other client",
                ],
                1,
            ),
        )

    def test_ends_with_what_was_found_when_it_is_interrupted(self):
        command = [program("mbgatectl"), "doctor", "--device", self.device, "--address", "5", "--json"]
        # The second answer is waited for longer than this test lasts.
        command += ["--listen", "1ms", "--timeout", "1h"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as doctor:
            self.wait_for_request()
            self.take_request()
            os.write(self.line, ANSWER)
            self.wait_for_request()
            doctor.send_signal(signal.SIGINT)
            printed, _ = doctor.communicate(timeout=PATIENCE)
        self.assertEqual(doctor.returncode, 1)
        found = json.loads(printed)
        self.assertEqual(found["error"], "interrupted")
        answers = [finding["seen"] for finding in found["findings"] if finding["step"] == "answers of unit 5"]
        self.assertEqual([without_figures(seen) for seen in answers], [f"1 of 1 requests answered, {TIMES}"])

    def test_asks_nobody_any_more_when_it_hears_a_request_of_another_client(self):
        self.follow(lambda: self.reply(ANSWER + OTHER_READ))
        done = self.examine("--device", self.device, "--address", "5,6", "--timeout", "10s")
        self.check_lines(
            done,
            1,
            [
                *beginning(self.device, "19200 8E1"),
                QUIET,
                "fault    other client: a request of another client was heard: unit 9: read holding registers 0; no more requests were sent; an RS-485 line has one client: let the other one (a gateway, a PLC, a tool) "
                "connect to the gateway instead",
                NO_ECHO,
                f"ok       answers of unit 5: 1 of 1 requests answered, {TIMES}",
                "ok       addresses: no request had a second answer",
            ],
        )

    def test_asks_nobody_where_what_is_heard_may_be_another_client(self):
        def disturb():
            os.write(self.line, b"\0\0\0")
            select.select([], [], [], 0.01)

        self.follow(disturb)
        done = self.examine("--device", self.device, "--address", "5")
        self.assertEqual(
            (re.sub(r"\d+ bytes", "N bytes", done.stdout).splitlines()[5:], done.returncode),
            (
                [
                    "fault    idle line: N bytes heard in 200ms that are not a frame at 19200 8E1: "
                    "00 00 00 00 00 00 00 00 ..; looks like a line without an idle level (are A and B exchanged, is bias or termination missing, is a wire loose?), or like another client at another rate or parity",
                    "unknown  answers: no device was asked: these bytes may be from another client, and requests would damage its frames",
                ],
                1,
            ),
        )

    def test_gives_the_port_its_settings_back(self):
        before = termios.tcgetattr(self.port)
        self.follow(lambda: self.reply(ANSWER))
        done = self.examine("--device", self.device, "--address", "5", "--timeout", "10s")
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertEqual(termios.tcgetattr(self.port), before)

    def wait_for_request(self):
        self.assertTrue(select.select([self.line], [], [], PATIENCE)[0], "nothing was asked")


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
