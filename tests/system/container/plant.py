# SPDX-License-Identifier: Apache-2.0
"""What a plant has in the container: simulated drives on a pseudo-terminal, the service, its configuration."""

import pathlib
import re
import time

from container import eventually

CONFIGURATION = "/etc/mbgate/mbgate.toml"
DROP_INS = "/etc/systemd/system/mbgated.service.d"
EVERY_KEY = "/usr/share/doc/mbgate/mbgate.toml"
EXAMPLES = "/usr/share/doc/mbgate/examples"
LINE = "/run/drives/line-a"
ABSENT = "/run/drives/absent"
UNITS = ("mbgated.service", "mbgated.socket", "mbgated-http.socket")
PORT = 502  # of the listener "plant", by mbgated.socket
SERVICE_PORT = 1502  # of the listener "service", which mbgated binds
AXIS = 1  # a drive, and 30 a register of it that can be written and read
REGISTER = 30

DRIVES = """
[[bus]]
name = "line-a"
link = "line-a"
baud = 115200
parity = "none"

[[device]]
name = "axis-x"
bus = "line-a"
address = 1
model = "moons"
series = "m3"
word_order = "little"

[[device]]
name = "turntable"
bus = "line-a"
address = 17
model = "aic"
"""

# Besides the line with the drives one whose adapter is absent, and a drive that is silent.
BASE = f"""
[[listen]]
name = "plant"
address = "127.0.0.1"
port = {PORT}
allow = ["127.0.0.0/8"]

[[listen]]
name = "service"
address = "127.0.0.1"
port = {SERVICE_PORT}
bus = "line-a"

[[bus]]
name = "line-a"
device = "{LINE}"
baud = 115200
parity = "none"
response_timeout = "300ms"

[[bus]]
name = "line-b"
device = "{ABSENT}"

[[device]]
name = "axis-x"
bus = "line-a"
address = 1
profile = "moons-m3"
word_order = "little"

[[device]]
name = "silent"
bus = "line-a"
address = 99

[[route]]
unit = 1
device = "axis-x"

[[route]]
unit = 99
device = "silent"

[[route]]
unit = 2
bus = "line-b"
address = 2
"""


def without_listener(text, name):
    """The configuration without the listener of that name."""
    parts = re.split(r"(?m)^(?=\[\[)", text)
    return "".join(part for part in parts if not (part.startswith("[[listen]]") and f'name = "{name}"' in part))


class Plant:
    def __init__(self, container, report):
        self.container = container
        self.report = report
        self.cursor = None

    def install(self, package):
        """Returns what dpkg said; raises if it failed."""
        self.container.path("/root/mbgate.deb").write_bytes(pathlib.Path(package).read_bytes())
        return self.container.must("dpkg", "--force-confold", "-i", "/root/mbgate.deb")

    def start_drives(self):
        self.container.write("/etc/drives.toml", DRIVES)
        self.container.must(
            "systemd-run", "--quiet", "--unit=drives", "--property=RuntimeDirectory=drives",
            "--property=WorkingDirectory=/run/drives", "/usr/bin/mbgate-sim", "/etc/drives.toml",
        )
        if not eventually(lambda: "ready" in self.container.run("journalctl", "-o", "cat", "-u", "drives").output):
            raise RuntimeError("mbgate-sim is not ready: " + self.container.run("journalctl", "-u", "drives").output)
        self.open_to_dialout(self.container.must("readlink", "-f", LINE))

    def open_to_dialout(self, terminal):
        """Gives a pseudo-terminal the rights that udev gives a serial port."""
        self.container.must("chgrp", "dialout", terminal)
        self.container.must("chmod", "660", terminal)

    def configure(self, text=BASE):
        self.container.write(CONFIGURATION, text)

    def drop_in(self, name, text):
        self.container.write(f"{DROP_INS}/{name}", text)
        self.systemctl("daemon-reload")

    def shipped_drop_in(self, name):
        """As the documentation says: copied from the examples."""
        self.container.must("mkdir", "-p", DROP_INS)
        self.container.must("cp", f"{EXAMPLES}/{name}", DROP_INS)
        self.systemctl("daemon-reload")

    def fresh(self):
        """Everything stopped, nothing but the package's own units, the usual configuration."""
        self.systemctl("stop", *UNITS)
        self.systemctl("disable", *UNITS)
        self.container.run("rm", "-rf", DROP_INS)
        self.systemctl("daemon-reload")
        self.systemctl("reset-failed")
        self.configure()
        self.mark()

    def start(self):
        """With its socket, as the documentation says."""
        self.systemctl("enable", "--now", "mbgated.socket")
        done = self.systemctl("start", "mbgated")
        if not done:
            raise RuntimeError(f"mbgated does not start: {done}: {self.journal()}")

    def systemctl(self, *arguments):
        return self.container.run("systemctl", *arguments)

    def restart(self):
        """How long systemctl took. systemd's own limit of restarts a minute is none for us."""
        self.systemctl("reset-failed", "mbgated")
        begin = time.monotonic()
        done = self.systemctl("restart", "mbgated")
        if not done:
            raise RuntimeError(f"systemctl restart: {done}: {self.journal()}")
        return time.monotonic() - begin

    def property(self, name, unit="mbgated.service"):
        return self.systemctl("show", "--value", "-p", name, unit).output

    def main_pid(self):
        """0 if there is none."""
        return int(self.property("MainPID") or 0)

    def signal(self, word):
        """To the main process, once it is ready. Without one it is not sent, because 0 would be ourselves."""
        eventually(lambda: self.property("SubState") == "running")
        pid = self.main_pid()
        if not pid:
            raise RuntimeError(f"mbgated does not run: {self.journal()}")
        self.container.must("kill", f"-{word}", str(pid))
        return pid

    def is_active(self, unit="mbgated.service"):
        return self.systemctl("is-active", unit).output

    def mark(self):
        """What the journal has until now is not shown any more."""
        self.container.run("journalctl", "--sync")
        shown = self.container.must("journalctl", "-n", "1", "-o", "cat", "--show-cursor")
        self.cursor = shown.rsplit("-- cursor: ", 1)[1]

    def journal(self, *options):
        """What mbgated and systemd have said of the service since mark()."""
        self.container.run("journalctl", "--sync")
        options = options or ("-o", "cat")
        return self.container.run("journalctl", "-q", "-u", "mbgated", "--after-cursor", self.cursor, *options).output

    def says(self, *words, patience=10):
        """Whether the journal has a line with all of these words, soon."""
        return eventually(
            lambda: next((line for line in self.journal().splitlines() if all(word in line for word in words)), ""),
            patience, 0.2,
        )

    def exposure(self):
        """What systemd-analyze says of the service as it is loaded."""
        shown = self.container.run("systemd-analyze", "security", "--no-pager", "mbgated.service").output
        found = re.search(r"Overall exposure level for mbgated.service: ([0-9.]+)", shown)
        return float(found[1]) if found else None
