# SPDX-License-Identifier: Apache-2.0
"""Drives that do what drives should not, on ptys and on a socket, and clients that ask them and judge what they get."""

import collections
import os
import pty
import queue
import random
import select
import threading
import time
import tty

from fault_plant import Client, registers_of
from scripted_line import framed, length_of

READ, WRITE, WRITE_MULTIPLE = 3, 6, 16
BUSY = 6


def take_request(heard):
    """The first request among the bytes, or nothing, and the rest."""
    size = length_of(heard)
    return (heard[:size], heard[size:]) if len(heard) >= size else (None, heard)


class Drive:
    """Registers that hold their own address. `done`: its writes in order. `service` and `second` give random times, in
    which it answers a request, and a second time."""

    def __init__(self, service, second=None):
        self.service = service
        self.second = second
        self.done = []
        self.asked = threading.Event()

    def count(self, pdu):
        return self.done.count(pdu)

    def serve(self, pdu):
        """Its answer, after the time that it takes."""
        self.asked.set()
        time.sleep(self.service(pdu))
        return self.answer(pdu)

    def answer(self, pdu):
        """Nothing: it says nothing."""
        if pdu[0] == READ:
            first, count = int.from_bytes(pdu[1:3], "big"), int.from_bytes(pdu[3:5], "big")
            return bytes([READ, 2 * count]) + b"".join((first + at).to_bytes(2, "big") for at in range(count))
        self.done.append(bytes(pdu))
        return pdu[:5]


class LimitingDrive(Drive):
    """Echoes a set-point that it has limited."""

    def answer(self, pdu):
        answer = super().answer(pdu)
        return answer if pdu[0] != WRITE else pdu[:3] + min(int.from_bytes(pdu[3:5], "big"), 1000).to_bytes(2, "big")


class RefusingDrive(Drive):
    """Is too busy for half of the stops."""

    def answer(self, pdu):
        is_refused = not any(pdu[6:]) and pdu[0] != READ and random.random() < 0.5
        return bytes([pdu[0] | 0x80, BUSY]) if is_refused else super().answer(pdu)


class LossyDrive(Drive):
    """Does not hear some of the stops, and takes its time for some feeds."""

    def __init__(self):
        super().__init__(lambda pdu: 0.3 if any(pdu[6:]) and random.random() < 0.3 else 0.003)

    def answer(self, pdu):
        is_lost = pdu[0] != READ and not any(pdu[6:]) and random.random() < 0.3
        return b"" if is_lost else super().answer(pdu)


class SerialLine:
    """A pty with one drive, at address 1, which works through its requests one after the other."""

    def __init__(self, drive):
        self._drive = drive
        self._requests = queue.Queue()
        self._ended = threading.Event()
        self._ours, self._theirs = pty.openpty()
        tty.setraw(self._theirs)
        self.path = os.ttyname(self._theirs)
        self._threads = [threading.Thread(target=self._hear), threading.Thread(target=self._work)]
        for thread in self._threads:
            thread.start()

    def _hear(self):
        heard = b""
        while not self._ended.is_set():
            if select.select([self._ours], [], [], 0.05)[0]:
                heard += os.read(self._ours, 4096)
                request, heard = take_request(heard)
                while request:
                    self._requests.put(request)
                    request, heard = take_request(heard)

    def _work(self):
        while (request := self._requests.get()) is not None:
            pdu = request[1:-2]
            answer = self._drive.serve(pdu)
            if not answer:
                continue
            os.write(self._ours, framed(request[:1] + answer))
            if self._drive.second:
                threading.Timer(self._drive.second(pdu), os.write, (self._ours, framed(request[:1] + answer))).start()

    def end(self):
        self._ended.set()
        self._requests.put(None)
        for thread in self._threads:
            thread.join()
        time.sleep(0.1)  # a second answer may be on its way
        os.close(self._ours)
        os.close(self._theirs)


class Asker:
    """Asks one thing after the other, until it is told to end or its gateway goes. `counts`: what came; `wrong`: what
    was not true."""

    def __init__(self, drive, unit, requests, pause=0.0):
        self.counts = collections.Counter()
        self.wrong = []
        self.drive, self.unit = drive, unit
        self._requests, self._pause = requests, pause
        self._ended = threading.Event()

    def begin(self, port):
        self._ended.clear()
        self._thread = threading.Thread(target=self._run, args=[port])
        self._thread.start()

    def end(self):
        self._ended.set()
        self._thread.join()

    def _run(self, port):
        client = Client(port)
        try:
            while not self._ended.is_set() and self.ask(client):
                self._ended.wait(self._pause)
        except OSError:
            pass
        client.close()

    def ask(self, client):
        """False: the connection has ended."""
        pdu = next(self._requests)
        before = self.drive.count(pdu)
        answer = client.ask(pdu, self.unit)
        if answer:
            self.judge(pdu, answer, before)
        return answer

    def judge(self, pdu, answer, before):
        if answer[0] & 0x80:
            self.counts[f"{answer[1]:02X}"] += 1
        elif answer[2:4] == pdu[1:3] if pdu[0] == READ else self.drive.count(pdu) > before:
            self.counts["right"] += 1
        else:
            self.wrong.append((pdu.hex(" "), answer.hex(" ")))


class Jogger(Asker):
    """Sends a jog behind a read that takes its time, and a stop behind the jog, perhaps as another unit, in one go. A stop
    that is acknowledged was carried out, and no jog after it."""

    BLOCKER = b"\x03\x00\x32\x00\x01"

    def __init__(self, drive, unit, jog, stop, stop_unit=None):
        super().__init__(drive, unit, iter(()), 0.02)
        self._jog, self._stop, self._stop_unit = jog, stop, stop_unit or unit

    def ask(self, client):
        begin = len(self.drive.done)
        client.send(self.BLOCKER, self.unit)
        client.send(self._jog, self.unit)
        client.send(self._stop, self._stop_unit)
        answers = {}
        for _ in range(3):
            number, pdu = client.receive_numbered()
            if not pdu:
                return False
            answers[number] = pdu
        (_, blocked), (_, jogged), (_, stopped) = sorted(answers.items(), key=lambda it: (it[0] - min(answers)) & 0xFFFF)
        done = self.drive.done[begin:]
        self.counts["right" if not stopped[0] & 0x80 else f"stop {stopped[1]:02X}"] += 1
        self.counts["jog done" if self._jog in done else "jog not done"] += 1
        is_wrong = not blocked[0] & 0x80 and blocked[2:4] != self.BLOCKER[1:3]
        is_wrong |= self._stop in done and self._jog in done[done.index(self._stop):]
        is_wrong |= not stopped[0] & 0x80 and self._stop not in done
        is_wrong |= not jogged[0] & 0x80 and self._jog not in done
        is_wrong |= jogged == bytes([jogged[0], BUSY]) and self._jog in done
        if is_wrong:
            self.wrong.append(([pdu.hex(" ") for pdu in (blocked, jogged, stopped)], [pdu.hex(" ") for pdu in done]))
        return True


def reads(*firsts):
    while True:
        for first in firsts:
            yield b"\x03" + first.to_bytes(2, "big") + b"\x00\x01"


def writes(function, first, values):
    for value in values:
        one = bytes([WRITE]) + first.to_bytes(2, "big") + value.to_bytes(2, "big")
        yield registers_of(first, value) if function == WRITE_MULTIPLE else one


def around(seconds, part=0.1):
    return lambda _: seconds * random.uniform(1 - part, 1 + part)
