#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Staged troubles: what `mbgatectl status` names first, of real programs on ptys. The simulator plays what it can; the
rest is played by a line of the test's own."""

import itertools
import pathlib
import re
import signal
import socket
import sys
import tempfile
import threading
import time
import unittest

from control_case import ControlCase
from demo_plant import CONFIGURATION, PATIENCE, Process
from scripted_line import ScriptedLine, answer_to, framed

NO_ANSWER_YET = {("device axis", "it has never answered"), ("device lift", "it has never answered")}
NONE_ANY_MORE = ("device axis", "it does not answer any more")
DEAD_LINE = ("bus line-a", "nothing answers")
FULL_LINE = ("bus line-a", "it is asked for more than it can carry")
# Where a busy machine must not be taken for a drive that is too slow.
PATIENT = 'response_timeout = "2s"'
# The same where each damaged answer costs that time.
LESS_PATIENT = 'response_timeout = "1s"'
FOREIGN_FRAMES = ("bus line-a", "frames are heard that the gateway neither sent nor asked for")
BAD_CRC = r"bad CRC in \d+ % of its answers"


def simulated(bus="", **drives):
    """The simulator's configuration: one line, and drives with these keys at the addresses 1, 2, ..."""
    text = f'[[bus]]\nname = "line-a"\nlink = "line-a"\nparity = "none"\n{bus}\n'
    for address, (name, keys) in enumerate(drives.items(), 1):
        text += f'[[device]]\nname = "{name}"\nbus = "line-a"\naddress = {address}\nmodel = "moons"\n{keys}\n'
    return text


def request(unit, pdu, transaction=1):
    return transaction.to_bytes(2, "big") + bytes(2) + (len(pdu) + 1).to_bytes(2, "big") + bytes([unit]) + pdu


def read_of(register, count=1):
    return b"\x03" + register.to_bytes(2, "big") + count.to_bytes(2, "big")


class Poller:
    """A client that keeps so many requests outstanding until it is ended. Whatever the answers are, they are none of
    its business."""

    def __init__(self, port, requests, outstanding=1, pause=0.0, address="127.0.0.1"):
        self._requests = itertools.cycle(requests)
        self._outstanding = outstanding
        self._pause = pause
        self._socket = socket.create_connection(("127.0.0.1", port), PATIENCE, (address, 0))
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._poll)
        self._thread.start()

    def _poll(self):
        try:
            for _ in range(self._outstanding):
                self._socket.sendall(next(self._requests))
            heard = b""
            while not self._ended.is_set():
                heard += self._socket.recv(4096)
                while len(heard) >= 6 and len(heard) >= 6 + int.from_bytes(heard[4:6], "big"):
                    heard = heard[6 + int.from_bytes(heard[4:6], "big") :]
                    self._ended.wait(self._pause)
                    self._socket.sendall(next(self._requests))
        except OSError:
            pass  # it was ended, or the gateway was

    def end(self):
        self._ended.set()
        try:
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self._thread.join()
        self._socket.close()


