# SPDX-License-Identifier: Apache-2.0
"""What every check begins with: a machine with the package, two adapters outside, and mbgated between them and us."""

import json
import re
from time import monotonic, sleep

from adapters import Adapter
from client import Client, read, told

PORT = 1502
LINE_B = 'baud = 115200\nparity = "none"'
DROP_INS = "/etc/systemd/system/mbgated.service.d"

# Both lines listen for a second at a start, not for the two minutes that the longest response timeouts would have.
# Units 1 to 9 are the drives of line a, 11 to 19 those of line b. Unit 21 is drive 1, and what waits for it does so for
# 8 s only; what waits for unit 1 does so for two minutes.
CONFIGURATION = """
[[listen]]
name = "plant"
address = "0.0.0.0"
port = {port}
allow = ["10.0.2.0/24", "127.0.0.0/8"]
[[bus]]
name = "line-a"
device = "{a}"
baud = 19200
parity = "even"
response_timeout = "5s"
retries = 0
listen_first = "1s"
{line_a}
[[bus]]
name = "line-b"
device = "{b}"
{line_b}
response_timeout = "5s"
listen_first = "1s"
[[device]]
name = "hurt"
bus = "line-a"
address = 2
response_timeout = "5s"
quarantine = "100ms"
[[device]]
name = "silent"
bus = "line-a"
address = 5
response_timeout = "{silent}"
[[route]]
unit = "1-9"
bus = "line-a"
deadline = "2m"
[[route]]
unit = "11-19"
bus = "line-b"
address = "1-9"
[[route]]
unit = 21
bus = "line-a"
address = 1
deadline = "8s"
"""


class Plant:
    """`a` and `b` are the adapters; drives 1 and 2 are on each line, and 5, which never answers, on that of a."""

    def __init__(self, guest):
        self.guest = guest
        self.a = Adapter("MBGATE01", 0, "19200 8E1", (1, 2, 5))
        self.b = Adapter("MBGATE02", 1, "115200 8N1", (1, 2))
        self.a.line.silent = {5}
        self.adapters = None
        self.port = 0

    def install(self):
        """The package, as it is after installing: nothing runs."""
        self.guest.run("tar -C /root -xf /dev/vdb && dpkg -i /root/mbgate.deb")
        self.port = self.guest.reach(PORT)

    def configure(self, line_a="", line_b=LINE_B, silent="10s"):
        """Writes the configuration; it takes effect at the next start or reload."""
        text = CONFIGURATION.format(
            port=PORT, a=self.a.path, b=self.b.path, line_a=line_a, line_b=line_b, silent=silent
        )
        self.guest.write("/etc/mbgate/mbgate.toml", text)

    def restart(self):
        self.guest.run("systemctl reset-failed mbgated; systemctl restart mbgated")

    def drop_in(self, name, text):
        self.guest.write(f"{DROP_INS}/{name}.conf", text)
        self.guest.run("systemctl daemon-reload")

    def remove_drop_ins(self):
        self.guest.run(f"rm -rf {DROP_INS} && systemctl daemon-reload")

    def show(self, name):
        """A property of the unit."""
        return self.guest.run(f"systemctl show mbgated -P {name}")

    def client(self):
        return Client(self.port)

    def read(self, unit, register=0):
        """The answer to a read of its own connection, in the words of a line."""
        client = self.client()
        try:
            return told(client.ask(unit, read(register)))
        except OSError as error:
            return str(error)
        finally:
            client.close()

    def wait_until_served(self, unit, patience=60):
        """Reads until there is an answer with a value."""
        end = monotonic() + patience
        while True:
            answer = self.read(unit)
            if answer.startswith("0302"):
                return answer
            if monotonic() > end:
                raise AssertionError(f"unit {unit} is not served within {patience} s: {answer}")
            sleep(0.2)

    def wait_for_waiting(self, bus, count):
        """Until so many requests wait for this bus."""
        end = monotonic() + 60
        while True:
            status = json.loads(self.guest.run("mbgatectl status --json"))
            waiting = next(each["waiting"] for each in status["buses"] if each["name"] == bus)
            if waiting >= count:
                return
            assert monotonic() < end, f"{waiting} requests wait for {bus}, not {count}"
            sleep(0.1)

    def mark(self):
        """A place in the journal, which setting the clock does not move."""
        return float(self.guest.run("cut -d' ' -f1 /proc/uptime"))

    def journal(self, mark, pattern=""):
        """What mbgated and systemd said of it since then, where it matches."""
        printed = self.guest.run("journalctl -u mbgated -o short-monotonic --no-hostname --no-pager -q")
        lines = [re.match(r"\[ *([0-9.]+)\] \S+: (.*)", line) for line in printed.splitlines()]
        return [line[2] for line in lines if line and float(line[1]) >= mark and re.search(pattern, line[2])]

    def status(self):
        return self.guest.run("mbgatectl status")
