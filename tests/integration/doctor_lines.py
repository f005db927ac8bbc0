# SPDX-License-Identifier: Apache-2.0
"""mbgatectl doctor, started by a test, and the lines that it prints."""

import re
import subprocess
import unittest

from demo_plant import PATIENCE, program


def without_figures(text):
    """Times and numbers of processes are those of this run."""
    return re.sub(r"process \d+", "process P", re.sub(r"\d+\.\d ms", "T", text))


def beginning(device, mode):
    return [
        f"ok       port: {device} exists",
        f"ok       permission: USER may open {device}",
        "ok       holder: no other program is seen to have it open",
        "unknown  latency: PTY is not an FTDI adapter, or does not show its timer",
        f"unknown  settings: {mode} is set, but a pseudo-terminal has no parity to read back",
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
