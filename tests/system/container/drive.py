# SPDX-License-Identifier: Apache-2.0
"""Drives on pseudo-terminals of the container. They share no code with the product, and remember each write."""

import fcntl
import os
import pathlib
import select
import struct
import termios
import threading
import time

TIOCGPTN = 0x80045430
TIOCSPTLCK = 0x40045431


def crc(data):
    value = 0xFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = (value >> 1) ^ 0xA001 if value & 1 else value >> 1
    return struct.pack("<H", value)


class Line(threading.Thread):
    """One pseudo-terminal; every unit on it has registers, and answers function 03 and 06 after some time."""

    def __init__(self, container, link, answer_after):
        super().__init__(daemon=True)
        # Opened by this path it belongs to the container's own instance of devpts.
        self.master = os.open(container.path("/dev/pts/ptmx"), os.O_RDWR | os.O_NOCTTY)
        fcntl.ioctl(self.master, TIOCSPTLCK, struct.pack("i", 0))
        number = struct.unpack("i", fcntl.ioctl(self.master, TIOCGPTN, bytes(4)))[0]
        self.terminal = f"/dev/pts/{number}"
        # One end stays open, so that reading goes on while mbgated is away.
        self.kept = os.open(container.path(self.terminal), os.O_RDWR | os.O_NOCTTY)
        attributes = termios.tcgetattr(self.kept)
        attributes[0] = attributes[1] = attributes[3] = 0
        termios.tcsetattr(self.kept, termios.TCSANOW, attributes)
        path = pathlib.Path(container.path(link))
        path.unlink(missing_ok=True)
        path.symlink_to(self.terminal)
        self.answer_after = answer_after
        self.registers = {}  # (unit, register): value
        self.writes = {}  # (unit, register): values in the order in which they came
        self.unknown = 0  # bytes that were no request
        self.ended = threading.Event()

    def run(self):
        data = b""
        while not self.ended.is_set():
            if not select.select([self.master], [], [], 0.2)[0]:
                self.unknown += len(data)
                data = b""
                continue
            data += os.read(self.master, 256)
            while len(data) >= 8:
                if crc(data[:6]) == data[6:8] and data[1] in (3, 6):
                    self._answer(data[0], data[1], *struct.unpack(">HH", data[2:6]))
                    data = data[8:]
                else:
                    self.unknown += 1
                    data = data[1:]

    def end(self):
        self.ended.set()
        self.join()
        os.close(self.kept)
        os.close(self.master)

    def _answer(self, unit, function, register, value):
        if function == 6:
            self.registers[(unit, register)] = value
            self.writes.setdefault((unit, register), []).append(value)
            body = struct.pack(">BBHH", unit, 6, register, value)
        else:
            values = [self.registers.get((unit, register + i), 0) for i in range(value)]
            body = struct.pack(f">BBB{value}H", unit, 3, 2 * value, *values)
        time.sleep(self.answer_after)
        os.write(self.master, body + crc(body))
