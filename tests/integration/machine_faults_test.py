#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What the machine runs short of: room on a disk, descriptors, memory, processor time, a reader of the journal. The bus
goes on, no answer is wrong, and the journal says it once. `--requests 50000`: so many questions to the control socket,
instead of some."""

import contextlib
import fcntl
import os
import pathlib
import re
import resource
import select
import signal
import subprocess
import sys
import time
import unittest

from control_case import UnixConnection
from demo_plant import PATIENCE, Process
from fault_plant import BUSY, NO_ANSWER, Client, FaultCase, exception, is_sanitized, write_of

STATUS = "/api/v1/status"
RELOAD = "/api/v1/reload"
ARGUMENTS = dict(zip(sys.argv[1::2], sys.argv[2::2], strict=False))
REQUESTS = int(ARGUMENTS.get("--requests", 3000))
MEMORY_LEFT = 8_388_608  # what must be left, that a client is let in
MEMORY_FOR_CLIENTS = 600_000
LOAD = 20  # busy processes
BUSY_LOOP = "import time\nend = time.monotonic() + 20\nwhile time.monotonic() < end: pass"
ONE = b"\x03\x00\x1e\x00\x01"  # a read of one register
READ_ONLY = 'mount --bind "$0" "$0" && mount -o remount,bind,ro "$0" && exec "$@"'


def limit_to(what, size):
    return lambda: resource.setrlimit(what, (size, size))


def address_space(pid):
    """Bytes."""
    return int(pathlib.Path(f"/proc/{pid}/statm").read_text(encoding="ascii").split()[0]) * resource.getpagesize()


def resident(pid):
    """Bytes."""
    return int(pathlib.Path(f"/proc/{pid}/statm").read_text(encoding="ascii").split()[1]) * resource.getpagesize()


def with_read_only(folder):
    """A command before another one, for which the folder is read-only. Nothing: it cannot be had here."""
    for user in ([], ["--map-root-user"]):
        command = ["unshare", *user, "--mount", "sh", "-c", READ_ONLY, str(folder)]
        if subprocess.run([*command, "true"], stderr=subprocess.DEVNULL, check=False).returncode == 0:
            return command
    return None


class MachineFaults(FaultCase):
    filled = 0  # keys that no configuration knows

    def test_a_full_disk_ends_the_recording_and_nothing_else(self):
        self.line()
        full = "it cannot be written: No space left on device"
        self.start("--record", "/dev/full")
        reader = self.reader()
        self.gateway.wait_for(f"^warning: the recording has ended: {full}$")
        self.assert_serves(reader, self.client())
        self.assertEqual(len(self.lines("the recording has ended")), 1)
        self.assertEqual(self.gateway.end(), 0)

    def test_a_recording_ends_where_files_may_not_be_larger(self):
        self.line()
        self.start("--record", self.folder / "plant.rec", prepare=limit_to(resource.RLIMIT_FSIZE, 40_000))
        reader = self.reader()
        self.gateway.wait_for("^warning: the recording has ended: it cannot be written: File too large$")
        self.assert_serves(reader, self.client())
        self.assertEqual(len(self.lines("the recording has ended")), 1)

    def test_a_journal_that_is_a_full_file_ends_nothing(self):
        self.line()
        path = self.folder / "journal"
        with path.open("wb") as journal:
            self.start_into(journal.fileno(), path, prepare=limit_to(resource.RLIMIT_FSIZE, 4096))
        reader = self.reader()
        self.fill_journal(200)
        self.wait_until(lambda: path.stat().st_size == 4096)  # a thread writes the journal
        self.assert_serves(reader, self.client())
        self.assertEqual(self.gateway.end(), 0)

    def start_into(self, descriptor, path, **how):
        """The gateway with its lines in a file."""
        arguments = ("--config", self.configuration)
        self.gateway = Process(self.folder, "mbgated", *arguments, output=descriptor, **how)
        self.addCleanup(self.gateway.end)
        limit = time.monotonic() + PATIENCE
        while not (found := re.search(r"listening plant .*:(\d+)\n", path.read_text(encoding="utf-8"))):
            self.assertLess(time.monotonic(), limit, "it does not listen")
            time.sleep(0.02)
        self.port = int(found.group(1))

    def fill_journal(self, lines):
        """A reload that is refused for so many reasons, each a line that the journal has not seen yet."""
        text = self.configuration.read_text(encoding="utf-8")
        unknown = (f"unknown_{self.filled + number} = 1\n" for number in range(lines))
        self.filled += lines
        self.configuration.write_text("[gateway]\n" + "".join(unknown) + text.replace("[gateway]\n", ""), encoding="utf-8")
        connection = UnixConnection(self.control)
        self.addCleanup(connection.close)
        status, body = self.ask("POST", RELOAD, connection)
        self.assertEqual((status, len(body["messages"]) >= lines), (422, True), body)
        self.configuration.write_text(text, encoding="utf-8")

    def test_a_read_only_place_is_told(self):
        place = self.folder / "read-only"
        place.mkdir()
        within = with_read_only(place)
        if within is None:
            self.skipTest("no mount namespace of our own")
        self.line()
        sound = self.configuration.read_text(encoding="utf-8")
        elsewhere = sound.replace(str(self.control), f"{place}/control")
        self.assertNotEqual(elsewhere, sound)
        self.configuration.write_text(elsewhere, encoding="utf-8")
        serving = Process(self.folder, "mbgated", "--config", self.configuration, wrapped=within)
        self.addCleanup(serving.end)
        serving.wait_for(f"^warning: control socket {place}/control: Read-only file system; .*ReadWritePaths=")
        serving.wait_for("^listening plant ")
        self.assertEqual(serving.end(), 0)
        self.configuration.write_text(sound, encoding="utf-8")
        # A recording was asked for by whoever starts it: it is told at once.
        recording = ("--config", self.configuration, "--record", place / "plant.rec")
        refused = Process(self.folder, "mbgated", *recording, wrapped=within)
        self.addCleanup(refused.end)
        refused.wait_for(f"^mbgated: cannot create the recording {place}/plant.rec: Read-only file system; ")
        self.assertEqual(refused.wait(), 73)

    def test_without_descriptors_those_who_are_served_are_served(self):
        (self.folder / "sim.toml").write_text(
            '[[bus]]\nname = "line-a"\nlink = "line-a"\nparity = "none"\nbaud = 115200\npaced = false\n'
            '[[device]]\nname = "drive"\nbus = "line-a"\naddress = 1\nmodel = "moons"\n',
            encoding="utf-8",
        )
        drives = Process(self.folder, "mbgate-sim", "sim.toml")
        self.addCleanup(drives.end)
        drives.wait_for("^ready")
        self.configure("./line-a")
        self.start(prepare=limit_to(resource.RLIMIT_NOFILE, 100))
        client = self.client()
        self.assertEqual(client.ask(ONE)[0], 3)
        crowd = [Client(self.port) for _ in range(120)]
        self.gateway.wait_for("^error: listener plant: cannot accept clients: Too many open files")
        self.assertEqual(self.ask("GET", STATUS)[0], 200)
        drives.signal(signal.SIGUSR2)  # the adapter goes, and comes back
        self.gateway.wait_for("bus line-a is lost")
        self.gateway.wait_for("bus line-a is open")
        self.wait_until(lambda: client.ask(ONE)[0] == 3)
        self.assertLessEqual(len(self.lines("cannot accept clients")), 10)  # of a kind in a minute
        for one in crowd:
            one.close()
        self.wait_until(self.is_served)

    def wait_until(self, happens):
        limit = time.monotonic() + PATIENCE
        while not happens():
            self.assertLess(time.monotonic(), limit)
            time.sleep(0.005)

    def is_served(self):
        """Is a client that comes now let in, and answered?"""
        try:
            with contextlib.closing(Client(self.port)) as client:
                return client.ask(ONE)[:1] == b"\x03"
        except OSError:
            return False

    def test_without_memory_new_clients_are_refused_and_the_others_served(self):
        if is_sanitized():
            self.skipTest("AddressSanitizer reserves more addresses than any limit leaves")
        files = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
        resource.setrlimit(resource.RLIMIT_NOFILE, (files, files))  # of the clients
        self.line()
        # Another heap of a thread would have addresses for more than all this takes.
        self.start(prepare=lambda: os.environ.update(MALLOC_ARENA_MAX="1"))
        reader = self.reader()
        client = self.client()
        self.assertEqual(self.ask("GET", STATUS)[0], 200)
        before = resource.prlimit(self.gateway.pid, resource.RLIMIT_AS)
        crowd = []
        self.addCleanup(lambda: [one.close() for one in crowd])
        self.wait_until(lambda: self.is_crowded(crowd) and not self.is_served())
        self.assert_serves(reader, client)
        self.assertLessEqual(len(self.lines("cannot accept clients")), 10)  # of a kind in a minute
        resource.prlimit(self.gateway.pid, resource.RLIMIT_AS, before)
        self.wait_until(self.is_served)
        self.assertEqual(self.ask("GET", STATUS)[0], 200)
        self.assert_serves(reader, client)
        self.assertEqual(self.gateway.end(), 0)

    def is_crowded(self, crowd):
        """Is one more client told that there is no memory? What the gateway gives back it does not get again."""
        least = resource.prlimit(self.gateway.pid, resource.RLIMIT_AS)
        room = address_space(self.gateway.pid) + MEMORY_LEFT + MEMORY_FOR_CLIENTS
        if least[0] == resource.RLIM_INFINITY or room < least[0]:
            resource.prlimit(self.gateway.pid, resource.RLIMIT_AS, (room, least[1]))
        with contextlib.suppress(ConnectionResetError):  # it was sent away before it saw it
            crowd.append(Client(self.port))
        return bool(self.lines("cannot accept clients: Cannot allocate memory"))

    def test_under_load_no_answer_is_wrong_and_no_write_is_late(self):
        line = self.line()
        self.start()
        reader = self.reader()
        client = self.client()
        busy = [subprocess.Popen(["nice", "-n", "19", sys.executable, "-c", BUSY_LOOP]) for _ in range(LOAD)]
        refused, done, unknown = [], [], []  # 0B, where the drive's answer was late: a write may have been done
        try:
            end = time.monotonic() + 4
            while time.monotonic() < end:
                value = 1000 + len(refused) + len(done) + len(unknown)
                answer = client.write(value)
                kinds = {write_of(value): done, exception(6, BUSY): refused, exception(6, NO_ANSWER): unknown}
                self.assertIn(answer, kinds)
                kinds[answer].append(value)
            reader.wait_for_answers()
        finally:
            for process in busy:
                process.kill()
                process.wait()
        self.assertEqual(reader.wrong, [])
        self.assertEqual(line.writes, sorted(set(line.writes)))  # each once, in order,
        self.assertEqual([value for value in line.writes if value not in unknown], done)  # and none that was refused
        self.assertGreater(len(done), 0)

    def test_many_questions_cost_no_memory_and_no_answer(self):
        self.line()
        self.start(prepare=lambda: os.environ.setdefault("ASAN_OPTIONS", "quarantine_size_mb=1"))
        reader = self.reader()
        connection = UnixConnection(self.control)
        self.addCleanup(connection.close)
        before = 0
        for count in range(REQUESTS):
            self.assertEqual(self.ask("GET", STATUS, connection)[0], 200)
            if count == REQUESTS // 4:
                before = resident(self.gateway.pid)
        if not is_sanitized():
            self.assertLess(resident(self.gateway.pid), before + 16_000_000)
        self.assert_serves(reader, self.client())

    def test_a_journal_that_nobody_reads_delays_nothing(self):
        self.line()
        theirs, ours = self.pipe()
        reading = os.fdopen(theirs, "rb", buffering=0)
        self.addCleanup(reading.close)
        self.gateway = Process(self.folder, "mbgated", "--config", self.configuration, output=ours)
        self.addCleanup(self.gateway.end)
        os.close(ours)
        found = self.read_journal(reading, rb"listening plant .*:(\d+)\n")
        self.port = int(found.group(1))
        reader = self.reader()
        self.fill_journal(1400)  # more than the pipe takes, and the lines that wait for it
        self.assert_serves(reader, self.client())
        # Whoever reads it again hears how many are missing.
        missing = self.read_journal(reading, rb"(\d+) lines are missing here: standard error did not accept them fast enough\n")
        self.assertGreater(int(missing.group(1)), 0)
        self.fill_journal(1400)
        began = time.monotonic()
        self.assertEqual(self.gateway.end(), 0)
        self.assertLess(time.monotonic() - began, PATIENCE / 2)

    def pipe(self):
        theirs, ours = os.pipe()
        fcntl.fcntl(ours, fcntl.F_SETPIPE_SZ, resource.getpagesize())
        return theirs, ours

    def read_journal(self, reading, pattern):
        """Reads until the pattern is there; now and then something is written that may tell of it."""
        text = b""
        limit = time.monotonic() + PATIENCE
        while not (found := re.search(pattern, text)):
            self.assertLess(time.monotonic(), limit, text[-2000:])
            if select.select([reading], [], [], 0.2)[0]:
                text += os.read(reading.fileno(), 65536)
            elif self.control.exists():
                self.fill_journal(1)
        return found


if __name__ == "__main__":
    sys.exit(unittest.main(argv=sys.argv[:1]))
