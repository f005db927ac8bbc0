# SPDX-License-Identifier: Apache-2.0
"""The plant of the demo: mbgate-sim and mbgated on conf/demo*.toml, in a folder of their own, on a port that the
kernel chooses. The programs are those in the folder MBGATE_PROGRAMS, else the installed ones."""

import contextlib
import os
import pathlib
import queue
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time

CONFIGURATION = pathlib.Path(__file__).parents[2] / "conf"
PATIENCE = 30  # seconds until a program must have said what it has to say

# Hands a socket over as systemd does, named "http".
HAND_OVER = """
import os, sys
os.dup2(int(sys.argv[1]), 3)
os.environ.update(LISTEN_PID=str(os.getpid()), LISTEN_FDS="1", LISTEN_FDNAMES="http")
os.execv(sys.argv[2], sys.argv[2:])
"""


def program(name):
    """The path of one of mbgate's programs."""
    folder = os.environ.get("MBGATE_PROGRAMS", os.environ.get("PATH", "") + ":/usr/sbin")
    path = shutil.which(name, path=folder)
    if path is None:
        raise FileNotFoundError(f"{name} is not in {folder}")
    return path


class Process:
    """A program that we started: its lines as they come, and its end. `given`: a socket that systemd would give it.
    `wrapped`: the command that becomes it, with the descriptors of `keep` open. `prepare` runs in it before the program
    does. `output`: a descriptor for what it prints, which is the caller's then."""

    def __init__(self, folder, name, *arguments, given=None, wrapped=(), environment=None, keep=(), prepare=None,
                 output=subprocess.PIPE):
        self.name = name
        self.printed = []
        self._lines = queue.Queue()
        if given is not None:
            wrapped, keep = [sys.executable, "-c", HAND_OVER, str(given.fileno())], [given.fileno()]
        self._process = subprocess.Popen(
            [*wrapped, program(name), *map(str, arguments)],
            cwd=folder,
            env=environment,
            pass_fds=keep,
            stdout=output,
            stderr=subprocess.STDOUT,
            preexec_fn=prepare,
            text=True,
        )
        self.pid = self._process.pid
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self):
        for line in self._process.stdout or ():
            self._lines.put(line)
        self._lines.put(None)

    def wait_for(self, pattern):
        """The match of the first line from now on that `pattern` matches."""
        while True:
            try:
                line = self._lines.get(timeout=PATIENCE)
            except queue.Empty:
                line = None
            if line is None:
                raise AssertionError(f"{self.name} did not print {pattern!r} but:\n{''.join(self.printed)}")
            self.printed.append(line)
            match = re.search(pattern, line)
            if match:
                return match

    def unseen(self):
        """Those of its lines that came since, and were not waited for. They are waited for then."""
        while not self._lines.empty():
            line = self._lines.get()
            if line is not None:
                self.printed.append(line)
        return self.printed

    def wait(self):
        """Waits until the program has ended by itself; its exit status."""
        return self._process.wait(PATIENCE)

    def signal(self, number):
        self._process.send_signal(number)

    def process_file(self, name):
        """What stands in this file of the program's in /proc."""
        return pathlib.Path(f"/proc/{self._process.pid}/{name}").read_text(encoding="utf-8")

    def sockets(self):
        """How many it has. One that it closes while they are counted is not one of them."""
        count = 0
        for file in pathlib.Path(f"/proc/{self.pid}/fd").iterdir():
            with contextlib.suppress(FileNotFoundError):
                count += os.readlink(file).startswith("socket:")
        return count

    def state(self):
        """The letter of ps: T is a program that was stopped."""
        return re.search(r"State:\s+(\w)", self.process_file("status")).group(1)

    def end(self):
        """Asks the program to end; its exit status."""
        self._process.terminate()
        try:
            status = self._process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            status = self._process.wait()
        self._reader.join()
        if self._process.stdout:
            self._process.stdout.close()
        return status


class Plant:
    """Programs in a folder of their own, which _start() starts and adds to _processes; they are ended with it."""

    def __enter__(self):
        self._folder = tempfile.TemporaryDirectory()
        self._processes = []
        try:
            self._start()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        statuses = {process.name: process.end() for process in reversed(self._processes)}
        self._folder.cleanup()
        wrong = {name: status for name, status in statuses.items() if status != 0}
        assert not wrong, f"exit status other than 0: {wrong}"


class DemoPlant(Plant):
    """with DemoPlant() as plant: plant.port is where the gateway listens on 127.0.0.1, plant.control its control
    socket, plant.configuration its file."""

    def _start(self):
        folder = pathlib.Path(self._folder.name)
        text = (CONFIGURATION / "demo.toml").read_text(encoding="utf-8")
        text = re.sub(r"(?m)^port *=.*$", "port = 0", text)
        # On a busy machine the simulator may answer late.
        text = text.replace('response_timeout = "300ms"', 'response_timeout = "3s"\nlisten_first = "300ms"')
        self.control = folder / "control"
        self.configuration = folder / "demo.toml"
        self.configuration.write_text(f'{text}\n[http]\nsocket = "{self.control}"\n', encoding="utf-8")
        drives = Process(folder, "mbgate-sim", CONFIGURATION / "demo-sim.toml")
        self._processes.append(drives)
        drives.wait_for("^ready")
        self.start_gateway()
        # A line listens before it first transmits, and a write may not wait for long; a read may. On a busy machine a
        # drive may answer late.
        for table, unit in (("holding", 1), ("coils", 17)):
            read = [program("mbgatectl"), "read", table, "0", "--unit", str(unit), "--port", str(self.port)]
            latest = time.monotonic() + PATIENCE
            while subprocess.run(read, stdout=subprocess.DEVNULL, timeout=PATIENCE, check=False).returncode != 0:
                assert time.monotonic() < latest, f"unit {unit} does not answer"

    def start_gateway(self, given=None):
        gateway = Process(self.configuration.parent, "mbgated", "--config", self.configuration, given=given)
        self._processes.append(gateway)
        self.port = int(gateway.wait_for(r"listening demo 127\.0\.0\.1:(\d+)$").group(1))

    def wait_for(self, pattern):
        """The match of the first line of the gateway from now on that `pattern` matches."""
        return self._processes[-1].wait_for(pattern)

    def printed(self):
        """The lines of the gateway that were waited for, and those before them."""
        return self._processes[-1].printed

    def lines(self):
        """All lines of the gateway so far."""
        return list(self._processes[-1].unseen())

    def pid(self):
        """Of the gateway."""
        return self._processes[-1].pid

    def end_gateway(self):
        """Asks the gateway alone to end."""
        gateway = self._processes.pop()
        status = gateway.end()
        assert status == 0, f"exit status {status}"