class Gateway:
    """mbgated with one line and one or two devices on it, and what is on the line."""

    def __init__(self, case, device="./line-a", bus="", axis="", route="", units=1, listen=""):
        self.folder = pathlib.Path(case.enterContext(tempfile.TemporaryDirectory()))
        self.control = self.folder / "control"
        text = f'[gateway]\nprofiles = "{CONFIGURATION / "profiles"}"\n[http]\nsocket = "{self.control}"\n'
        text += f'[[listen]]\nname = "plant"\naddress = "127.0.0.1"\nport = 0\n{listen}\n'
        text += f'[[bus]]\nname = "line-a"\ndevice = "{device}"\n'
        text += "".join(f"{key}\n" for key in self._with_defaults(bus))
        for address, name in enumerate(["axis", "lift"][:units], 1):
            text += f'[[device]]\nname = "{name}"\nbus = "line-a"\naddress = {address}\n{axis}\n'
            text += f'[[route]]\nunit = {address}\ndevice = "{name}"\n{route}\n'
        self.configuration = self.folder / "mbgate.toml"
        self.configuration.write_text(text, encoding="utf-8")
        self._case = case

    @staticmethod
    def _with_defaults(bus):
        defaults = {"baud": "115200", "parity": '"none"', "response_timeout": '"200ms"', "listen_first": '"0ms"'}
        given = dict(line.split(" = ", 1) for line in bus.splitlines())
        return [f"{key} = {value}" for key, value in {**defaults, **given}.items()]

    def simulate(self, configuration):
        (self.folder / "sim.toml").write_text(configuration, encoding="utf-8")
        drives = Process(self.folder, "mbgate-sim", "sim.toml")
        self._case.addCleanup(drives.end)
        drives.wait_for("^ready")
        return drives

    def start(self):
        self.process = Process(self.folder, "mbgated", "--config", self.configuration)
        self._case.addCleanup(self.process.end)
        self.port = int(self.process.wait_for(r"listening plant 127\.0\.0\.1:(\d+)$").group(1))
        return self

    def poll(self, *units, **keys):
        for unit in units:
            self.add(Poller(self.port, [request(unit, read_of(0x3C))], **{"pause": 0.02, **keys}))

    def add(self, poller):
        self._case.addCleanup(poller.end)


