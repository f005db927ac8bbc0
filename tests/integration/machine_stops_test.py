#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What the gateway waits for does not come: the process is stopped, or nobody says which address a name has. Nothing is
sent late, other buses go on, and it goes on by itself. `--stopped 10`: it is stopped for so many seconds."""

import contextlib
import signal
import socket
import socketserver
import subprocess
import sys
import threading
import time
import unittest

from demo_plant import PATIENCE
from fault_plant import BUSY, DEAF, NO_ANSWER, NO_PATH, WRITE, FaultCase, answer_pdu, exception, read_of, write_of

ARGUMENTS = dict(zip(sys.argv[1::2], sys.argv[2::2], strict=False))
STOPPED = float(ARGUMENTS.get("--stopped", 3))
REFUSED = exception(WRITE, BUSY)

NAME = "drive.mbgate.test"
NAME_SERVER = "127.83.71.1"
FAR = 2  # the unit behind the name
# Nobody else's names are asked, and each question waits for its answer longer than any test.
RESOLVER = f"nameserver {NAME_SERVER}\noptions timeout:30 attempts:2\n"
WITH_RESOLVER = 'mount --bind "$0" /etc/resolv.conf && mount --bind "$1" /etc/nsswitch.conf && shift && exec "$@"'


class NameServer:
    """Hears questions, and answers them when release() is called, and from then on: every name is 127.0.0.1."""

    def __init__(self):
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind((NAME_SERVER, 53))
        self._socket.settimeout(0.1)
        self.asked = threading.Event()
        self._released = threading.Event()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def release(self):
        self._released.set()

    def _serve(self):
        waiting = []
        while not self._ended.is_set():
            with contextlib.suppress(TimeoutError):
                waiting.append(self._socket.recvfrom(512))
                self.asked.set()
            while self._released.is_set() and waiting:
                question, peer = waiting.pop()
                self._socket.sendto(self._answer(question), peer)

    @staticmethod
    def _answer(question):
        name_end = question.index(b"\0", 12) + 1
        asked = question[12 : name_end + 4]
        is_v4 = asked[-4:-2] == b"\0\1"
        address = b"\xc0\x0c\0\1\0\1\0\0\0\x3c\0\4" + socket.inet_aton("127.0.0.1") if is_v4 else b""
        return question[:2] + b"\x81\x80\0\1" + (b"\0\1" if is_v4 else b"\0\0") + bytes(4) + asked + address

    def end(self):
        self._ended.set()
        self._thread.join()
        self._socket.close()


class FarDrive(socketserver.BaseRequestHandler):
    """A Modbus TCP server with the same registers."""

    def handle(self):
        while head := self.request.recv(7, socket.MSG_WAITALL):
            pdu = self.request.recv(int.from_bytes(head[4:6], "big") - 1, socket.MSG_WAITALL)
            answer = answer_pdu(pdu)
            self.request.sendall(head[:4] + (len(answer) + 1).to_bytes(2, "big") + head[6:] + answer)


class FarServer(socketserver.ThreadingTCPServer):
    allow_reuse_address = True
    daemon_threads = True
    block_on_close = False


class MachineStops(FaultCase):
    def test_nothing_is_sent_late_by_a_process_that_was_stopped(self):
        line = self.line(route='deadline = "1s"')
        self.start()
        reader = self.reader()
        on_wire, waiting, old = self.client(), self.client(), self.client()
        self.assertEqual(old.write(1), write_of(1))
        reader.end()  # the line is free for what follows
        on_wire.send(write_of(2), DEAF)
        self.assertTrue(line.heard.wait(PATIENCE))
        waiting.send(write_of(3))
        self.gateway.signal(signal.SIGSTOP)
        try:
            old.send(write_of(4))  # on a connection that was there
            fresh = self.client()  # the kernel lets it in
            fresh.send(write_of(5))
            time.sleep(STOPPED)
        finally:
            self.gateway.signal(signal.SIGCONT)
        self.assertEqual(on_wire.receive(), exception(WRITE, NO_ANSWER))
        self.assertEqual([client.receive() for client in (waiting, old, fresh)], [REFUSED] * 3)
        again = self.reader()
        self.assert_serves(again, old)
        self.assert_serves(again, fresh)
        self.assertEqual([value for value in line.writes if value != 0x77], [1, 2])
        self.assertEqual(len(self.lines("warning: the gateway did not run for")), 1, self.gateway.printed)

    def resolver(self):
        """A command before another one, which asks our name server then; that one."""
        for name, text in (("resolv.conf", RESOLVER), ("nsswitch.conf", "hosts: dns\n")):
            (self.folder / name).write_text(text, encoding="utf-8")
        files = [str(self.folder / name) for name in ("resolv.conf", "nsswitch.conf")]
        within = ["unshare", "--mount", "sh", "-c", WITH_RESOLVER, *files]
        if subprocess.run([*within, "true"], stderr=subprocess.DEVNULL, check=False).returncode != 0:
            self.skipTest("no mount namespace of our own")
        try:
            server = NameServer()
        except OSError as error:
            self.skipTest(f"port 53: {error}")
        self.addCleanup(server.end)
        return within, server

    def start_with_name(self):
        self.far = FarServer(("127.0.0.1", 0), FarDrive)
        self.addCleanup(self.far.server_close)
        thread = threading.Thread(target=self.far.serve_forever)
        thread.start()
        self.addCleanup(thread.join)
        self.addCleanup(self.far.shutdown)
        cell = f'[[bus]]\nname = "cell"\nmode = "tcp"\nhost = "{NAME}"\nport = {self.far.server_address[1]}\n'
        cell += 'connect_timeout = "500ms"\n'
        self.line(keys=f'{cell}[[route]]\nunit = {FAR}\nbus = "cell"\naddress = {FAR}\n')
        within, names = self.resolver()
        self.start(wrapped=within)
        self.assertTrue(names.asked.wait(PATIENCE))
        return names

    def test_a_resolver_that_hangs_delays_nobody_else(self):
        names = self.start_with_name()
        reader = self.reader()
        far = self.client()
        self.assertEqual(far.ask(read_of(5), FAR), exception(3, NO_PATH))
        self.assertEqual(self.ask("GET", "/healthz")[0], 200)
        self.assertEqual(self.ask("POST", "/api/v1/reload")[0], 200)
        self.assertEqual(far.ask(read_of(5), FAR), exception(3, NO_PATH))
        self.assert_serves(reader, self.client())
        told = f"tcp://{NAME}:{self.far.server_address[1]}: no name server has answered in time"
        self.assertEqual(len(self.lines(told)), 1, self.gateway.printed)  # though it is tried again and again
        names.release()
        self.gateway.wait_for("bus cell is open$")
        self.assertEqual(far.ask(read_of(5), FAR), answer_pdu(read_of(5)))
        self.assert_serves(reader, self.client())

    def test_a_resolver_that_hangs_does_not_keep_the_process(self):
        self.start_with_name()
        began = time.monotonic()
        self.assertEqual(self.gateway.end(), 0)
        self.assertLess(time.monotonic() - began, PATIENCE / 2)  # the question waits for 30 s, twice


if __name__ == "__main__":
    sys.exit(unittest.main(argv=sys.argv[:1]))
