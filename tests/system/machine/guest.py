# SPDX-License-Identifier: Apache-2.0
"""A virtual machine without hardware support: it runs commands as root, and its ports can be reached from here."""

import json
import pathlib
import re
import shlex
import socket
import subprocess
import tempfile
import time

PATIENCE = 300  # seconds; only ends what hangs
HERE_FROM_THERE = "10.0.2.2"  # this machine, as the other one sees it


class Guest:
    """with Guest(image, payload) as guest: guest.run("systemctl start x"). Nothing that it writes stays; `payload` is a
    tar file that it can read from /dev/vdb."""

    def __init__(self, image, payload):
        self._image, self._payload = image, payload

    def __enter__(self):
        self._folder = tempfile.TemporaryDirectory(prefix="machine.")
        folder = pathlib.Path(self._folder.name)
        self.console = folder / "console"
        self._process = subprocess.Popen(self._command(folder), stdin=subprocess.DEVNULL, stderr=subprocess.PIPE)
        self._heard = b""
        try:
            self._agent = self._connect(folder / "agent")
            monitor = self._connect(folder / "monitor")
            self._monitor = monitor.makefile("rwb")
            self._monitor.readline()
            self._ask_monitor("qmp_capabilities")
            self._answer("booting")
        except BaseException:
            self.__exit__()
            raise
        return self

    def _command(self, folder):
        image = self._image
        words = [
            "-accel tcg,thread=multi -cpu max -smp 2 -m 512 -nodefaults -no-reboot -display none",
            f"-kernel {image.kernel} -initrd {image.initrd}",
            "-append 'console=ttyS0 quiet mitigations=off systemd.show_status=0'",
            f"-drive file={image.disk},format=raw,if=virtio,snapshot=on",
            f"-drive file={self._payload},format=raw,if=virtio,readonly=on",
            f"-chardev file,id=console,path={self.console} -device isa-serial,chardev=console",
            f"-device virtio-serial-pci -chardev socket,id=agent,path={folder}/agent,server=on,wait=off",
            "-device virtserialport,chardev=agent,name=agent",
            "-netdev user,id=net -device virtio-net-pci,netdev=net",
            f"-qmp unix:{folder}/monitor,server=on,wait=off",
        ]
        return ["nice", "-n", "5", "qemu-system-x86_64", *shlex.split(" ".join(words))]

    def _connect(self, path):
        connection = socket.socket(socket.AF_UNIX)
        connection.settimeout(PATIENCE)
        for _ in range(600):
            try:
                connection.connect(str(path))
                return connection
            except OSError:
                if self._process.poll() is not None:
                    raise RuntimeError("qemu: " + self._process.stderr.read().decode()) from None
                time.sleep(0.05)
        raise RuntimeError("qemu does not listen")

    def _ask_monitor(self, command, **arguments):
        self._monitor.write(json.dumps({"execute": command, "arguments": arguments}).encode() + b"\n")
        self._monitor.flush()
        while True:
            answer = json.loads(self._monitor.readline())
            if "return" in answer:
                return answer["return"]
            if "error" in answer:
                raise RuntimeError(f"{command}: {answer['error']}")

    def _answer(self, command):
        """What the agent printed, and its status."""
        while True:
            match = re.match(rb"(?s)(.*?)\036(\d+)\n", self._heard)
            if match:
                self._heard = self._heard[match.end():]
                return match.group(1).decode(errors="replace"), int(match.group(2))
            try:
                more = self._agent.recv(65536)
            except TimeoutError:
                more = b""
            if not more:
                console = self.console.read_text(errors="replace")[-3000:]
                raise RuntimeError(f"no answer to: {command}\n{console}")
            self._heard += more

    def ask(self, command):
        """Standard output and error of a shell command, and its status."""
        self._agent.sendall(" ".join(command.splitlines()).encode() + b"\n")
        return self._answer(command)

    def run(self, command):
        """The same where the status must be 0."""
        printed, status = self.ask(command)
        if status != 0:
            raise RuntimeError(f"{command}: status {status}: {printed}")
        return printed.strip()

    def write(self, path, text):
        """A file with this text."""
        words = " ".join(shlex.quote(line) for line in text.splitlines())
        self.run(f"mkdir -p {shlex.quote(str(pathlib.PurePath(path).parent))} && printf '%s\\n' {words} > {path}")

    def wait_for(self, command, what, patience=60):
        """Until it succeeds; what it printed then."""
        end = time.monotonic() + patience
        while True:
            printed, status = self.ask(command)
            if status == 0:
                return printed.strip()
            if time.monotonic() > end:
                raise RuntimeError(f"{what}: not within {patience} s: {printed}")
            time.sleep(0.2)

    def reach(self, port):
        """A port of this machine's 127.0.0.1 that leads to that one's `port`."""
        self._ask_monitor("human-monitor-command", **{"command-line": f"hostfwd_add net tcp:127.0.0.1:0-:{port}"})
        table = self._ask_monitor("human-monitor-command", **{"command-line": "info usernet"})
        return int(re.search(rf"HOST_FORWARD\]\s+\d+\s+127\.0\.0\.1\s+(\d+)\s+\S+\s+{port}\s", table).group(1))

    def __exit__(self, *_):
        self._process.terminate()
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process.stderr.close()
        for name in ("_agent", "_monitor"):
            if hasattr(self, name):
                getattr(self, name).close()
        self._folder.cleanup()