class Diagnosis(ControlCase):
    def setUp(self):
        pass  # each test has a plant of its own

    def gateway(self, simulator=None, **keys):
        self.plant = Gateway(self, **keys)
        if simulator is not None:
            self.drives = self.plant.simulate(simulator)
        return self.plant.start()

    def on_line(self, on_request, **keys):
        line = self.enterContext(ScriptedLine(on_request))
        return self.gateway(device=line.path, **keys), line

    def wait_for(self, subject, finding, look_at="", before=()):
        """The first diagnosis, once it is this one; until then there is none, or one of those that may come before it, or
        that requests fail and nothing explains it yet. `finding` and `look_at` are patterns. mbgatectl shows
        the same first, as text and as JSON."""
        end = time.monotonic() + PATIENCE
        while True:
            first = next(iter(self.status()["diagnoses"]), None)
            if first and first["subject"] == subject and re.fullmatch(finding, first["finding"]):
                break
            if first and first["subject"] != "listener plant":
                self.assertIn((first["subject"], first["finding"]), before)
            self.assertLess(time.monotonic(), end, f"{subject}: {finding} is not named, but {first}")
            time.sleep(0.05)
        self.assertRegex(first["look_at"], look_at)
        because = rf"{re.escape(subject)}: {finding}\n      because: .+\n      look at: .*{look_at}"
        self.wait_until_printed(f"FAULTS\n  {because}", end)
        self.wait_until_printed(rf'"diagnoses": ?\[\s*{{[^}}]*"subject": ?"{re.escape(subject)}"', end, "--json")
        return first

    def wait_until_printed(self, pattern, end, *options):
        """What is near a limit comes and goes, on a machine that is busy with other things."""
        while True:
            printed = self.mbgatectl("status", *options, "--control", self.plant.control)
            self.assertEqual(printed.returncode, 0, printed.stderr)
            if re.search(pattern, printed.stdout) or time.monotonic() > end:
                break
            time.sleep(0.05)
        self.assertRegex(printed.stdout, pattern)

    def test_a_dead_drive(self):
        self.gateway(simulated(axis="faults = { silent = true }", lift=""), units=2).poll(1, 2)
        found = self.wait_for("device axis", "it has never answered", "its power; its address 1")
        self.assertIn("others on line-a answer", found["evidence"])

    def test_a_drive_that_dies(self):
        alive = threading.Event()
        alive.set()
        gateway, _ = self.on_line(lambda line, asked: alive.is_set() and line.say(answer_to(asked)))
        gateway.poll(1)
        self.wait_until_answered()
        alive.clear()
        self.wait_for("device axis", "it does not answer any more", "its power, its cable")

    def wait_until_answered(self):
        end = time.monotonic() + PATIENCE
        while self.device("axis")["counters"]["responses"] == 0:
            self.assertLess(time.monotonic(), end, "no answer")
            time.sleep(0.02)

    # Drives do not hear what comes at another rate, with another parity or on exchanged wires: which, nobody can know.
    def test_a_wrong_baud_rate(self):
        self.gateway(simulated(axis="", lift=""), bus="baud = 19200", units=2).poll(1, 2)
        all_alike = "A and B; .* the drives' setting, here 19200 baud 8N1"
        self.wait_for("bus line-a", "nothing answers", all_alike, NO_ANSWER_YET)

    def test_bytes_that_are_no_frame(self):
        rubbish = bytes.fromhex("E618869E06")
        gateway, _ = self.on_line(lambda line, _: line.say(rubbish), bus="retries = 0\noffline_after = 0")
        gateway.poll(1)
        all_alike = "baud rate, parity, A and B exchanged"
        self.wait_for("device axis", "something answers, but no valid frame", all_alike, {DEAD_LINE})

    def test_bad_crcs_of_a_drive(self):
        faults = "faults = { bad_crc = true }"
        self.gateway(simulated(axis=faults, lift=""), bus=LESS_PATIENT, units=2).poll(1, 2)
        self.wait_for("device axis", BAD_CRC, "termination, bias, cable, or two devices at one address")

    def test_bad_crcs_of_a_line(self):
        faults = "faults = { bad_crc = true }"
        self.gateway(simulated(axis=faults, lift=faults), bus=LESS_PATIENT, units=2).poll(1, 2)
        either = {(f"device {name}", "bad CRC in 100 % of its answers") for name in ("axis", "lift")}
        self.wait_for("bus line-a", BAD_CRC, "termination, bias, cable; several devices", either)

    def test_two_devices_at_one_address_that_answer_at_once(self):
        def answer(line, asked):
            one, other = answer_to(asked, 0x1234), answer_to(asked, 0x4321)
            line.say(bytes(a & b for a, b in zip(one, other)))

        gateway, _ = self.on_line(answer, bus=LESS_PATIENT)
        gateway.poll(1)
        self.wait_for("device axis", BAD_CRC, "two devices at one address")

    def test_two_devices_at_one_address_that_answer_in_turn(self):
        def answer(line, asked):
            line.say(answer_to(asked))
            line.ended.wait(0.05)
            line.say(answer_to(asked, 0x4321))

        gateway, _ = self.on_line(answer, bus=f'{PATIENT}\nquarantine_max = "2s"')
        gateway.poll(1, pause=0.5)
        two_answers = "two answers came to one request"
        self.wait_for("device axis", two_answers, "two devices at address 1", {FOREIGN_FRAMES})

    def test_a_wrong_word_order(self):
        device = 'profile = "moons-m2"\nword_order = "little"\nverify_word_order = true'
        drive = simulated(axis='series = "m2"\nword_order = "big"')
        gateway = self.gateway(drive, axis=device, route='word_order = "big"')
        write = bytes.fromhex("10 001E 0002 04 0001 0002")
        gateway.add(Poller(gateway.port, [request(1, write)], pause=0.05))
        found = self.wait_for("device axis", "its word order is not the configured one", "`word_order`")
        self.assertIn("held 5 when it was last read; the configured word order has 133 or 389", found["evidence"])

    def test_a_drive_that_is_slower_than_its_timeout(self):
        self.gateway(simulated(axis='faults = { answer_after = "500ms" }')).poll(1)
        late = r"its answers come \d+ ms after its response timeout"
        remedy = r"set response_timeout to at least \d+ ms"
        found = self.wait_for("device axis", late, remedy, {NONE_ANY_MORE, DEAD_LINE})
        self.assertGreater(int(re.search(r"least (\d+)", found["look_at"]).group(1)), 500)

    def test_a_second_client_on_the_line(self):
        gateway, line = self.on_line(lambda line, asked: line.say(answer_to(asked)), bus='quarantine_max = "500ms"')
        gateway.poll(1, pause=0.3)
        self.wait_until_answered()
        other = threading.Thread(target=self.be_another_client, args=(line,))
        other.start()
        self.addCleanup(other.join)
        self.addCleanup(line.ended.set)
        self.wait_for("bus line-a", "requests of another client are heard", "another client", {FOREIGN_FRAMES})

    @staticmethod
    def be_another_client(line):
        asked = framed(bytes.fromhex("090300000001"))
        while not line.ended.wait(0.11):
            line.say(asked)
            line.ended.wait(0.02)
            line.say(answer_to(asked))

    def test_a_line_that_hears_itself(self):
        self.gateway(simulated("echo = true", axis="")).poll(1)
        self.wait_for("bus line-a", "the adapter receives what it sends, and `echo` does not say so", "set `echo = true`")

    def test_a_line_that_hears_itself_and_must_not(self):
        self.gateway(simulated("echo = true", axis=""), bus="echo = false").poll(1)
        self.wait_for("bus line-a", "the adapter receives what it sends, but `echo = false` is set", "set `echo = true`")

    def test_a_line_that_is_never_silent(self):
        _, line = self.on_line(lambda *_: None, bus='frame_gap = "500ms"')
        babble = threading.Thread(target=self.babble, args=(line,))
        babble.start()
        self.addCleanup(babble.join)
        self.addCleanup(line.ended.set)
        self.wait_for("bus line-a", "it is never silent: nothing can be sent", "another client on this line, baud rate")

    @staticmethod
    def babble(line):
        while not line.ended.wait(0.02):
            line.say(b"U")

    # 9600 baud carry some 25 of these reads in a second.
    def test_an_overloaded_line(self):
        gateway = self.gateway(simulated("baud = 9600", axis="", lift=""), bus="baud = 9600", units=2)
        for at in range(40):
            gateway.add(Poller(gateway.port, [request(1 + at % 2, read_of(0x3C + at, 4))]))
        self.wait_for("bus line-a", "it is asked for more than it can carry", "poll less often")

    def test_a_client_that_floods(self):
        gateway = self.gateway(simulated("baud = 9600", axis="", lift=""), bus="baud = 9600", units=2)
        gateway.poll(2, address="127.0.0.3")
        for at in range(4):
            reads = [request(1, read_of(0x3C + 10 * at + register)) for register in range(10)]
            gateway.add(Poller(gateway.port, reads, outstanding=16, address="127.0.0.2"))
        too_much = "it asks for more than bus line-a can carry"
        self.wait_for("client 127.0.0.2", too_much, "how often it asks", {FULL_LINE})

    def test_an_adapter_that_is_unplugged(self):
        self.gateway('reopen_after = "1h"\n' + simulated(axis="")).poll(1)
        self.wait_until_answered()
        self.drives.signal(signal.SIGUSR2)
        self.wait_for("bus line-a", "it is not open: nothing can be sent", "the adapter and its plug")

    def test_an_adapter_that_is_not_there(self):
        self.gateway().poll(1)
        self.wait_for("bus line-a", "it is not open: nothing can be sent", "the adapter and its plug")

    def test_nothing_where_all_is_well(self):
        gateway = self.gateway(simulated(axis="", lift=""), bus=PATIENT, units=2)
        gateway.poll(1, 2)
        self.wait_until_answered()
        end = time.monotonic() + 3
        while time.monotonic() < end:
            self.assertEqual(self.status()["diagnoses"], [])
            time.sleep(0.1)


if __name__ == "__main__":
    sys.exit(unittest.main())
