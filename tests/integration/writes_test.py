#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""mbgated writes nothing outside of its state directory: strace sees every call that names a file, while clients ask,
the configuration is read again, a recording is made and the HTTP interface answers."""

import re
import shutil
import subprocess
import sys
import unittest

from demo_plant import Process
from fault_plant import FaultCase

SKIPPED = 77
WRITING = re.compile(r"O_WRONLY|O_RDWR|O_CREAT|O_TRUNC|O_APPEND|O_TMPFILE")
OPENING = re.compile(r"^(open|openat|openat2|creat)\(")
# The other calls that may change something by a name.
CHANGING = re.compile(r"^(mkdir|mknod|unlink|rmdir|rename|link|symlink|truncate|chmod|fchmodat|chown|lchown|fchownat|"
                      r"utime|futimesat|setxattr|lsetxattr|removexattr|mount|umount|pivot_root|chroot|swapon)\w*\(")
COMMAND = ("strace", "--follow-forks", "--trace=%file,bind", "--strings-in-hex=none", "--string-limit=400")


def can_trace():
    done = subprocess.run(["strace", "--trace=%file", "true"], check=False, capture_output=True)
    return done.returncode == 0


def changes(trace):
    """The paths that were written to, or would have been, each with its call."""
    found = []
    for line in trace.splitlines():
        call = re.sub(r"^(\[pid +\d+\] |\d+ +)", "", line)
        paths = re.findall(r'"((?:[^"\\]|\\.)*)"', call)
        if OPENING.match(call) and (WRITING.search(call) or call.startswith("creat")):
            found.append((paths[0], call))
        elif CHANGING.match(call):
            found += [(path, call) for path in paths]
        elif call.startswith("bind(") and "AF_UNIX" in call and 'sun_path="' in call:
            found.append((paths[0], call))
    return found


class Writes(FaultCase):
    def test_nothing_is_written_outside_of_the_state_directory(self):
        line = self.line()
        state = self.folder / "state"
        state.mkdir()
        trace = self.folder / "trace"
        run = self.folder / "run"
        run.mkdir()
        self.control = run / "control"
        self.configure(line.path)
        environment = {"PATH": "/usr/bin:/bin", "STATE_DIRECTORY": str(state), "ASAN_OPTIONS": "detect_leaks=0"}
        arguments = ("--config", self.configuration, "--record", "plant.rec")
        self.gateway = Process(self.folder, "mbgated", *arguments, environment=environment,
                               wrapped=(*COMMAND, f"--output={trace}", "--"))
        self.addCleanup(self.gateway.end)
        self.port = int(self.gateway.wait_for(r"listening plant 127\.0\.0\.1:(\d+)$").group(1))
        reader = self.reader()
        for method, path in (("GET", "/api/v1/status"), ("POST", "/api/v1/clear-counters"), ("POST", "/api/v1/reload")):
            self.assertEqual(self.ask(method, path)[0], 200)
        self.assert_serves(reader, self.client())
        subprocess.run(["pkill", "--signal", "TERM", "--parent", str(self.gateway.pid)], check=True)
        self.assertEqual(self.gateway.wait(), 0)
        self.assertGreater((state / "plant.rec").stat().st_size, 0)
        made = changes(trace.read_text(encoding="utf-8"))
        self.assertIn(str(state / "plant.rec"), {path for path, _ in made})
        allowed = (f"{state}/", f"{run}/control", line.path, "/dev/null")
        elsewhere = [call for path, call in made if not path.startswith(allowed)]
        self.assertEqual(elsewhere, [])

    def test_a_write_elsewhere_is_seen(self):
        seen = changes('12 openat(AT_FDCWD, "/etc/passwd", O_RDWR|O_CLOEXEC) = -1 EACCES (Permission denied)\n'
                       '12 openat(AT_FDCWD, "/etc/hosts", O_RDONLY|O_CLOEXEC) = 4\n'
                       '[pid    12] rename("/tmp/a", "/tmp/b") = 0\n'
                       '12 bind(3, {sa_family=AF_UNIX, sun_path="/run/x"}, 110) = 0\n')
        self.assertEqual([path for path, _ in seen], ["/etc/passwd", "/tmp/a", "/tmp/b", "/run/x"])


if __name__ == "__main__":
    if shutil.which("strace") is None or not can_trace():
        print("skipped: strace is not there, or may not trace here")
        sys.exit(SKIPPED)
    unittest.main(verbosity=2)
