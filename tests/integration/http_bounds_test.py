#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Requests without an end to the HTTP interface of the demo's gateway, over both kinds of socket: they take no memory, and
others are served."""

import itertools
import socket
import sys
import unittest

from control_case import MOONS, HttpCase
from demo_plant import PATIENCE
from machine_faults_test import resident

SENT = 64 << 20  # of each request, unless it is ended before
MEMORY = 24 << 20  # what the process may grow by, of which a busy sanitizer needs some
CHUNKED = b"%s / HTTP/1.1\r\nHost: 127.0.0.1\r\nTransfer-Encoding: chunked\r\n\r\n"
LENGTH = b"POST /api/v1/reload HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: %d\r\n\r\n"
# How it begins, and what follows without end.
ENDLESS = {
    "chunk extension": (CHUNKED % b"GET" + b"1;", b"x"),
    "trailers": (CHUNKED % b"POST" + b"0\r\n", b"a: b\r\n"),
    "zeros of a chunk size": (CHUNKED % b"GET", b"0"),
    "chunks": (CHUNKED % b"POST", b"1\r\nx\r\n"),
    "target": (b"GET /", b"x"),
    "header": (b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nA: ", b"x"),
    "headers": (b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n", b"a: b\r\n"),
    "empty lines": (b"", b"\r\n"),
    "body": (LENGTH % (1 << 40), b"x"),
}


class HttpBounds(HttpCase):
    def resident(self):
        return resident(self.plant.pid())

    def connections(self):
        """One of each kind of socket."""
        over_unix = socket.socket(socket.AF_UNIX)
        over_unix.connect(str(self.plant.control))
        for made in (over_unix, socket.create_connection(self.address, PATIENCE)):
            self.addCleanup(made.close)
            made.settimeout(PATIENCE)
            yield made

    def send(self, connection, begin, piece):
        """Until the gateway has ended it, or SENT: how many bytes it took."""
        block = piece * ((1 << 18) // len(piece))
        sent = 0
        try:
            for part in itertools.chain([begin], itertools.repeat(block, SENT // len(block))):
                connection.sendall(part)
                sent += len(part)
        except (BrokenPipeError, ConnectionResetError):
            pass
        return sent

    def test_requests_without_end_take_no_memory(self):
        self.listen()
        self.status()
        for name, (begin, piece) in ENDLESS.items():
            for connection in self.connections():
                with self.subTest(name, over=connection.family.name):
                    before = self.resident()
                    sent = self.send(connection, begin, piece)
                    grown = self.resident() - before  # while it is there
                    self.assertLess(grown, MEMORY, f"{sent} bytes were taken")
                    self.assertLess(sent, SENT)
                    self.assertEqual(self.ask("GET", "/healthz")[0], 200)
                    self.assertEqual(self.ask("GET", "/healthz", self.tcp())[0], 200)
        self.assertEqual(self.read(MOONS).returncode, 0)

    def test_a_body_is_refused_by_its_head(self):
        self.listen()
        for head, code in ((CHUNKED % b"GET", b"411"), (CHUNKED % b"POST", b"411"), (LENGTH % 4097, b"413")):
            over_unix, _ = self.connections()
            over_unix.sendall(head)
            answer = over_unix.makefile("rb").read()  # the connection ends with it
            self.assertEqual(answer[9:12], code)
            self.assertIn(b"expected no body", answer)
        body = b"x" * 4096
        over_unix, over_tcp = self.connections()
        over_unix.sendall(LENGTH % len(body) + body)
        self.assertEqual(over_unix.recv(12), b"HTTP/1.1 200")
        over_tcp.sendall(CHUNKED % b"POST")
        self.assertEqual(over_tcp.recv(12), b"HTTP/1.1 403")  # what may not be asked at all is said first


if __name__ == "__main__":
    sys.exit(unittest.main())
