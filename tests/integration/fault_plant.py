# SPDX-License-Identifier: Apache-2.0
"""A gateway of one line that a test can do ill to, and who sees what becomes of it: a line that notes every request, a
client that holds every answer to what the drive has, and the journal."""

import json
import pathlib
import socket
import tempfile
import threading
import time
import unittest

from control_case import UnixConnection
from demo_plant import PATIENCE, Process, program
from scripted_line import ScriptedLine, framed

DRIVE = 1  # its unit
DEAF = 9  # the unit of one that never answers
BUSY, NO_PATH, NO_ANSWER = 0x06, 0x0A, 0x0B
WRITE = 6
COUNT = 8  # registers of a read


def is_sanitized():
    """Is mbgated built with AddressSanitizer, whose memory is not that of the product?"""
    return b"__asan_init" in pathlib.Path(program("mbgated")).read_bytes()


def registers(first, count):
    """Every register has its own number as its value."""
    return b"".join((first + at & 0xFFFF).to_bytes(2, "big") for at in range(count))


def answer_pdu(pdu):
    """What the drive says: writes are repeated."""
    if pdu[0] != 3:
        return pdu
    count = int.from_bytes(pdu[3:5], "big")
    return bytes([3, 2 * count]) + registers(int.from_bytes(pdu[1:3], "big"), count)


class NotedLine(ScriptedLine):
    """A line with a drive, and one that is deaf. `writes` are the values that were written, in their order."""

    def __init__(self):
        super().__init__(NotedLine._answer)
        self.writes = []
        self.heard = threading.Event()  # a write to the deaf one

    def _answer(self, request):
        unit, pdu = request[0], request[1:-2]
        if pdu[0] == WRITE:
            self.writes.append(int.from_bytes(pdu[3:5], "big"))
        if unit == DEAF:
            self.heard.set()
        else:
            self.say(framed(bytes([unit]) + answer_pdu(pdu)))


class Client:
    """A connection of a Modbus TCP client."""

    def __init__(self, port, address="127.0.0.1", patience=PATIENCE):
        self._socket = socket.create_connection(("127.0.0.1", port), patience, (address, 0))
        self._sent = 0

    def send(self, pdu, unit=DRIVE):
        self._sent = self._sent + 1 & 0xFFFF
        head = self._sent.to_bytes(2, "big") + bytes(2) + (len(pdu) + 1).to_bytes(2, "big")
        self._socket.sendall(head + bytes([unit]) + pdu)

    def receive(self):
        """The PDU of the next answer; nothing: the connection has ended."""
        return self.receive_numbered()[1]

    def receive_numbered(self):
        """The transaction identifier too."""
        head = self._take(7)
        return int.from_bytes(head[:2], "big"), head and self._take(int.from_bytes(head[4:6], "big") - 1)

    def ask(self, pdu, unit=DRIVE):
        self.send(pdu, unit)
        return self.receive()

    def write(self, value, unit=DRIVE):
        return self.ask(write_of(value), unit)

    def close(self):
        self._socket.close()

    def _take(self, size):
        got = b""
        while len(got) < size:
            more = self._socket.recv(size - len(got))
            if not more:
                return b""
            got += more
        return got


def registers_of(first, *values):
    head = b"\x10" + first.to_bytes(2, "big") + len(values).to_bytes(2, "big") + bytes([2 * len(values)])
    return head + b"".join(value.to_bytes(2, "big") for value in values)


def write_of(value):
    return bytes([WRITE, 0, 0]) + value.to_bytes(2, "big")


def read_of(first):
    return b"\x03" + first.to_bytes(2, "big") + COUNT.to_bytes(2, "big")


def exception(function, code):
    return bytes([function | 0x80, code])


class Reader:
    """Reads without end, on a connection of its own, and holds every answer to what the drive has."""

    def __init__(self, port):
        self.right = 0
        self.refused = []  # exception codes
        self.wrong = []
        self._client = Client(port)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._read)
        self._thread.start()

    def _read(self):
        first = 0
        while not self._ended.is_set():
            first = first + 7 & 0x3FFF
            answer = self._client.ask(read_of(first))
            if answer == answer_pdu(read_of(first)):
                self.right += 1
            elif answer[:1] == b"\x83":
                self.refused.append(answer[1])
                self._ended.wait(0.01)  # refused at once, again and again, it would keep the drive's thread from answering
            else:
                self.wrong.append((first, answer.hex(" ")))
                return

    def wait_for_answers(self, count=10):
        """So many more right ones."""
        wanted = self.right + count
        limit = time.monotonic() + PATIENCE
        while self.right < wanted:
            assert not self.wrong, f"wrong answers: {self.wrong}"
            assert time.monotonic() < limit, f"no answers any more, but {self.right} before, refused: {self.refused}"
            time.sleep(0.01)

    def end(self):
        self._ended.set()
        self._thread.join()
        self._client.close()


class FaultCase(unittest.TestCase):
    """A gateway with one line, and what else a test adds to its configuration."""

    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.control = self.folder / "control"
        self.configuration = self.folder / "mbgate.toml"

    def configure(self, device, more="", keys="", route=""):
        text = f'[http]\nsocket = "{self.control}"\n'
        text += f'[[listen]]\nname = "plant"\naddress = "127.0.0.1"\nport = 0\nmax_connections = 2001\nmax_connections_per_address = 2000\nmax_connects_per_second = 0\nmax_requests_per_second = 0\n{more}\n'
        text += f'[[bus]]\nname = "line-a"\ndevice = "{device}"\nbaud = 115200\nparity = "none"\ncoalesce = false\n'
        text += "" if "echo" in keys else "echo = false\n"
        text += f'response_timeout = "2s"\nlisten_first = "0ms"\n{keys}\n'
        for unit in (DRIVE, DEAF):
            text += f'[[route]]\nunit = {unit}\nbus = "line-a"\naddress = {unit}\n{route}\n'
        self.configuration.write_text(text, encoding="utf-8")

    def line(self, **keys):
        line = self.enterContext(NotedLine())
        self.configure(line.path, **keys)
        return line

    def start(self, *arguments, **how):
        self.gateway = Process(self.folder, "mbgated", "--config", self.configuration, *arguments, **how)
        self.addCleanup(self.gateway.end)
        self.port = int(self.gateway.wait_for(r"listening plant 127\.0\.0\.1:(\d+)$").group(1))

    def reader(self):
        reader = Reader(self.port)
        self.addCleanup(reader.end)
        reader.wait_for_answers()
        return reader

    def client(self):
        client = Client(self.port)
        self.addCleanup(client.close)
        return client

    def ask(self, method, path, connection=None):
        """The HTTP status and the JSON."""
        own = connection or UnixConnection(self.control)
        own.request(method, path)
        answer = own.getresponse()
        body = json.loads(answer.read())
        if not connection:
            own.close()
        return answer.status, body

    def lines(self, part):
        """What the journal has of it."""
        return [line for line in self.gateway.unseen() if part in line]

    def assert_serves(self, reader, client):
        """What was asked meanwhile was answered right, and so is what is asked now."""
        reader.wait_for_answers()
        self.assertEqual(reader.wrong, [])
        limit = time.monotonic() + PATIENCE
        while client.write(0x77) != write_of(0x77):  # a busy machine may refuse it
            self.assertLess(time.monotonic(), limit, "no write is taken any more")
