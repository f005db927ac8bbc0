#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""mbgatectl doctor at lines on which something is wrong: it says what, and accuses nobody where all is well."""

import fcntl
import json
import os
import pathlib
import sys
import tempfile
import unittest

from demo_plant import Process
from doctor_lines import ANSWERS, NO_ECHO, QUIET, Doctor, beginning

# On each line the same two drives; unit 3 is the one with a fault.
FAULTS = {"healthy": "", "dead": "faults = { silent = true }", "damaged": "faults = { bad_crc = true }", "hearing": ""}


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
            # A busy machine may be slow, but what is dead is dead. And a good answer is waited for in vain five times
            # where all are damaged.
            timeout = {("dead", 3): "500ms", ("damaged", 3): "2s"}.get((line, address), "10s")
            text += f'response_timeout = "{timeout}"\n'
    return text


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
                ("settings", "unknown"),
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
                "unknown  addresses: each answer of unit 3 (damaged-lift) is damaged (up to 7 bytes), while others answer well: two devices whose answers overlap look like this, and so does a device with a wrong rate or parity, bad wires or a bad transceiver; switch it off: if something still answers, there is a second one",
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
                "fault    echo: the port receives what it sends: each request came back before its answer, and the bus "
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
                "unknown  answers: no device was asked: no unit is known: name one with --address, or find one with mbgatectl scan --device healthy",
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
            "mbgatectl: the configuration has no bus attic; it has healthy, dead, damaged, hearing\n",
        )
        done = self.examine("--config", "missing.toml")
        self.assertEqual((done.returncode, done.stdout), (78, ""))


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
