# SPDX-License-Identifier: Apache-2.0
"""A container with systemd as its first process. What it writes goes into memory and is gone when it ends."""

import contextlib
import ctypes
import os
import pathlib
import subprocess
import time

CLONE_NEWNET = 0x40000000
HOST_NETWORK = os.open("/proc/self/ns/net", os.O_RDONLY)


def eventually(condition, patience=30.0, pause=0.02):
    """The first true value of the condition, or its last one when patience is over."""
    end = time.monotonic() + patience
    while True:
        value = condition()
        if value or time.monotonic() > end:
            return value
        time.sleep(pause)


class Done:
    """What a command left: its exit status, and all that it printed."""

    def __init__(self, status, output):
        self.status = status
        self.output = output.strip()

    def __bool__(self):
        return self.status == 0

    def __str__(self):
        return f"status {self.status}: {self.output}" if self.output else f"status {self.status}"


class Container:
    def __init__(self, root, work, name, volatile=True):
        self.console = pathlib.Path(work) / f"{name}.console"
        # Version 2 of control groups and the right to load BPF programs: without them DeviceAllow= is not enforced.
        command = ["systemd-nspawn", "--quiet", "--register=no", "--keep-unit", "--private-network", "--boot"]
        command += ["-D", str(root), f"--machine={name}", "--system-call-filter=bpf"]
        command += ["--capability=CAP_BPF,CAP_PERFMON,CAP_NET_ADMIN,CAP_SYS_NICE"]
        command += ["--volatile=overlay"] if volatile else []
        with open(self.console, "wb") as console:
            self.process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=console,
                stderr=console,
                start_new_session=True,
                env={**os.environ, "SYSTEMD_NSPAWN_UNIFIED_HIERARCHY": "1"},
            )
        self.leader = None

    def boot(self):
        """Waits until systemd has started everything; returns its word for that."""
        self.leader = eventually(self._first_process)
        if not self.leader:
            self.process.kill()
            raise RuntimeError(f"the container did not boot: {self.console.read_text(errors='replace')}")
        state = eventually(self._state, 60)
        self.run("ip", "link", "set", "lo", "up")
        self._enter_network()
        return state

    def run(self, *command, patience=60):
        """Runs a command inside, as root."""
        try:
            done = subprocess.run(
                ["nsenter", "-t", str(self.leader), "-a", *command],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                errors="replace",
                timeout=patience,
                check=False,
                env={"PATH": "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin", "LC_ALL": "C.UTF-8",
                     "DEBIAN_FRONTEND": "noninteractive", "SYSTEMD_PAGER": "", "SYSTEMD_COLORS": "0"},
            )
        except subprocess.TimeoutExpired as late:
            return Done(124, f"{' '.join(command)}: not done after {patience} s: {late.stdout or ''}")
        return Done(done.returncode, done.stdout)

    def must(self, *command):
        """Runs a command that has to succeed; returns what it printed."""
        done = self.run(*command)
        if not done:
            raise RuntimeError(f"{' '.join(command)}: {done}")
        return done.output

    def path(self, path):
        """Where a file of the container is seen from outside."""
        return pathlib.Path(f"/proc/{self.leader}/root{path}")

    def write(self, path, text):
        file = self.path(path)
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")

    def read(self, path):
        return self.path(path).read_text(encoding="utf-8")

    def end(self):
        if self.leader:
            self.run("systemctl", "poweroff", "--no-block")
        try:
            self.process.wait(20)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.console.unlink()
        _set_network(HOST_NETWORK)

    def _first_process(self):
        children = pathlib.Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children")
        for child in children.read_text(encoding="ascii").split() if children.exists() else []:
            with contextlib.suppress(FileNotFoundError):  # it has ended
                if pathlib.Path(f"/proc/{child}/comm").read_text(encoding="ascii").strip() == "systemd":
                    return int(child)
        return None

    def _state(self):
        word = self.run("systemctl", "is-system-running").output
        return word if word in ("running", "degraded") else None

    def _enter_network(self):
        """From here on the sockets that this thread and its later ones make are in the container's network."""
        with open(f"/proc/{self.leader}/ns/net", "rb") as network:
            _set_network(network.fileno())


def _set_network(descriptor):
    if ctypes.CDLL(None, use_errno=True).setns(descriptor, CLONE_NEWNET) != 0:
        raise OSError(ctypes.get_errno(), "setns")
