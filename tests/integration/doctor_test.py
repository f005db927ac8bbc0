#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""mbgatectl doctor at lines on which something is wrong: it says what, and accuses nobody where all is well."""

import fcntl
import json
import os
import pathlib
import re
import select
import signal
import subprocess
import sys
import tempfile
import threading
import unittest

from demo_plant import PATIENCE, Process, program

# On each line the same two drives; unit 3 is the one with a fault.
FAULTS = {"healthy": "", "dead": "faults = { silent = true }", "damaged": "faults = { bad_crc = true }", "hearing": ""}
READ = bytes.fromhex("05 03 00 00 00 01 85 8e")  # unit 5, holding register 0
ANSWER = bytes.fromhex("05 03 02 12 34 44 f3")
SECOND_ANSWER = bytes.fromhex("05 03 02 00 07 08 46")


def simulator_configuration():
    text = ""
    for line, fault in FAULTS.items():
        echo = "echo = true\n" if line == "hearing" else ""
        text += f'[[bus]]\nname = "{line}"\nlink = "{line}"\nbaud = 19200\nparity = "none"\n{echo}'
        for address, keys in ((3, fault), (17, "")):
            text += f'[[device]]\nname = "{line}-{address}"\nbus = "{line}"\naddress = {address}\n'
            text += f'model = "stepper"\n{keys}\n'
    return text


def gateway_configuration():
    text = ""
    for line in FAULTS:
        echo = "echo = false\n" if line == "hearing" else ""
        text += f'[[bus]]\nname = "{line}"\ndevice = "./{line}"\nbaud = 19200\nparity = "none"\n{echo}'
        text += f'[[listen]]\nname = "to-{line}"\nport = 0\nbus = "{line}"\n'
        for address, name in ((3, "lift"), (17, "belt")):
            text += f'[[device]]\nname = "{line}-{name}"\nbus = "{line}"\naddress = {address}\n'
            # A busy machine may be slow, but what is dead is dead.
            text += f'response_timeout = "{"500ms" if (line, address) == ("dead", 3) else "10s"}"\n'
    return text


def without_figures(text):
    """Times and numbers of processes are those of this run."""
    return re.sub(r"process \d+", "process P", re.sub(r"\d+\.\d ms", "T", text))


def beginning(device, mode):
    return [
        f"ok       port: {device} is there",
        f"ok       permission: USER may open {device}",
        "ok       holder: no other program is seen to have it open",
        "unknown  latency: PTY is no FTDI adapter, or does not show its timer",
        f"ok       settings: {mode} is set and was read back",
    ]


TIMES = "T to T after the request, half of them within T"
ANSWERS = f"5 of 5 requests answered, {TIMES}"
NO_ECHO = "ok       echo: no request came back to the port"
QUIET = "ok       idle line: nothing was heard in 200ms"


class Doctor(unittest.TestCase):
    def examine(self, *options):
        command = [program("mbgatectl"), "doctor", "--requests", "5", "--listen", "200ms", *options]
        return subprocess.run(
            command, cwd=self.folder, capture_output=True, text=True, timeout=4 * PATIENCE, check=False
        )

    def check_lines(self, done, status, expected):
        text = re.sub(r"permission: \S+ may", "permission: USER may", without_figures(done.stdout))
        text = re.sub(r"latency: /dev/pts/\d+", "latency: PTY", text)
        self.assertEqual((text.splitlines(), done.returncode), (expected, status), done.stderr)


