# SPDX-License-Identifier: Apache-2.0
"""A Modbus TCP client of few lines, and one that polls without end in a thread."""

import socket
import struct
import threading
import time

PATIENCE = 15.0


class Refused(Exception):
    """An answer with an exception code."""

    def __init__(self, code):
        super().__init__(f"exception {code:02X}")
        self.code = code


class Client:
    def __init__(self, port, address="127.0.0.1", patience=PATIENCE):
        self.socket = socket.create_connection((address, port), patience)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.identifier = 0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self.socket.close()

    def ask(self, unit, pdu):
        self.identifier = (self.identifier + 1) & 0xFFFF
        self.socket.sendall(struct.pack(">HHHB", self.identifier, 0, len(pdu) + 1, unit) + pdu)
        identifier, _, length, from_unit = struct.unpack(">HHHB", self._receive(7))
        answer = self._receive(length - 1)
        if (identifier, from_unit) != (self.identifier, unit):
            raise ValueError(f"answer {identifier} of unit {from_unit} to request {self.identifier} of unit {unit}")
        if answer[0] == pdu[0] | 0x80:
            raise Refused(answer[1])
        return answer

    def read(self, unit, register, count=1):
        """The values of holding registers."""
        answer = self.ask(unit, struct.pack(">BHH", 3, register, count))
        if len(answer) != 2 + 2 * count or answer[:2] != bytes((3, 2 * count)):
            raise ValueError(f"answer to a read of {count}: {answer.hex()}")
        return struct.unpack(f">{count}H", answer[2:])

    def write(self, unit, register, value):
        """One register by function 06, whose answer is the request."""
        request = struct.pack(">BHH", 6, register, value)
        answer = self.ask(unit, request)
        if answer != request:
            raise ValueError(f"answer to {request.hex()}: {answer.hex()}")

    def _receive(self, count):
        data = b""
        while len(data) < count:
            more = self.socket.recv(count - len(data))
            if not more:
                raise ConnectionError("closed")
            data += more
        return data


def read_once(port, unit, register, count=1, **options):
    with Client(port, **options) as client:
        return client.read(unit, register, count)


class Poller(threading.Thread):
    """Reads a register again and again, as a PLC does: connects anew whenever its connection is lost."""

    def __init__(self, port, unit, register, pause=0.01):
        super().__init__(daemon=True)
        self.what = (port, unit, register, pause)
        self.ended = threading.Event()
        self.served = []  # when answers came
        self.refused = []  # when nobody listened
        self.lost = 0
        self.codes = []

    def run(self):
        port, unit, register, pause = self.what
        client = None
        while not self.ended.is_set():
            try:
                client = client or Client(port)
                client.read(unit, register)
                self.served.append(time.monotonic())
            except Refused as refused:
                self.codes.append(refused.code)
            except ConnectionRefusedError:
                self.refused.append(time.monotonic())
            except OSError:
                self.lost += 1
                if client:
                    client.close()
                client = None
            self.ended.wait(pause)
        if client:
            client.close()

    def end(self):
        self.ended.set()
        self.join(2 * PATIENCE)

    def served_since(self, instant):
        return sum(1 for it in self.served if it > instant)

    def __str__(self):
        return f"{len(self.served)} answers, {len(self.refused)} times refused, {self.lost} times lost"
