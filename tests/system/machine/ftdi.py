# SPDX-License-Identifier: Apache-2.0
"""An FT232R as far as the driver can tell: rate, frame format, latency timer, errors of received characters; bytes
leave and come at the pace of the wire."""

import asyncio

from usbip import Socket

DEVICE = bytes([18, 1, 0, 2, 0, 0, 0, 8, 0x03, 0x04, 0x01, 0x60, 0x00, 0x06, 1, 2, 3, 1])
CONFIGURATION = (bytes([9, 2, 32, 0, 1, 1, 0, 0xA0, 45, 9, 4, 0, 0, 2, 0xFF, 0xFF, 0xFF, 2])
                 + bytes([7, 5, 0x81, 2, 64, 0, 0, 7, 5, 0x02, 2, 64, 0, 0]))
CLOCK = 3_000_000
EIGHTHS = (0, 4, 2, 1, 3, 5, 6, 7)  # what the three bits behind the divisor add to it
PAYLOAD = 62  # of a packet, behind two bytes of status
MODEM_STATUS, TRANSMITTER_EMPTY, PARITY_ERROR = 0x31, 0x60, 0x04
READ, WRITE = 0xC0, 0x40
PURGE_RECEIVED, PURGE_TO_SEND = 1, 2


def rate_of(value, index):
    """Bits a second, by the request that sets the divisor."""
    divisor = value & 0x3FFF
    if divisor < 2:
        return CLOCK if divisor == 0 else 2_000_000
    return round(CLOCK * 8 / (divisor * 8 + EIGHTHS[value >> 14 | (index & 1) << 2]))


class Chip:
    """One adapter. `line` hears what it sends: line.hear(chip, data). With `echo` it hears itself, as a transceiver
    does whose receiver stays on."""

    def __init__(self, serial, line):
        self.serial, self._line = serial, line
        self.echo = False
        self.plugged = None
        self._power_up()

    def _power_up(self):
        self.rate, self.bits, self.parity, self.stop, self.latency = 9600, 8, "N", "1", 16
        self.latencies = []  # that the driver has set, since it was plugged in
        self._received = []  # (when, byte, status)
        self._leaves = 0.0  # when the last byte that it was given has left
        self._timers = []

    @property
    def settings(self):
        """Such as 19200 8E1; the rate is the one that the divisor makes."""
        return f"{self.rate} {self.bits}{self.parity}{self.stop}"

    def fits(self, settings):
        """A receiver with these settings hears what it sends: the format is the same, the rate within 2 %."""
        rate, form = settings.split()
        return self.settings.split()[1] == form and abs(self.rate - int(rate)) <= 0.02 * int(rate)

    def _character(self):
        return (1 + self.bits + (self.parity != "N") + float(self.stop)) / self.rate

    async def plug(self, reader, writer):
        """The life of the adapter from plugging in to pulling out."""
        self._power_up()
        self.plugged = Socket(self, reader, writer)
        await self.plugged.serve()
        self.plugged = None
        for timer in self._timers:
            timer.cancel()

    # --- what the driver asks -------------------------------------------------------------------------------

    def control(self, setup, _):
        kind, request, value, index = setup[0], setup[1], setup[2] | setup[3] << 8, setup[4] | setup[5] << 8
        if kind == 0x80:
            return self._standard(request, value)
        if kind == READ:
            answers = {5: bytes([MODEM_STATUS, self._status()]), 10: bytes([self.latency])}
            return answers.get(request, b"\xff\xff")
        if kind == WRITE:
            self._set(request, value, index)
        return b""

    def _standard(self, request, value):
        if request != 6:
            return b"\1\0"
        kind, number = value >> 8, value & 0xFF
        if kind == 3:
            text = ["\u0409", "FTDI", "FT232R USB UART", self.serial][number].encode("utf-16-le")
            return bytes([len(text) + 2, 3]) + text
        return {1: DEVICE, 2: CONFIGURATION}.get(kind)

    def _set(self, request, value, index):
        if request == 0 and value == PURGE_RECEIVED:
            self._received.clear()
        elif request == 3:
            self.rate = rate_of(value, index)
        elif request == 4:
            self.bits, self.parity = value & 0xFF, "NOEMS"[value >> 8 & 7]
            self.stop = ("1", "1.5", "2")[value >> 11 & 3]
        elif request == 9:
            self.latency = value
            self.latencies.append(value)

    def _status(self):
        return TRANSMITTER_EMPTY if self._leaves <= now() else 0

    # --- the wire -------------------------------------------------------------------------------------------

    def sent(self, data):
        """The driver gave these bytes; they leave one after the other."""
        begin = max(now(), self._leaves)
        self._leaves = begin + len(data) * self._character()
        self._later(self._leaves, self._line.hear, self, data)
        if self.echo:
            self.receive(data, begin)

    def receive(self, data, begin, hurt=()):
        """Bytes come in, the first one from `begin` on. Those at the places `hurt` have a wrong parity."""
        for place, byte in enumerate(data):
            status = PARITY_ERROR if place in hurt else 0
            self._received.append((begin + (place + 1) * self._character(), byte, status))
        self._received.sort(key=lambda each: each[0])
        self.wanted()

    def wanted(self):
        """Something may be to give: a full packet as soon as it is there, else when the latency timer is over."""
        if not self._received:
            return
        first = self._received[0][0]
        full = self._received[PAYLOAD - 1][0] if len(self._received) >= PAYLOAD else first + self.latency / 1000
        self._later(min(full, first + self.latency / 1000), self._give)

    def _give(self):
        if self.plugged is None or not self.plugged.is_asked():
            return
        arrived = [each for each in self._received[:PAYLOAD] if each[0] <= now()]
        if not arrived:
            return
        # The status belongs to a whole packet, so a hurt byte goes alone.
        sound = next((place for place, each in enumerate(arrived) if each[2]), len(arrived))
        packet = arrived[:sound or 1]
        del self._received[:len(packet)]
        status = self._status() | packet[0][2]
        self.plugged.give(bytes([MODEM_STATUS, status, *(byte for _, byte, _ in packet)]))
        self.wanted()

    def _later(self, when, action, *arguments):
        self._timers = [timer for timer in self._timers if timer.when() > now() and not timer.cancelled()]
        self._timers.append(asyncio.get_running_loop().call_at(when, action, *arguments))


def now():
    return asyncio.get_running_loop().time()
