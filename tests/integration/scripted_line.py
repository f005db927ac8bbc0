# SPDX-License-Identifier: Apache-2.0
"""A pty with whatever a test wants on it instead of drives: what it hears are requests, what it says is the test's."""

import os
import pty
import select
import threading
import tty


def crc_of(frame):
    crc = 0xFFFF
    for byte in frame:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ 0xA001 if crc & 1 else crc >> 1
    return crc.to_bytes(2, "little")


def framed(address_and_pdu):
    return address_and_pdu + crc_of(address_and_pdu)


def answer_to(request, value=0x1234):
    """The answer to a read: every register has this value. A write of one register is repeated."""
    if request[1] not in (3, 4):
        return request
    count = int.from_bytes(request[4:6], "big")
    return framed(request[:2] + bytes([2 * count]) + value.to_bytes(2, "big") * count)


def length_of(request):
    """How long the request is whose beginning this is."""
    if request[1:2] not in (b"\x0f", b"\x10"):
        return 8
    return 9 + request[6] if len(request) > 6 else 9


class ScriptedLine:
    """with ScriptedLine(on_request) as line: line.path is the port; `on_request(line, request)` runs for each request
    (01 to 06, 15, 16), and says what it wants with line.say(). It runs a little later, because nothing answers before the
    request would have left a wire."""

    EMISSION = 0.005  # more than eight characters take at 115200 baud

    def __init__(self, on_request):
        self._on_request = on_request

    def __enter__(self):
        self._ours, self._theirs = pty.openpty()
        tty.setraw(self._theirs)
        self.path = os.ttyname(self._theirs)
        self.ended = threading.Event()
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()
        return self

    def say(self, data):
        os.write(self._ours, data)

    def _serve(self):
        heard = b""
        while not self.ended.is_set():
            if not select.select([self._ours], [], [], 0.05)[0]:
                continue
            heard += os.read(self._ours, 4096)
            while heard and len(heard) >= length_of(heard):
                request, heard = heard[:length_of(heard)], heard[length_of(heard):]
                self.ended.wait(self.EMISSION)
                self._on_request(self, request)

    def __exit__(self, *_):
        self.ended.set()
        self._thread.join()
        os.close(self._ours)
        os.close(self._theirs)
