#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Modbus TCP servers with faults as the field has them: an answer whose length is wrong, exceptions that count a byte more
than they have, and a gateway that did not reach its drive. Each costs no more than what it says."""

import json
import pathlib
import socket
import tempfile
import threading
import unittest

from control_case import UnixConnection
from demo_plant import PATIENCE, Process
from fault_plant import NO_ANSWER, Client, exception

READS = 220
REFUSED_OF = 11  # one of so many registers does not exist
CONFIGURATION = """
[http]
socket = "{control}"
[[listen]]
name = "plant"
address = "127.0.0.1"
port = 0
max_requests_per_second = 0
[[bus]]
name = "far"
mode = "tcp"
host = "127.0.0.1"
port = {port}
response_timeout = "500ms"
[[device]]
name = "axis"
bus = "far"
address = 1
[[route]]
unit = 1
device = "axis"
"""


def one_register(first):
    return b"\x03" + first.to_bytes(2, "big") + b"\x00\x01"


def answered(first):
    return b"\x03\x02" + first.to_bytes(2, "big")


class FaultyServer:
    """Answers each read with the register's number. `spoil(number, first, adu)` says what is sent instead, and may say
    nothing."""

    def __init__(self, spoil):
        self._spoil = spoil
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        self.connections = 0
        self.requests = 0
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        while True:
            try:
                connection, _ = self._listener.accept()
            except OSError:
                return
            self.connections += 1
            threading.Thread(target=self._serve, args=(connection,), daemon=True).start()

    def _serve(self, connection):
        with connection, connection.makefile("rb") as requests:
            while len(request := requests.read(12)) == 12:
                self.requests += 1
                first = int.from_bytes(request[8:10], "big")
                adu = request[:4] + b"\x00\x05" + request[6:7] + answered(first)
                connection.sendall(self._spoil(self.requests, first, adu))

    def close(self):
        self._listener.close()


class FaultyServers(unittest.TestCase):
    def start(self, spoil):
        self.server = FaultyServer(spoil)
        self.addCleanup(self.server.close)
        folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.control = folder / "control"
        file = folder / "mbgate.toml"
        file.write_text(CONFIGURATION.format(control=self.control, port=self.server.port), encoding="utf-8")
        self.gateway = Process(folder, "mbgated", "--config", file)
        gateway = self.gateway  # another subtest has another one
        self.addCleanup(lambda: self.assertEqual(0, gateway.end()))
        self.client = Client(int(self.gateway.wait_for(r"listening plant 127\.0\.0\.1:(\d+)$").group(1)))
        self.addCleanup(self.client.close)

    def device(self):
        connection = UnixConnection(self.control)
        self.addCleanup(connection.close)
        return self.reply(connection)["devices"][0]

    def findings(self):
        connection = UnixConnection(self.control)
        self.addCleanup(connection.close)
        return [(it["subject"], it["finding"]) for it in self.reply(connection)["diagnoses"]]

    def reply(self, connection):
        connection.request("GET", "/api/v1/status")
        return json.loads(connection.getresponse().read())

    def read_all(self):
        """What was answered with something else than the register, and how often."""
        others = {}
        for number in range(READS):
            answer = self.client.ask(one_register(number % REFUSED_OF))
            if answer != answered(number % REFUSED_OF):
                others[answer.hex(" ")] = others.get(answer.hex(" "), 0) + 1
        return others

    def test_a_length_that_is_too_long_costs_one_response_timeout(self):
        for length in (71, 254):
            with self.subTest(length):
                self.start(lambda number, _, adu, length=length:
                           adu[:4] + length.to_bytes(2, "big") + adu[6:] if number == 20 else adu)  # fmt: skip
                self.assertEqual(self.read_all(), {})
                self.assertEqual((self.server.connections, self.server.requests), (2, READS + 1))
                self.gateway.wait_for("bus far: an answer was not complete at the end of its response timeout")

    def test_an_exception_that_counts_a_byte_more_costs_nothing_else(self):
        for behind in (b"", b"\x00", b"\x55"):
            with self.subTest(behind):
                self.start(lambda _, first, adu, behind=behind:
                           adu if first != 7 else adu[:4] + b"\x00\x04" + adu[6:7] + b"\x83\x02" + behind)  # fmt: skip
                self.assertEqual(self.read_all(), {"83 02": READS // REFUSED_OF})
                self.assertEqual(self.server.connections, 1)

    def test_a_gateway_that_does_not_reach_the_drive_does_not_answer_for_it(self):
        for code in (0x0A, NO_ANSWER):
            with self.subTest(code):
                self.start(lambda number, _, adu, code=code:
                           adu if number > 4 else adu[:5] + b"\x03" + adu[6:7] + exception(3, code))  # fmt: skip
                for _ in range(3):
                    self.assertEqual(self.client.ask(one_register(1)), exception(3, code))
                device = self.device()
                self.assertEqual((device["state"], device["unanswered_in_row"]), ("offline", 3), device)
                self.assertIn(("bus far", "the server answers, but reaches no device"), self.findings())
                limit = 100 * PATIENCE
                while self.client.ask(one_register(1)) != answered(1):  # the probes, and what is refused between them
                    limit -= 1
                    self.assertGreater(limit, 0)
                    threading.Event().wait(0.01)
                self.assertEqual(self.device()["state"], "answering")


if __name__ == "__main__":
    unittest.main()
