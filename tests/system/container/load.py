# SPDX-License-Identifier: Apache-2.0
"""A client that writes its own register and reads it back without end, and judges every answer."""

import threading
import time

import modbus

RECONNECT = 0.02  # seconds between two tries to connect


class Worker(threading.Thread):
    """Writes 1, 2, 3 …, each value once; after each write it reads. What became of each value is kept."""

    def __init__(self, port, unit, register):
        super().__init__(daemon=True)
        self.port, self.unit, self.register = port, unit, register
        self.ended = threading.Event()
        self.client = None
        self.good = []  # when good answers came
        self.done, self.refused, self.unknown, self.lost = [], [], [], []  # values: answered, 06, 0B, connection gone
        self.possible = {0}  # what the register may hold now
        self.wrong = []  # what must not be
        self.codes = {}  # exceptions, and how many
        self.connection_refused = 0

    def run(self):
        value = 0
        while not self.ended.is_set():
            if not self.client and not self._connect():
                continue
            value += 1
            if self._write(value):
                self._read()
        if self.client:
            self.client.close()

    def end(self):
        self.ended.set()
        self.join(2 * modbus.PATIENCE)

    def _connect(self):
        try:
            self.client = modbus.Client(self.port)
            return True
        except ConnectionRefusedError:
            self.connection_refused += 1
        except OSError:
            pass
        self.ended.wait(RECONNECT)
        return False

    def _write(self, value):
        """Whether the connection is there still."""
        try:
            self.client.write(self.unit, self.register, value)
        except modbus.Refused as refused:
            self._count(refused.code)
            if refused.code == 0x0B:
                self.unknown.append(value)
                self.possible.add(value)
            elif refused.code == 0x06:
                self.refused.append(value)
            else:
                self.wrong.append(f"write {value}: {refused}")
            return True
        except (OSError, ValueError) as problem:
            self.lost.append(value)
            self.possible.add(value)
            return self._gone(problem)
        self.good.append(time.monotonic())
        self.done.append(value)
        self.possible = {value}
        return True

    def _read(self):
        try:
            (value,) = self.client.read(self.unit, self.register)
        except modbus.Refused as refused:
            self._count(refused.code)
            if refused.code not in (0x06, 0x0B):
                self.wrong.append(f"read: {refused}")
            return
        except (OSError, ValueError) as problem:
            self._gone(problem)
            return
        self.good.append(time.monotonic())
        if value not in self.possible:
            self.wrong.append(f"read {value}, not {sorted(self.possible)}")
        self.possible = {value}

    def _gone(self, problem):
        if isinstance(problem, (ValueError, TimeoutError)):
            self.wrong.append(repr(problem))
        self.client.close()
        self.client = None
        return False

    def _count(self, code):
        self.codes[code] = self.codes.get(code, 0) + 1