class DoctorAtTheSimulator(Doctor):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        (cls.folder / "sim.toml").write_text(simulator_configuration(), encoding="utf-8")
        (cls.folder / "mbgate.toml").write_text(gateway_configuration(), encoding="utf-8")
        drives = Process(cls.folder, "mbgate-sim", "sim.toml")
        cls.addClassCleanup(drives.end)
        drives.wait_for("^ready")

    def examine_bus(self, bus, *options):
        return self.examine("--config", "mbgate.toml", "--bus", bus, *options)

    def test_finds_nothing_wrong_with_a_healthy_line(self):
        done = self.examine_bus("healthy")
        self.check_lines(
            done,
            0,
            [
                *beginning("./healthy", "19200 8N1"),
                QUIET,
                NO_ECHO,
                f"ok       answers of unit 3 (healthy-lift): {ANSWERS}",
                f"ok       answers of unit 17 (healthy-belt): {ANSWERS}",
                "ok       addresses: no request had a second answer",
            ],
        )
        self.assertEqual(
            done.stderr,
            "examining ./healthy at 19200 8N1: listens for 200ms, then reads holding register 0 5 times of each of "
            "2 units; nothing is written\n",
        )

    def test_says_it_in_json(self):
        done = self.examine_bus("healthy", "--address", "17", "--json")
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        found = json.loads(done.stdout)
        self.assertEqual(found["device"], "./healthy")
        self.assertNotIn("error", found)
        self.assertEqual(
            [(finding["step"], finding["verdict"]) for finding in found["findings"]],
            [
                ("port", "ok"),
                ("permission", "ok"),
                ("holder", "ok"),
                ("latency", "unknown"),
                ("settings", "ok"),
                ("idle line", "ok"),
                ("echo", "ok"),
                ("answers of unit 17 (healthy-belt)", "ok"),
                ("addresses", "ok"),
            ],
        )

    def test_looks_at_a_dead_drive_alone_where_another_answers(self):
        self.check_lines(
            self.examine_bus("dead"),
            1,
            [
                *beginning("./dead", "19200 8N1"),
                QUIET,
                NO_ECHO,
                "fault    answers of unit 3 (dead-lift): no answer to 3 requests: not a byte was heard; "
                "look at its power, its address, its wires, its rate and parity",
                f"ok       answers of unit 17 (dead-belt): {ANSWERS}",
                "ok       addresses: no request had a second answer",
            ],
        )

    def test_names_all_that_looks_like_a_wrong_rate(self):
        self.check_lines(
            self.examine("--device", "healthy", "--baud", "9600", "--address", "3", "--timeout", "100ms"),
            1,
            [
                *beginning("healthy", "9600 8E1"),
                QUIET,
                NO_ECHO,
                "fault    answers of unit 3: no answer to 3 requests: not a byte was heard; "
                "look at power; A and B; the address of the drive; its rate and parity, here 9600 8E1: "
                "mbgatectl scan --device healthy finds those that answer",
                "unknown  addresses: no answer was understood",
            ],
        )

    def test_says_the_share_of_bad_crcs_and_what_else_would_look_so(self):
        self.check_lines(
            self.examine_bus("damaged"),
            1,
            [
                *beginning("./damaged", "19200 8N1"),
                QUIET,
                NO_ECHO,
                "fault    answers of unit 3 (damaged-lift): no answer to 5 requests: 5 with a bad CRC (100 %); "
                "two devices at this address whose answers overlap, or its own rate, parity, wires or transceiver: "
                "switch it off, and see whether something still answers",
                f"ok       answers of unit 17 (damaged-belt): {ANSWERS}",
                "unknown  addresses: each answer of unit 3 (damaged-lift) is damaged (up to 7 bytes), while others "
                "answer well: two devices whose answers overlap would look so, and so would its own rate, parity, "
                "wires or transceiver; switch it off: if something still answers, there is a second one",
            ],
        )

    def test_says_that_the_port_hears_itself_where_the_bus_denies_it(self):
        done = self.examine_bus("hearing", "--address", "3")
        self.check_lines(
            done,
            1,
            [
                *beginning("./hearing", "19200 8N1"),
                QUIET,
                "fault    echo: the port hears what it sends: each request came back before its answer, and the bus "
                'has echo = false; set echo = true or "auto"',
                f"ok       answers of unit 3 (hearing-lift): {ANSWERS}",
                "ok       addresses: no request had a second answer",
            ],
        )

    def test_asks_nobody_where_it_is_not_known_who_is_there(self):
        self.check_lines(
            self.examine("--device", "healthy"),
            0,
            [
                *beginning("healthy", "19200 8E1"),
                QUIET,
                "unknown  answers: nobody was asked: it is not known who is there: name a unit with --address, or find "
                "one with mbgatectl scan --device healthy",
            ],
        )

    def test_leaves_a_port_alone_that_a_gateway_holds(self):
        gateway = Process(self.folder, "mbgated", "--config", "mbgate.toml")
        self.addCleanup(gateway.end)
        gateway.wait_for("bus healthy is open")
        self.check_lines(
            self.examine("--device", "healthy", "--address", "3"),
            1,
            self.refused(
                "mbgated (process P)", "ask it with mbgatectl status, or stop it: sudo systemctl stop mbgated"
            ),
        )

    def test_leaves_a_port_alone_that_another_program_holds(self):
        name = pathlib.Path(f"/proc/{os.getpid()}/comm").read_text(encoding="utf-8").strip()
        with open(self.folder / "healthy", "rb", buffering=0) as port:
            fcntl.flock(port, fcntl.LOCK_EX)
            done = self.examine("--device", "healthy", "--address", "3")
        self.check_lines(done, 1, self.refused(f"{name} (process P)", "end it first"))

    @staticmethod
    def refused(holder, advice):
        held = f"fault    holder: {holder} has healthy open, and it is locked; {advice}"
        return [*beginning("healthy", "")[:2], held]

    def test_says_that_there_is_no_such_port_and_no_such_bus(self):
        done = self.examine("--device", "/dev/no-such-port")
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stdout, "^fault    port: there is no serial port /dev/no-such-port")
        done = self.examine_bus("attic")
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertEqual(
            done.stderr,
            "mbgatectl: there is no bus attic in the configuration; there is healthy, dead, damaged, hearing\n",
        )
        done = self.examine("--config", "missing.toml")
        self.assertEqual((done.returncode, done.stdout), (78, ""))


