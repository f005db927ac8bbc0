#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What mbgated sends to systemd's journal. The journal's socket has a fixed path, so that the test runs in a mount
namespace of its own, with a socket of its own there."""

import os
import pathlib
import queue
import re
import select
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest

from demo_plant import PATIENCE, program
from scripted_line import ScriptedLine, answer_to

SOCKET = pathlib.Path("/run/systemd/journal/socket")
SOURCE = pathlib.Path(__file__).parents[2]
INSIDE = "MBGATE_JOURNAL_TEST"
IDS = dict(re.findall(r'(k\w+)\{"(\w{32})"\}', (SOURCE / "src/app/journal/message_id.hpp").read_text(encoding="utf-8")))
CONFIGURATION = """
[http]
socket = ""
[[listen]]
name = "plant"
address = "127.0.0.1"
port = 0
bus = "axes"
[[bus]]
name = "axes"
device = "{path}"
baud = 115200
parity = "none"
listen_first = "10ms"
response_timeout = "{timeout}"
[[device]]
name = "axis-x"
bus = "axes"
address = 1
"""


def parsed(datagram):
    """An entry of the journal's native protocol."""
    fields = {}
    while datagram:
        line, _, datagram = datagram.partition(b"\n")
        name, is_short, value = line.partition(b"=")
        if not is_short:
            size = int.from_bytes(datagram[:8], "little")
            value, datagram = datagram[8 : 8 + size], datagram[8 + size + 1 :]
        fields[name.decode()] = value.decode()
    return fields


def ask(port, unit, pdu):
    """The PDU of the answer."""
    with socket.create_connection(("127.0.0.1", port), PATIENCE) as connection:
        connection.sendall(bytes([0, 1, 0, 0, 0, len(pdu) + 1, unit]) + pdu)
        head = connection.recv(7, socket.MSG_WAITALL)
        return connection.recv(int.from_bytes(head[4:6], "big") - 1, socket.MSG_WAITALL)


