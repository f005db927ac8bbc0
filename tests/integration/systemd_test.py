#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What mbgated and systemd say to each other, with a stand-in for systemd: the watchdog, the sockets that are kept over
a restart, a reload, a start without a bus."""

import array
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

from demo_plant import PATIENCE, Process, program

# As systemd starts a process: with these sockets from descriptor 3 on.
START = """
import os, sys
count, names = int(sys.argv[1]), sys.argv[2]
sockets = [os.dup(int(number)) for number in sys.argv[3:3 + count]]
high = [os.dup2(number, 100 + i) for i, number in enumerate(sockets)]
for i, number in enumerate(high):
    os.dup2(number, 3 + i)
os.closerange(3 + count, 200)
if count:
    os.environ.update(LISTEN_PID=str(os.getpid()), LISTEN_FDS=str(count), LISTEN_FDNAMES=names)
os.execv(sys.argv[3 + count], sys.argv[3 + count:])
"""
IP_FREEBIND = 15  # linux/in.h; Python has no name for it
READ = bytes.fromhex("0001 0000 0006 01 03 0000 0001")
WRITE = bytes.fromhex("0002 0000 0006 01 06 003C 0001")


class Systemd:
    """Its end of the notification socket, and the sockets that it keeps, by name."""

    def __init__(self, folder):
        self.path = folder / "notify"
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(str(self.path))
        self.kept = {}
        self.heard = []

    def receive(self, timeout):
        """The next message as a dictionary, and None if there is none in that time."""
        self._socket.settimeout(timeout)
        try:
            text, more, _, _ = self._socket.recvmsg(4096, socket.CMSG_SPACE(4 * 16))
        except (TimeoutError, BlockingIOError):
            return None
        message = dict(line.split("=", 1) for line in text.decode().split("\n") if line)
        sockets = array.array("i")
        for _, _, data in more:
            sockets.frombytes(data)
        name = message.get("FDNAME")
        if message.get("FDSTORE"):
            assert len(sockets) == 1
            self._keep(name, socket.socket(fileno=sockets[0]))
        if message.get("FDSTOREREMOVE"):
            for kept in self.kept.pop(name, []):
                kept.close()
        self.heard.append(message)
        return message

    def _keep(self, name, given):
        """Once, though it was given twice."""
        number = os.fstat(given.fileno()).st_ino
        if any(os.fstat(kept.fileno()).st_ino == number for kept in self.kept.get(name, [])):
            given.close()
        else:
            self.kept.setdefault(name, []).append(given)

    def wait_for(self, key, value="1"):
        """The first message from now on in which that stands."""
        limit = time.monotonic() + PATIENCE
        while time.monotonic() < limit:
            message = self.receive(limit - time.monotonic())
            if message and re.fullmatch(value, message.get(key, "")):
                return message
        raise AssertionError(f"mbgated did not say {key}={value} but {self.heard}")

    def read_all(self):
        """The messages that are there."""
        messages = []
        while message := self.receive(0):
            messages.append(message)
        return messages

    def close(self):
        for sockets in self.kept.values():
            for kept in sockets:
                kept.close()
        self._socket.close()


def free_address():
    """An address of this machine, with a port that nobody has."""
    with socket.create_server(("127.0.0.1", 0)) as chosen:
        return chosen.getsockname()


class Gateway(Process):
    """mbgated, started by a stand-in for systemd."""

    def __init__(self, systemd, configuration, watchdog=None, sockets=()):
        numbers = [str(kept.fileno()) for _, kept in sockets]
        environment = {**os.environ, "NOTIFY_SOCKET": str(systemd.path)}
        environment.pop("WATCHDOG_USEC", None)
        if watchdog:
            environment["WATCHDOG_USEC"] = str(watchdog)
        names = ":".join(name for name, _ in sockets)
        launched = [sys.executable, "-c", START, str(len(numbers)), names, *numbers]
        super().__init__(
            configuration.parent, "mbgated", "--config", configuration,
            wrapped=launched, environment=environment, keep=[kept.fileno() for _, kept in sockets],
        )  # fmt: skip


class SystemdCase(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.systemd = Systemd(self.folder)
        self.addCleanup(self.systemd.close)
        self.configuration = self.folder / "mbgate.toml"
        self.address = free_address()
        self.configure()
        self.running = []
        self.addCleanup(lambda: [process.end() for process in self.running])

    def configure(self, keys="", more=""):
        """One listener on a line that is simulated, or not there."""
        host, port = self.address
        self.configuration.write_text(
            f'[http]\nsocket = "{self.folder}/control"\n'
            f'[[listen]]\nname = "plant"\naddress = "{host}"\nport = {port}\nbus = "line-a"\n{keys}\n'
            f'[[bus]]\nname = "line-a"\ndevice = "line-a"\nbaud = 19200\nparity = "even"\n{more}\n',
            encoding="utf-8",
        )

    def start(self, **options):
        gateway = Gateway(self.systemd, self.configuration, **options)
        self.running.append(gateway)
        return gateway

    def start_ready(self, **options):
        gateway = self.start(**options)
        self.systemd.wait_for("READY")
        return gateway

    def end(self, gateway, kill=False):
        self.running.remove(gateway)
        if kill:
            gateway.signal(signal.SIGKILL)
        status = gateway.end()
        self.assertEqual(status, -signal.SIGKILL if kill else 0)

    def handed_over(self):
        return [(name, kept) for name, sockets in self.systemd.kept.items() for kept in sockets]

    def reload(self, gateway):
        gateway.signal(signal.SIGHUP)
        self.systemd.wait_for("RELOADING")
        return self.systemd.wait_for("READY")


class Watchdog(SystemdCase):
    def test_is_fed_again_and_again_after_the_start_and_beside_reloads(self):
        gateway = self.start_ready(watchdog=200_000)
        self.assertNotIn({"WATCHDOG": "1"}, self.systemd.heard)
        for _ in range(5):
            self.systemd.wait_for("WATCHDOG")
        self.reload(gateway)
        for _ in range(5):
            self.systemd.wait_for("WATCHDOG")

    def test_is_not_fed_if_nobody_watches(self):
        gateway = self.start_ready()
        self.end(gateway)
        self.assertEqual([message for message in self.systemd.read_all() if "WATCHDOG" in message], [])

    # Silence cannot be waited for: the process is stopped, and what it does then is in /proc.
    def test_is_not_fed_by_a_process_that_is_stopped(self):
        gateway = self.start_ready(watchdog=100_000)
        self.systemd.wait_for("WATCHDOG")
        gateway.signal(signal.SIGSTOP)
        limit = time.monotonic() + PATIENCE
        while gateway.state() != "T" and time.monotonic() < limit:
            time.sleep(0.01)
        self.systemd.read_all()
        self.assertIsNone(self.systemd.receive(1))
        gateway.signal(signal.SIGCONT)
        self.systemd.wait_for("WATCHDOG")

    def test_is_all_that_an_idle_gateway_wakes_for(self):
        pattern = r"voluntary_ctxt_switches:\s+(\d+)"
        self.configure(more='reopen_min = "1h"\nreopen_max = "1h"')
        gateway = self.start_ready(watchdog=200_000)
        for _ in range(3):
            self.systemd.wait_for("WATCHDOG")
        before = int(re.search(pattern, gateway.process_file("status")).group(1))
        for _ in range(20):
            self.systemd.wait_for("WATCHDOG")
        woken = int(re.search(pattern, gateway.process_file("status")).group(1)) - before
        self.assertLessEqual(woken, 2 * 21)


class StoredSockets(SystemdCase):
    def name(self):
        return f"stored/plant/{self.address[0]}%3A{self.address[1]}"

    def connect(self):
        client = socket.create_connection(self.address, timeout=PATIENCE)
        self.addCleanup(client.close)
        return client

    def test_serve_clients_that_connect_between_two_processes(self):
        for kill in (False, True):
            gateway = self.start_ready(sockets=self.handed_over())
            self.assertEqual(list(self.systemd.kept), [self.name()])
            self.end(gateway, kill)
            reading, writing = self.connect(), self.connect()
            reading.sendall(READ)
            writing.sendall(WRITE)
            sockets = self.handed_over()
            gateway = self.start_ready(sockets=sockets)
            self.assertEqual(writing.recv(64).hex(" "), "00 02 00 00 00 03 01 86 06")  # older than the process
            self.assertEqual(reading.recv(64).hex(" "), "00 01 00 00 00 03 01 83 0a")  # the line is not there
            writing.sendall(WRITE)
            self.assertEqual(writing.recv(64).hex(" "), "00 02 00 00 00 03 01 86 0a")
            self.end(gateway)

    def test_are_let_go_where_the_address_has_changed(self):
        gateway = self.start_ready()
        self.end(gateway)
        sockets, name = self.handed_over(), self.name()
        self.address = free_address()
        self.configure()
        self.start_ready(sockets=sockets)
        self.assertEqual([m["FDNAME"] for m in self.systemd.heard if "FDSTOREREMOVE" in m], [name])
        self.assertEqual(list(self.systemd.kept), [self.name()])
        self.connect()

    # systemd has its copy until it reads that it shall let it go.
    def test_do_not_keep_a_reload_from_their_address(self):
        gateway = self.start_ready()
        with self.systemd.kept[self.name()][0].dup():
            self.configure(keys="keepalive_probes = 9")
            self.reload(gateway)
            self.assertEqual([m["FDNAME"] for m in self.systemd.heard if "FDSTOREREMOVE" in m], [self.name()])
            self.assertEqual(len(self.systemd.kept[self.name()]), 1)
            client = self.connect()
            client.sendall(READ)
            self.assertEqual(client.recv(64).hex(" "), "00 01 00 00 00 03 01 83 0a")

    def test_are_those_of_http_too(self):
        host, port = self.address
        text = self.configuration.read_text(encoding="utf-8")
        shown = free_address()
        self.configuration.write_text(
            text.replace("[http]\n", f'[http]\nlisten = ["{shown[0]}:{shown[1]}"]\n'), encoding="utf-8"
        )
        gateway = self.start_ready()
        names = [f"stored/http/{shown[0]}%3A{shown[1]}", f"stored/plant/{host}%3A{port}"]
        self.assertEqual(sorted(self.systemd.kept), names)
        self.end(gateway)
        with socket.create_connection(shown, timeout=PATIENCE) as client:
            client.sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
            gateway = self.start_ready(sockets=self.handed_over())
            self.assertRegex(client.recv(4096), rb"^HTTP/1.1 200 OK")
        self.configuration.write_text(text, encoding="utf-8")
        with self.systemd.kept[names[0]][0].dup():
            self.reload(gateway)
            self.assertEqual(list(self.systemd.kept), names[1:])
            with self.assertRaises(ConnectionRefusedError):
                socket.create_connection(shown, timeout=PATIENCE)


class SocketUnits(SystemdCase):
    """What others could reach, without being reached: 192.0.2.1 is no machine's address (RFC 5737)."""

    REFUSED = (
        r'listener "plant": other machines can reach the socket 192\.0\.2\.1:\d+ from systemd: expected \'allow\' with the '
        r'permitted clients, such as allow = \["192\.168\.10\.0/24"\], or a \[\[rule\]\]'
    )

    def open_socket(self, address):
        opened = socket.socket()
        self.addCleanup(opened.close)
        opened.setsockopt(socket.SOL_IP, IP_FREEBIND, 1)
        opened.bind((address, 0))
        opened.listen()
        return [("plant", opened)]

    def test_that_others_reach_are_refused_without_allow(self):
        gateway = self.start(sockets=self.open_socket("192.0.2.1"))
        gateway.wait_for(self.REFUSED)
        self.assertEqual(gateway.wait(), 78)

    def test_that_others_reach_need_allow_or_a_rule(self):
        for access in ({"keys": 'allow = ["192.0.2.0/24"]'}, {"more": '[[rule]]\naction = "permit"'}):
            self.configure(**access)
            self.end(self.start_ready(sockets=self.open_socket("192.0.2.1")))

    def test_of_this_machine_alone_need_neither(self):
        self.start_ready(sockets=self.open_socket("127.0.0.1"))

    def test_that_have_gone_are_forgotten(self):
        self.configure(keys='allow = ["192.0.2.0/24"]')
        gateway = self.start_ready(sockets=self.open_socket("192.0.2.1"))
        text = self.configuration.read_text(encoding="utf-8")
        self.configuration.write_text(text.replace('name = "plant"', 'name = "other"'), encoding="utf-8")
        self.reload(gateway)
        self.configure()
        self.reload(gateway)
        with socket.create_connection(self.address, timeout=PATIENCE) as client:
            client.sendall(READ)
            self.assertEqual(client.recv(64).hex(" "), "00 01 00 00 00 03 01 83 0a")

    def test_that_lose_allow_by_a_reload_keep_it(self):
        self.configure(keys='allow = ["192.0.2.0/24"]')
        gateway = self.start_ready(sockets=self.open_socket("192.0.2.1"))
        self.configure()
        gateway.signal(signal.SIGHUP)
        self.systemd.wait_for("RELOADING")
        self.assertRegex(self.systemd.wait_for("READY")["STATUS"], "^the last reload was refused")
        gateway.wait_for(self.REFUSED)