class DoctorAtAScriptedLine(Doctor):
    """The other end of the line is this test."""

    def setUp(self):
        self.folder = "/"
        self.line, port = os.openpty()
        self.addCleanup(os.close, self.line)
        self.addCleanup(os.close, port)
        self.device = os.ttyname(port)

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

    def answer_twice(self):
        if select.select([self.line], [], [], 0.01)[0]:
            request = b""
            while len(request) < len(READ):
                request += os.read(self.line, len(READ) - len(request))
            self.assertEqual(request, READ)
            os.write(self.line, ANSWER + SECOND_ANSWER)

    def chatter(self):
        os.write(self.line, READ + ANSWER)
        select.select([], [], [], 0.01)

    def test_knows_two_devices_at_one_address_by_two_answers(self):
        self.follow(self.answer_twice)
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
                "heard; two devices have address 5: switch one of them off, and give the other another address",
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
                    "unknown  answers: nobody was asked: that would damage the frames of the other client",
                ],
                1,
            ),
        )

    def test_ends_with_what_was_found_when_it_is_interrupted(self):
        command = [program("mbgatectl"), "doctor", "--device", self.device, "--address", "5", "--json"]
        with subprocess.Popen([*command, "--listen", "1ms"], stdout=subprocess.PIPE, text=True) as doctor:
            self.assertTrue(select.select([self.line], [], [], PATIENCE)[0], "nothing was asked")
            doctor.send_signal(signal.SIGINT)
            os.write(self.line, ANSWER)
            printed, _ = doctor.communicate(timeout=PATIENCE)
        self.assertEqual(doctor.returncode, 1)
        found = json.loads(printed)
        self.assertEqual(found["error"], "interrupted")
        self.assertIn("answers of unit 5", [finding["step"] for finding in found["findings"]])


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
