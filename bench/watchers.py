#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What it costs a full bus to be watched: 100 readers of the trace, a browser with the status page and a scraper of /metrics
once a second, beside clients that keep a line of 115200 baud busy. Answers a second with them and without, in turn, in one
run; or, with --minutes, the memory of mbgated while they all stay. Programs: those in the folder MBGATE_PROGRAMS.

Who watches has nice 19: it stands for other computers."""

import argparse
import json
import os
import pathlib
import selectors
import socket
import statistics
import struct
import subprocess
import sys
import threading
import time
import urllib.request

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "tests" / "integration"))
from demo_plant import PATIENCE  # noqa: E402
from page_browser import WIDE, Browser, missing  # noqa: E402
from page_plant import LINES, PagePlant  # noqa: E402

CONNECTIONS, OUTSTANDING = 4, 4
REGISTERS = 10
TRACE = b"GET /api/v1/trace HTTP/1.1\r\nHost: localhost\r\n\r\n"
READERS = """
import os, selectors, socket, sys
os.nice(19)
port, count = int(sys.argv[1]), int(sys.argv[2])
readers = selectors.DefaultSelector()
for _ in range(count):
    reader = socket.create_connection(("127.0.0.1", port))
    reader.sendall(bytes.fromhex(sys.argv[3]))
    readers.register(reader, selectors.EVENT_READ)
answered = 0
while True:
    for key, _ in readers.select():
        data = key.fileobj.recv(1 << 20)
        if not data:
            sys.exit("a reader's stream has ended")
        if key.data is None:
            if not data.startswith(b"HTTP/1.1 200"):
                sys.exit("a reader was refused: " + data[:60].decode())
            readers.modify(key.fileobj, selectors.EVENT_READ, True)
            answered += 1
            if answered == count:
                print("reading", flush=True)
