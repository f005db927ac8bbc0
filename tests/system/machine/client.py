# SPDX-License-Identifier: Apache-2.0
"""A Modbus TCP client of its own."""

import itertools
import socket
import threading
import time

PATIENCE = 120  # seconds; only ends what hangs


class Client:
    """Requests are PDUs: client.ask(unit, pdu), or send() and later answer()."""

    def __init__(self, port):
        self._socket = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE)
        self._numbers = itertools.count(1)
        self._answers = {}

    def send(self, unit, pdu):
        number = next(self._numbers) & 0xFFFF
        size = (len(pdu) + 1).to_bytes(2, "big")
        self._socket.sendall(number.to_bytes(2, "big") + b"\0\0" + size + bytes([unit]) + pdu)
        return number

    def answer(self, number, patience=PATIENCE):
        """The PDU of the answer; None if none has come in time."""
        end = time.monotonic() + patience
        while number not in self._answers:
            left = end - time.monotonic()
            if left <= 0:
                return None
            self._socket.settimeout(left)
            try:
                header = self._receive(7, peek_first=True)
            except TimeoutError:
                return None
            self._socket.settimeout(PATIENCE)
            got, size = int.from_bytes(header[:2], "big"), int.from_bytes(header[4:6], "big")
            self._answers[got] = self._receive(size - 1)
        return self._answers.pop(number)

    def _receive(self, size, peek_first=False):
        if peek_first:  # an impatient caller must not lose a part of the header
            self._socket.recv(1, socket.MSG_PEEK)
            self._socket.settimeout(PATIENCE)
        received = b""
        while len(received) < size:
            more = self._socket.recv(size - len(received))
            if not more:
                raise ConnectionError("the gateway closed the connection")
            received += more
        return received

    def ask(self, unit, pdu):
        return self.answer(self.send(unit, pdu))

    def close(self):
        self._socket.close()


def read(register, count=1):
    return b"\x03" + register.to_bytes(2, "big") + count.to_bytes(2, "big")


def write(register, value):
    return b"\x06" + register.to_bytes(2, "big") + value.to_bytes(2, "big")


def told(pdu):
    """An answer in the words of a line: 0B for an exception, the PDU in hexadecimal else."""
    if pdu is None:
        return "nothing"
    return f"{pdu[1]:02X}" if pdu[0] & 0x80 else pdu.hex()


class Poller:
    """with Poller(port, unit) as poller: reads one register again and again, and notes what is not `value`."""

    def __init__(self, port, unit, register, value):
        self._client = Client(port)
        self._unit, self._register, self._expected = unit, register, b"\x03\x02" + value.to_bytes(2, "big")
        self.right, self.wrong = 0, []
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._poll, daemon=True)

    def _poll(self):
        while not self._ended.is_set():
            try:
                answer = self._client.ask(self._unit, read(self._register))
            except OSError as error:
                self.wrong.append(str(error))
                return
            if answer == self._expected:
                self.right += 1
            else:
                self.wrong.append(told(answer))

    def more(self, count=5, patience=PATIENCE):
        """Waits for so many more right answers; False if they do not come."""
        end, goal = time.monotonic() + patience, self.right + count
        while self.right < goal and time.monotonic() < end:
            time.sleep(0.05)
        return self.right >= goal

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._ended.set()
        self._thread.join(PATIENCE)
        self._client.close()
