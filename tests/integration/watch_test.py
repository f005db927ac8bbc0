#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""mbgatectl status --watch on the demo's gateway: on a terminal of its own, and into a pipe."""

import fcntl
import json
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import termios
import time
import unittest

from demo_plant import PATIENCE, DemoPlant, program


class OnTerminal:
    """A watch that thinks that it has a terminal: what it writes there, as it comes."""

    def __init__(self, control, rows=24, columns=80, terminal="xterm"):
        self._ours, theirs = pty.openpty()
        self.before = termios.tcgetattr(theirs)
        self._theirs = theirs
        self.resize(rows, columns)
        self.process = subprocess.Popen(
            [program("mbgatectl"), "status", "--watch", "--every", "100ms", "--control", str(control)],
            stdin=theirs,
            stdout=theirs,
            stderr=theirs,
            env={**os.environ, "TERM": terminal, "LC_ALL": "C.UTF-8"},
            preexec_fn=self._take_terminal,
            start_new_session=True,
        )
        self.written = ""

    @staticmethod
    def _take_terminal():
        fcntl.ioctl(0, termios.TIOCSCTTY, 0)

    def resize(self, rows, columns):
        fcntl.ioctl(self._ours, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))

    def type(self, keys):
        os.write(self._ours, keys)

    def wait_for(self, pattern):
        """Returns when `pattern` is in what was written since the last call."""
        end = time.monotonic() + PATIENCE
        while not re.search(pattern, self.written):
            ready, _, _ = select.select([self._ours], [], [], max(0, end - time.monotonic()))
            if not ready:
                raise AssertionError(f"no {pattern!r} in {self.written!r}")
            self.written += os.read(self._ours, 65536).decode()
        self.written = ""

    def end(self):
        """The exit status, after reading what is still written. The terminal is as it was before."""
        end = time.monotonic() + PATIENCE
        while self.process.poll() is None and time.monotonic() < end:
            if select.select([self._ours], [], [], 0.05)[0]:
                self.written += os.read(self._ours, 65536).decode()
        status = self.process.wait(1)
        while select.select([self._ours], [], [], 0)[0]:
            self.written += os.read(self._ours, 65536).decode()
        assert termios.tcgetattr(self._theirs)[:4] == self.before[:4], "the terminal was not put back"
        return status

    def close(self):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        os.close(self._ours)
        os.close(self._theirs)


class Watch(unittest.TestCase):
    def setUp(self):
        self.plant = self.enterContext(DemoPlant())

    def on_terminal(self, **options):
        watch = OnTerminal(self.plant.control, **options)
        self.addCleanup(watch.close)
        return watch

    def into_pipe(self, *arguments):
        command = [program("mbgatectl"), "status", "--watch", "--every", "100ms", "--control", self.plant.control]
        watch = subprocess.Popen(
            [*command, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        self.addCleanup(watch.kill)
        return watch

    def test_q_ends_the_screen(self):
        watch = self.on_terminal()
        watch.wait_for("No faults found")
        watch.type(b"q")
        self.assertEqual(watch.end(), 0)

    def test_ctrl_c_ends_the_screen(self):
        watch = self.on_terminal()
        watch.wait_for("No faults found")
        watch.type(b"\x03")
        self.assertEqual(watch.end(), 0)

    def test_a_small_window_is_cut_and_says_so(self):
        watch = self.on_terminal(rows=5, columns=30)
        watch.wait_for("more lines: the wi")
        watch.resize(40, 160)
        watch.wait_for("P90, P99: percentiles of DRIVE")
        watch.type(b"q")
        self.assertEqual(watch.end(), 0)

    def test_the_screen_goes_on_without_the_gateway(self):
        watch = self.on_terminal()
        watch.wait_for("No faults found")
        self.plant.end_gateway()
        watch.wait_for("there is no control socket at")
        self.assertIsNone(watch.process.poll())
        watch.type(b"q")
        self.assertEqual(watch.end(), 0)

    def test_a_terminal_whose_cursor_cannot_be_moved_gets_blocks(self):
        watch = self.on_terminal(terminal="dumb")
        watch.wait_for(r"(?s)No faults found.*\r\n\r\n[0-9:.]+\r\nmbgated ")
        watch.type(b"\x03")
        self.assertEqual(watch.end(), 0)

    def test_blocks_have_a_blank_line_between_and_end_by_a_signal(self):
        for ending in (signal.SIGINT, signal.SIGTERM):
            watch = self.into_pipe()
            lines = [watch.stdout.readline()]
            while lines.count("No faults found.\n") < 2:
                lines.append(watch.stdout.readline())
            watch.send_signal(ending)
            rest, errors = watch.communicate(timeout=PATIENCE)
            self.assertEqual((watch.returncode, errors), (0, ""))
            text = "".join(lines) + rest
            blocks = re.split(r"\n(?=\d\d:\d\d:\d\d\.\d{3}\nmbgated )", "\n" + text)
            self.assertEqual(blocks[0], "")
            self.assertTrue(all(block.endswith("\n") for block in blocks[1:]))
            self.assertGreaterEqual(len(blocks), 3)

    def test_json_is_one_object_a_line(self):
        watch = self.into_pipe("--times", "2", "--json")
        printed, errors = watch.communicate(timeout=PATIENCE)
        self.assertEqual((watch.returncode, errors), (0, ""))
        self.assertEqual([len(json.loads(line)["buses"]) for line in printed.splitlines()], [2, 2])


if __name__ == "__main__":
    sys.exit(unittest.main())