class JournalTest(unittest.TestCase):
    def setUp(self):
        self.is_mute = False
        self.line = self.enterContext(ScriptedLine(self.answer))
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.configuration = self.folder / "mbgate.toml"
        self.configure("500ms")

    def configure(self, timeout):
        text = CONFIGURATION.format(path=self.line.path, timeout=timeout)
        self.configuration.write_text(text, encoding="utf-8")

    def answer(self, line, request):
        if not self.is_mute:
            line.say(answer_to(request))

    def bind(self):
        SOCKET.parent.mkdir(parents=True, exist_ok=True)
        journal = self.enterContext(socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM))
        journal.bind(str(SOCKET))
        journal.settimeout(PATIENCE)
        self.addCleanup(SOCKET.unlink)
        return journal

    def start(self):
        """mbgated, whose standard error is said to be the journal; it is a pipe that a thread reads."""
        ours, theirs = os.pipe()
        status = os.fstat(theirs)
        self.daemon = subprocess.Popen(
            [program("mbgated"), "--config", self.configuration],
            stderr=theirs,
            env={**os.environ, "JOURNAL_STREAM": f"{status.st_dev}:{status.st_ino}"},
        )
        os.close(theirs)
        self.addCleanup(self.daemon.wait)
        self.addCleanup(self.daemon.kill)
        self.lines = queue.Queue()
        self.reader = threading.Thread(target=self.read_lines, args=[open(ours, encoding="utf-8")])
        self.reader.start()

    def read_lines(self, pipe):
        with pipe:
            for line in pipe:
                self.lines.put(line.removesuffix("\n"))

    def end(self):
        """The exit status, and what was written to standard error since the last line that was taken from there."""
        self.daemon.terminate()
        status = self.daemon.wait(PATIENCE)
        self.reader.join()
        return status, list(self.lines.queue)

    def find(self, journal, kind):
        """The next entry of this kind."""
        while True:
            entry = parsed(journal.recv(65536))
            if entry.get("MESSAGE_ID") == IDS[kind]:
                return entry

    def find_port(self, journal):
        return int(self.find(journal, "kListening")["MESSAGE"].rpartition(":")[2])

    def entry(self, kind, priority, message, **fields):
        described = {f"MBGATE_{name.upper()}": value for name, value in fields.items()}
        syslog = {"PRIORITY": priority, "SYSLOG_IDENTIFIER": "mbgated", "SYSLOG_FACILITY": "3"}
        return {"MESSAGE": message, **syslog, "MESSAGE_ID": IDS[kind], **described}

    def test_an_entry_says_what_it_is_about(self):
        journal = self.bind()
        self.start()
        listening = self.find(journal, "kListening")
        port = int(listening["MESSAGE"].rpartition(":")[2])
        message = f"listening plant 127.0.0.1:{port}"
        self.assertEqual(listening, self.entry("kListening", "6", message, listener="plant"))
        opened = self.find(journal, "kBusOpened")
        self.assertEqual(opened, self.entry("kBusOpened", "5", "bus axes is open", bus="axes"))
        for _ in range(100):
            if ask(port, 1, bytes([3, 0, 0, 0, 1])) == bytes([3, 2, 0x12, 0x34]):
                break
        self.is_mute = True
        for _ in range(3):
            self.assertIn(ask(port, 1, bytes([3, 0, 0, 0, 1])), [b"\x83\x0b", b"\x83\x06"])
        lost = self.find(journal, "kDeviceLost")
        message = "device axis-x: does not answer any more"
        self.assertEqual(lost, self.entry("kDeviceLost", "4", message, bus="axes", device="axis-x", address="1"))
        self.assertEqual(self.end(), (0, []))
        stopping = self.find(journal, "kStopping")
        self.assertEqual(stopping, self.entry("kStopping", "6", "stopping"))

    def test_without_a_journal_there_are_lines_with_their_priority(self):
        self.start()
        self.assertRegex(self.lines.get(timeout=PATIENCE), "^<6>configuration in force: sha256 [0-9a-f]{64}$")
        self.assertRegex(self.lines.get(timeout=PATIENCE), r"^listening plant 127\.0\.0\.1:\d+$")
        self.assertEqual(self.lines.get(timeout=PATIENCE), "<5>bus axes is open")
        self.assertEqual(self.end(), (0, ["<6>stopping"]))

    def test_a_wrong_configuration_has_an_entry_too(self):
        journal = self.bind()
        self.configuration.write_text("nonsense = 1\n", encoding="utf-8")
        self.start()
        self.assertEqual(self.daemon.wait(PATIENCE), 78)
        message = "the configuration is wrong: mbgated does not start"
        self.assertEqual(parsed(journal.recv(65536)), self.entry("kStartRefused", "3", message))
        self.reader.join()
        self.assertIn("nonsense", "\n".join(self.lines.queue))

    def test_a_journal_that_blocks_stops_neither_a_bus_nor_the_end(self):
        held = int(pathlib.Path("/proc/sys/net/unix/max_dgram_qlen").read_text(encoding="ascii"))
        devices = held + 20  # one line each
        self.configure("20s")  # longer than any machine is busy
        journal = self.bind()
        self.start()
        port = self.find_port(journal)
        more = ""
        for number in range(devices):
            if number % 200 == 0:
                more += f'[[bus]]\nname = "far-{number}"\nmode = "tcp"\nhost = "127.0.0.1"\nport = {number // 200 + 1}\n'
                bus = f"far-{number}"
            more += f'[[device]]\nname = "d{number}"\nbus = "{bus}"\naddress = {number % 200 + 1}\n'
        with self.configuration.open("a", encoding="utf-8") as file:
            file.write(more)
        self.daemon.send_signal(signal.SIGHUP)
        count_devices = bytes([4, 0, 2, 0, 1])
        while ask(port, 255, count_devices) != bytes([4, 2]) + (devices + 1).to_bytes(2, "big"):
            self.assertIsNone(self.daemon.poll())
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as another:
            another.connect(str(SOCKET))
            limit = time.monotonic() + PATIENCE
            while select.select([], [another], [], 0)[1]:
                self.assertLess(time.monotonic(), limit, "the journal takes everything: this shows nothing")
                time.sleep(0.01)
        for _ in range(5):
            self.assertEqual(ask(port, 1, bytes([3, 0, 0, 0, 1])), bytes([3, 2, 0x12, 0x34]))
        self.assertEqual(self.end(), (0, []))


def main():
    if os.environ.get(INSIDE):
        subprocess.run(["mount", "-t", "tmpfs", "tmpfs", "/run"], check=True)
        unittest.main()
    unshare = ["unshare", "--mount", "--propagation", "private"] + (["--map-root-user"] if os.geteuid() else [])
    probe = [*unshare, "mount", "-t", "tmpfs", "tmpfs", "/run"]
    if not shutil.which("unshare"):
        print("skipped: unshare (util-linux) is not there")
        return 77
    tried = subprocess.run(probe, capture_output=True, text=True, check=False)
    if tried.returncode:
        print(f"skipped: no mount namespace can be made here: {tried.stderr.strip()}")
        return 77
    command = [*unshare, sys.executable, *sys.argv]
    return subprocess.run(command, env={**os.environ, INSIDE: "yes"}, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