"""


def read(slot):
    """One of the requests that wait at the same time: no two are equal, which would be sent once."""
    return struct.pack(">HHHBBHH", slot, 0, 6, 1, 3, slot, REGISTERS)


class Load(threading.Thread):
    """Clients that ask again as soon as they are answered."""

    def __init__(self, port):
        super().__init__(daemon=True)
        self.answers = self.wrong = 0
        self._ended = False
        self._selector = selectors.DefaultSelector()
        for connection in range(CONNECTIONS):
            client = socket.create_connection(("127.0.0.1", port))
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            client.sendall(b"".join(read(connection * OUTSTANDING + i) for i in range(OUTSTANDING)))
            self._selector.register(client, selectors.EVENT_READ, bytearray())

    def run(self):
        while not self._ended:
            for key, _ in self._selector.select(1):
                self._take(key.fileobj, key.data)

    def _take(self, client, data):
        data += client.recv(4096)
        while len(data) >= 6 and len(data) >= 6 + int.from_bytes(data[4:6], "big"):
            size = 6 + int.from_bytes(data[4:6], "big")
            slot = int.from_bytes(data[:2], "big")
            self.wrong += data[7] != 3 or size != 9 + 2 * REGISTERS
            del data[:size]
            self.answers += 1
            client.sendall(read(slot))

    def rate(self, seconds):
        """Answers a second over so many seconds."""
        began, before = time.monotonic(), self.answers
        time.sleep(seconds)
        return (self.answers - before) / (time.monotonic() - began)

    def end(self):
        self._ended = True
        self.join()


class Watchers:
    """with Watchers(url, readers): ..."""

    def __init__(self, url, readers):
        self._url, self._readers = url, readers

    def __enter__(self):
        port = self._url.rstrip("/").rpartition(":")[2]
        command = [sys.executable, "-c", READERS, port, str(self._readers), TRACE.hex()]
        self._reading = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        if self._reading.stdout.readline() != "reading\n":
            raise SystemExit(f"the readers have ended: {self._reading.wait(PATIENCE)}")
        self._ended = threading.Event()
        self.scrapes = 0
        self._scraper = threading.Thread(target=self._scrape)
        self._scraper.start()
        self._browser = Browser()
        self._browser.__enter__()
        subprocess.run(["renice", "-n", "19", "-g", str(os.getpgid(self._browser.driver.service.process.pid))],
                       check=False, capture_output=True)
        self._browser.open(self._url, WIDE)
        return self

    def _scrape(self):
        while not self._ended.wait(1):
            with urllib.request.urlopen(self._url + "metrics", timeout=PATIENCE) as answer:
                self.scrapes += b"mbgate_" in answer.read()

    def check(self):
        """They all are still there."""
        if self._reading.poll() is not None or not self._scraper.is_alive():
            raise SystemExit("a reader or the scraper has ended")

    def __exit__(self, *_):
        self._ended.set()
        self._scraper.join()
        self._browser.__exit__()
        self._reading.kill()
        self._reading.wait()
        self._reading.stdout.close()


def memory(plant):
    """Resident kilobytes of mbgated."""
    for line in plant.gateway.process_file("status").splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1])
    raise ValueError("no VmRSS")


def in_turn(plant, load, options):
    quiet, watched = [], []
    for pair in range(options.pairs):
        quiet.append(load.rate(options.seconds))
        with Watchers(plant.url, options.readers) as watchers:
            time.sleep(2)
            watched.append(load.rate(options.seconds))
            watchers.check()
        print(f"{pair + 1:3} quiet {quiet[-1]:7.2f}/s  watched {watched[-1]:7.2f}/s  {watched[-1] / quiet[-1]:.4f}", flush=True)
    ratios = sorted(b / a for a, b in zip(quiet, watched))
    print(f"answers a second: quiet {statistics.median(quiet):.2f} (from {min(quiet):.2f} to {max(quiet):.2f}), "
          f"watched {statistics.median(watched):.2f} (from {min(watched):.2f} to {max(watched):.2f}); "
          f"ratio {statistics.median(ratios):.4f} (from {ratios[0]:.4f} to {ratios[-1]:.4f})")


def for_minutes(plant, load, options):
    samples = []
    end = time.monotonic() + 60 * options.minutes
    with Watchers(plant.url, options.readers) as watchers:
        while time.monotonic() < end:
            time.sleep(min(10, max(0, end - time.monotonic())))
            watchers.check()
            samples.append(memory(plant))
            if len(samples) % 30 == 0:
                print(f"{len(samples) // 6:3} min  {samples[-1]} kB  {load.answers} answers", flush=True)
        print(f"{watchers.scrapes} scrapes")
    tenth = max(1, len(samples) // 10)
    print(f"memory of mbgated: after {tenth * 10} s {samples[tenth - 1]} kB, at the end {samples[-1]} kB, most {max(samples)} kB; "
          f"medians of ten parts: {[statistics.median(samples[i * tenth:(i + 1) * tenth]) for i in range(len(samples) // tenth)]}")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--readers", type=int, default=100, help="of the trace (%(default)s)")
    parser.add_argument("--pairs", type=int, default=7, help="quiet and watched, in turn (%(default)s)")
    parser.add_argument("--seconds", type=float, default=10, help="each of them (%(default)s)")
    parser.add_argument("--minutes", type=float, help="instead: all stay so long, and memory is told")
    options = parser.parse_args()
    if reason := missing():
        raise SystemExit(f"skipped: {reason}")
    # Its first line has 115200 baud.
    with PagePlant(keys=f"max_streams = {2 * options.readers + 8}", lines=LINES[:1]) as plant:
        load = Load(plant.port)
        load.start()
        (for_minutes if options.minutes else in_turn)(plant, load, options)
        load.end()
        print(json.dumps({"answers": load.answers, "wrong": load.wrong, "readers": options.readers}))
        return 1 if load.wrong or not load.answers else 0


if __name__ == "__main__":
    sys.exit(main())