class Notifications(SystemdCase):
    def test_a_refused_reload_ends_with_ready_and_says_so(self):
        gateway = self.start_ready()
        text = self.configuration.read_text(encoding="utf-8")
        self.configuration.write_text(text.replace("19200", "-1"), encoding="utf-8")
        gateway.signal(signal.SIGHUP)
        begun = self.systemd.wait_for("RELOADING")
        self.assertRegex(begun["MONOTONIC_USEC"], r"^\d+$")
        self.assertLessEqual(int(begun["MONOTONIC_USEC"]), time.monotonic_ns() // 1000)
        ended = self.systemd.wait_for("READY")
        self.assertRegex(ended["STATUS"], "^the last reload was refused, see the journal; ")
        self.end(gateway)
        self.systemd.wait_for("STOPPING")

    # The file is a pipe: what mbgated reads at its start comes when the test says so.
    def test_a_reload_that_is_asked_for_during_the_start_is_done_after_it(self):
        text = self.configuration.read_text(encoding="utf-8")
        self.configuration.unlink()
        os.mkfifo(self.configuration)
        gateway = self.start()
        with self.configuration.open("w", encoding="utf-8") as pipe:  # when mbgated has opened it
            gateway.signal(signal.SIGHUP)
            gateway.signal(signal.SIGUSR1)
            pipe.write(text)
        self.systemd.wait_for("READY")
        self.systemd.wait_for("RELOADING")
        self.configuration.write_text(text + "retries = 3\n", encoding="utf-8")
        self.systemd.wait_for("READY")
        gateway.wait_for("notice: reload: bus line-a: retries 1 -> 3$")


class NotConfigured(SystemdCase):
    """The configuration as the package ships it: nothing but comments."""

    def configure(self, keys="", more=""):
        shipped = (pathlib.Path(__file__).parents[2] / "conf/etc/mbgate.toml").read_text(encoding="utf-8")
        self.configuration.write_text(f'{shipped}\n[http]\nsocket = "{self.folder}/control"\n', encoding="utf-8")

    def test_starts_says_what_is_missing_and_can_be_asked(self):
        gateway = self.start()
        self.assertEqual("no [[bus]] is configured", self.systemd.wait_for("READY")["STATUS"])
        asked = subprocess.run([program("mbgatectl"), "status", "--control", self.folder / "control"],
                               check=False, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(0, asked.returncode, asked.stdout)
        self.assertIn("\nno [[bus]] is configured\n", asked.stdout)
        self.end(gateway)
        for missing in ("bus", "listen"):
            said = [line for line in gateway.unseen() if f"warning: no [[{missing}]] is configured: " in line]
            self.assertEqual(1, len(said), gateway.printed)

    def test_takes_buses_by_a_reload_and_loses_its_last_one_by_none(self):
        gateway = self.start_ready()
        SystemdCase.configure(self)
        self.assertRegex(self.reload(gateway)["STATUS"], "^1 listener, 0 of 1 bus open, ")
        NotConfigured.configure(self)
        self.assertRegex(self.reload(gateway)["STATUS"], "^the last reload was refused, see the journal; ")
        gateway.wait_for(r"error: no \[\[bus\]\] is configured: expected at least one; only a restart removes all buses$")
        self.end(gateway)
        checked = subprocess.run([program("mbgated"), "--check", "--config", self.configuration],
                                 check=False, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(0, checked.returncode, checked.stdout)  # a start with it is possible
        self.assertIn("; a reload that removes all buses is refused\n", checked.stdout)


if __name__ == "__main__":
    unittest.main()
