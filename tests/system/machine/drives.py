# SPDX-License-Identifier: Apache-2.0
"""A line with drives on it: Modbus RTU of its own, which owes the gateway nothing."""

import threading

from ftdi import now

READ_HOLDING, READ_INPUT, WRITE_ONE, WRITE_MANY = 3, 4, 6, 16
ILLEGAL_FUNCTION, ILLEGAL_ADDRESS = 1, 2
REGISTERS = 100
THINKS = 0.005  # seconds from a request to its answer
FORGETS = 0.5  # seconds after which a part of a request is none any more


def checksum(data):
    """Modbus over serial line V1.02, 6.2.2, bit by bit."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc >> 1) ^ (0xA001 if crc & 1 else 0)
    return bytes([crc & 0xFF, crc >> 8])


def size_of(request):
    """How long the request is that begins so; 0 if that cannot be said yet."""
    if len(request) < 2 or (request[1] == WRITE_MANY and len(request) < 7):
        return 0
    return 9 + request[6] if request[1] == WRITE_MANY else 8


class Line:
    """Drives of these addresses, which hear only what is sent with their own settings, such as "19200 8E1"."""

    def __init__(self, settings, addresses):
        self.settings = settings
        self.registers = {address: [0] * REGISTERS for address in addresses}
        self.silent = set()  # drives that do not answer
        self.hurt = 0  # in so many answers one bit of the fourth byte is wrong, and so its parity
        self.heard = []  # requests, as they were on the wire, without the checksum
        self.noise = 0  # bytes that were not heard, because the settings differ
        self._part, self._last = b"", 0.0
        self._changed = threading.Condition()

    def hear(self, chip, data):
        """Bytes have left the adapter. Runs in the thread of the adapters, as all of it but wait_for() does."""
        if not chip.fits(self.settings):
            self.noise += len(data)
            return
        if now() - self._last > FORGETS:
            self._part = b""
        self._part, self._last = self._part + data, now()
        while size_of(self._part) and len(self._part) >= size_of(self._part):
            size = size_of(self._part)
            request, self._part = self._part[:size], self._part[size:]
            if checksum(request[:-2]) != request[-2:]:
                self._part = b""
                return
            self._take(chip, request[:-2])

    def _take(self, chip, request):
        with self._changed:
            self.heard.append(request)
            self._changed.notify_all()
        address = request[0]
        if address not in self.registers or address in self.silent:
            return
        body = bytes([address]) + self._obey(self.registers[address], request[1:])
        answer, hurt = body + checksum(body), ()
        if self.hurt > 0:
            self.hurt -= 1
            answer, hurt = answer[:3] + bytes([answer[3] ^ 0x10]) + answer[4:], (3,)
        chip.receive(answer, now() + THINKS, hurt)

    @staticmethod
    def _obey(registers, pdu):
        function = pdu[0]
        if function not in (READ_HOLDING, READ_INPUT, WRITE_ONE, WRITE_MANY):
            return bytes([function | 0x80, ILLEGAL_FUNCTION])
        first, second = int.from_bytes(pdu[1:3], "big"), int.from_bytes(pdu[3:5], "big")
        if first + (1 if function == WRITE_ONE else second) > REGISTERS:
            return bytes([function | 0x80, ILLEGAL_ADDRESS])
        if function == WRITE_ONE:
            registers[first] = second
            return pdu
        if function == WRITE_MANY:
            for place in range(second):
                registers[first + place] = int.from_bytes(pdu[6 + 2 * place:8 + 2 * place], "big")
            return pdu[:5]
        data = b"".join(value.to_bytes(2, "big") for value in registers[first:first + second])
        return bytes([function, len(data)]) + data

    def count(self, begin):
        """How many requests were heard that begin with these bytes."""
        return sum(request.startswith(begin) for request in list(self.heard))

    def wait_for(self, begin, more_than=0, patience=60):
        """Until more than so many requests that begin with these bytes were heard."""
        with self._changed:
            if not self._changed.wait_for(lambda: self.count(begin) > more_than, patience):
                raise RuntimeError(f"no request {begin.hex()} came to the drives within {patience} s")
