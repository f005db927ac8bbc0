#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The control socket of the demo's gateway: every answer is held to docs/api.yaml, and mbgatectl says what it says."""

import json
import re
import socket
import stat
import subprocess
import sys
import unittest

from control_case import EVENTS, MOONS, ControlCase
from demo_plant import PATIENCE, program

FEEDER = 2  # the unit of another drive on the same line


class ControlSocket(ControlCase):
    def test_the_status_shows_lines_drives_and_clients(self):
        for _ in range(5):
            self.assertEqual(self.read(MOONS).returncode, 0)
        client = socket.create_connection(("127.0.0.1", self.plant.port), PATIENCE)
        self.addCleanup(client.close)
        client.sendall(bytes.fromhex("0001 0000 0006 01 03 0000 0001"))
        self.assertEqual(len(client.recv(100)), 11)
        status = self.status()
        self.assertEqual([bus["name"] for bus in status["buses"]], ["line-a", "line-b"])
        self.assertTrue(all(bus["open"] for bus in status["buses"]))
        self.assertEqual((status["buses"][0]["baud"], status["buses"][0]["format"]), (115200, "8N1"))
        axis = self.device("axis-x")
        self.assertEqual(axis["state"], "answering")
        self.assertLess(axis["state_since_s"], status["uptime_s"])
        self.assertGreaterEqual(axis["counters"]["responses"], 6)
        self.assertGreater(axis["latency_ms"]["device"]["p50"], 0)
        self.assertEqual([(it["listener"], it["requests"]) for it in status["clients"]], [("demo", 1)])
        self.assertEqual(status["diagnoses"], [])

    def test_a_drive_that_is_not_there_is_named(self):
        self.edit('name = "axis-x"\nbus = "line-a"\naddress = 1\n', 'name = "axis-x"\nbus = "line-a"\naddress = 99\n')
        self.assertEqual(self.mbgatectl("reload", "--control", self.plant.control).returncode, 0)
        for _ in range(3):
            self.read(MOONS)
        self.read(FEEDER)
        diagnoses = self.status()["diagnoses"]
        self.assertEqual([(it["subject"], it["finding"]) for it in diagnoses], [("device axis-x", "it has never answered")])
        shown = self.mbgatectl("status", "--control", self.plant.control)
        self.assertEqual(shown.returncode, 0, shown.stderr)
        self.assertIn("FAULTS\n  device axis-x: it has never answered\n", shown.stdout)
        # The worst comes first.
        self.assertRegex(shown.stdout, r"DEVICE +BUS +ADDRESS +STATE .*\naxis-x +line-a +99 ")

    def test_mbgatectl_prints_the_status_as_it_came(self):
        shown = self.mbgatectl("status", "--json", "--control", self.plant.control)
        self.assertEqual(shown.returncode, 0, shown.stderr)
        self.assertEqual(json.loads(shown.stdout).keys(), self.status().keys())
        text = self.mbgatectl("status", "--control", self.plant.control).stdout
        self.assertIn("No faults found.\n", text)
        self.assertRegex(text, r"\nline-b +\./line-b +9600 8E1 +open ")

    def test_a_reload_says_what_has_changed(self):
        code, body = self.ask("POST", "/api/v1/reload")
        self.assertEqual((code, body["messages"][:-1]), (200, ["reload: nothing has changed"]))
        self.edit("baud = 9600", "baud = 19200")
        shown = self.mbgatectl("reload", "--control", self.plant.control)
        self.assertEqual(shown.returncode, 0, shown.stderr)
        self.assertIn("bus line-b: baud 9600", shown.stdout)
        self.assertEqual(self.status()["buses"][1]["baud"], 19200)

    def digest(self):
        """What the command of --check prints of the files of now."""
        checked = subprocess.run([program("mbgated"), "--check", "--config", self.plant.configuration],
                                 capture_output=True, text=True, check=True, timeout=PATIENCE)
        said, command = re.search("^sha256 ([0-9a-f]{64}): (cat .*)$", checked.stdout, re.MULTILINE).groups()
        self.assertIn("/moons-", command)  # a profile is a part of it
        shown = subprocess.run(["sh", "-c", command], capture_output=True, text=True, check=True, timeout=PATIENCE)
        self.assertEqual(shown.stdout, f"{said}  -\n")
        return said

    def test_the_configuration_in_force_is_known_by_its_digest(self):
        first = self.digest()
        self.assertIn(f"info: configuration in force: sha256 {first}\n", self.plant.printed())
        self.assertEqual(self.status()["configuration"]["sha256"], first)
        self.assertIn(f"\nConfiguration: sha256 {first}\n", self.mbgatectl("status", "--control", self.plant.control).stdout)
        self.edit("baud = 9600", "baud = 19200")
        second = self.digest()
        self.assertNotEqual(first, second)
        self.assertEqual(self.status()["configuration"]["sha256"], first)
        _, body = self.ask("POST", "/api/v1/reload")
        self.assertIn(f"configuration in force: sha256 {first} -> {second}", body["messages"])
        self.assertEqual(self.status()["configuration"]["sha256"], second)
        # What is refused is not in force.
        self.edit("baud = 19200", "baud = 0")
        self.assertEqual(self.ask("POST", "/api/v1/reload")[0], 422)
        self.assertEqual(self.status()["configuration"]["sha256"], second)

    def test_counters_are_cleared_and_a_drive_is_as_it_was(self):
        self.assertEqual(self.read(MOONS).returncode, 0)
        code, body = self.ask("POST", "/api/v1/clear-counters")
        self.assertEqual((code, body), (200, {"result": "done"}))
        axis = self.device("axis-x")
        self.assertEqual((axis["state"], axis["counters"]["responses"]), ("answering", 0))
        self.assertEqual(self.status()["requests"], 0)
        self.assertEqual(self.read(MOONS).returncode, 0)
        self.assertEqual(self.device("axis-x")["counters"]["responses"], 1)
        shown = self.mbgatectl("clear-counters", "--control", self.plant.control)
        self.assertEqual((shown.returncode, shown.stdout, shown.stderr), (0, "all counters are reset\n", ""))
        self.assertEqual(self.device("axis-x")["counters"]["responses"], 0)

    def test_a_refused_reload_fails_with_the_place_and_changes_nothing(self):
        self.edit("baud = 9600", "baud = 0")
        code, body = self.ask("POST", "/api/v1/reload")
        self.assertEqual((code, body["result"]), (422, "refused"))
        self.assertTrue(any(re.search(r"demo\.toml:\d+:\d+: .*baud", it) for it in body["messages"]), body)
        shown = self.mbgatectl("reload", "--control", self.plant.control)
        self.assertEqual((shown.returncode, shown.stdout), (1, ""))
        self.assertIn("the configuration stays as it is", shown.stderr)
        status = self.status()
        self.assertTrue(status["configuration"]["reload_refused"])
        self.assertEqual(status["buses"][1]["baud"], 9600)
        self.assertIn("The last reload was refused", self.mbgatectl("status", "--control", self.plant.control).stdout)

    def test_what_is_not_there_is_said(self):
        self.assertEqual(self.ask("GET", "/healthz")[0], 200)
        self.assertEqual(self.ask("GET", "/other")[0], 404)
        self.assertEqual(self.ask("POST", "/api/v1/status")[0], 405)
        self.assertEqual(self.ask("GET", "/api/v1/reload")[0], 405)
        self.assertEqual(self.ask("GET", "/api/v1/clear-counters")[0], 405)
        self.assertEqual(self.ask("POST", EVENTS)[0], 405)

    def test_the_socket_is_for_its_owner_and_group_and_goes_with_the_gateway(self):
        self.assertEqual(stat.S_IMODE(self.plant.control.stat().st_mode), 0o660)
        control = self.plant.control
        self.plant.end_gateway()
        self.assertFalse(control.exists())
        shown = self.mbgatectl("status", "--control", control)
        self.assertEqual((shown.returncode, shown.stdout), (1, ""))
        self.assertIn("there is no control socket at", shown.stderr)

    def test_a_silent_socket_is_not_waited_for(self):
        path = self.plant.control.parent / "silent"
        with socket.socket(socket.AF_UNIX) as silent:
            silent.bind(str(path))
            silent.listen()
            shown = self.mbgatectl("status", "--control", path)
        self.assertEqual((shown.returncode, shown.stdout), (1, ""))
        self.assertEqual(shown.stderr, "mbgatectl: mbgated has not answered within 5 s\n")

    def test_the_socket_of_another_process_is_left_alone(self):
        self.plant.end_gateway()
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as other:
            other.bind(str(self.plant.control))
            self.plant.start_gateway()
            self.assertTrue(self.plant.control.is_socket())
            self.assertEqual(self.read(MOONS).returncode, 0)
            self.plant.end_gateway()
            self.assertTrue(self.plant.control.is_socket())
        self.plant.start_gateway()  # what is left over is replaced
        self.assertEqual(self.ask("GET", "/healthz")[0], 200)

    def test_clients_that_say_nothing_or_nonsense_do_no_harm(self):
        for at in range(80):
            silent = socket.socket(socket.AF_UNIX)
            self.addCleanup(silent.close)
            silent.connect(str(self.plant.control))
            if at % 2:
                silent.close()
        nonsense = socket.socket(socket.AF_UNIX)
        self.addCleanup(nonsense.close)
        nonsense.connect(str(self.plant.control))
        nonsense.sendall(b"\x00\x01\x00\x00\x00\x06 no HTTP at all\r\n\r\n" * 1000)
        nonsense.close()
        self.assertEqual(self.read(MOONS).returncode, 0)
        self.assertEqual(self.ask("GET", "/healthz")[0], 200)


if __name__ == "__main__":
    sys.exit(unittest.main())
