#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Clients as nobody wants them, each kind a process of its own: `abusers.py KIND --port P --address A`. It goes on until
SIGTERM, and prints then how often it did what. It stands for another computer: it has an address of its own, and hardly
takes time from a process that is not as nice.

The kinds of TLS_KINDS are for the port of a TLS listener; `tls_renegotiates` and `tls_without_data` have a certificate
(`--identity`), and the first needs openssl."""

import argparse
import collections
import contextlib
import itertools
import json
import os
import random
import selectors
import signal
import socket
import ssl
import struct
import subprocess
import sys
import time

from tls_records import VERSIONS, Records

FEW, MANY = 20, 200  # connections of one abuser
LINES = 1000  # to a program that an abuser has run, or records at once
UNROUTED, GATEWAY = 250, 255  # units that lead to no device
PAUSE = 0.005
HTTP_PATHS = ("/", "/api/v1/status", "/metrics", "/healthz", "/api/v1/trace?client=x", "/api/v1/events", "/%00",
              "/x" * 3000)


def request(unit, count=100):
    return struct.pack(">HHHBBHH", random.getrandbits(16), 0, 6, unit, 3, 0, count)


class Abuser:
    """Counts what it does; what the other side does to its connections is no surprise."""

    def __init__(self, chosen):
        self.port = chosen.port
        self.address = chosen.address
        self.credentials = ("-cert", f"{chosen.identity}.crt", "-key", f"{chosen.identity}.key")
        self.done = collections.Counter()

    def connect(self, **how):
        """A connection, or nothing."""
        connection = socket.socket()
        for option, value in how.items():
            connection.setsockopt(socket.SOL_SOCKET, getattr(socket, option), value)
        connection.settimeout(1)
        try:
            connection.bind((self.address, 0))
            connection.connect(("127.0.0.1", self.port))
        except OSError:
            connection.close()
            self.done["not connected"] += 1
            time.sleep(PAUSE)
            return None
        connection.setblocking(False)
        self.note_connected()
        return connection

    def note_connected(self):
        if not self.done["connected"]:
            print("connected", flush=True)
        self.done["connected"] += 1

    def crowd(self, size, act, **how):
        """So many connections, with each of which `act(connection)` does something; one that fails is replaced."""
        connections = []
        while True:
            if len(connections) < size:
                connection = self.connect(**how)
                if connection:
                    connections.append(connection)
            for connection in list(connections):
                try:
                    act(connection)
                except BlockingIOError:
                    self.done["would have to wait"] += 1
                except OSError:
                    self.done["thrown out"] += 1
                    connections.remove(connection)
                    connection.close()
            if len(connections) == size:
                time.sleep(PAUSE)

    def drain(self, connection):
        """Reads what there is; ends with an error if the other side has closed."""
        with contextlib.suppress(BlockingIOError):
            got = connection.recv(65536)
            if not got:
                raise ConnectionResetError
            self.done["bytes read"] += len(got)


def connects(abuser):
    """A connection after the other, closed at once, every other one with RST."""
    while True:
        connection = abuser.connect()
        if connection:
            if random.getrandbits(1):
                connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            connection.close()


def refused(abuser):
    """The same from an address that may not connect."""
    connects(abuser)


def half_open(abuser):
    """Connections that say nothing, or half a request."""
    begun = set()

    def act(connection):
        abuser.drain(connection)
        if connection not in begun:
            begun.add(connection)
            connection.send(request(UNROUTED)[: random.randrange(12)])

    abuser.crowd(MANY, act)


def pipelines(abuser):
    """As many requests at once as a socket takes, and the answers when they come."""

    def act(connection):
        abuser.drain(connection)
        abuser.done["bytes sent"] += connection.send(request(UNROUTED) * 2000)

    abuser.crowd(FEW, act)


def asks(abuser):
    """One request after the other, as fast as they are answered, on as many connections as may be."""
    waiting = selectors.DefaultSelector()
    while True:
        if len(waiting.get_map()) < FEW:
            connection = abuser.connect()
            if connection:
                connection.send(request(GATEWAY, 10))
                waiting.register(connection, selectors.EVENT_READ)
        for key, _ in waiting.select(PAUSE):
            try:
                abuser.drain(key.fileobj)
                key.fileobj.send(request(GATEWAY, 10))
                abuser.done["asked"] += 1
            except BlockingIOError:
                abuser.done["would have to wait"] += 1
            except OSError:
                abuser.done["thrown out"] += 1
                waiting.unregister(key.fileobj)
                key.fileobj.close()


def bytewise(abuser):
    """Requests byte by byte."""
    asked = request(UNROUTED)
    place = collections.Counter()

    def act(connection):
        abuser.drain(connection)
        connection.send(asked[place[connection] % 12 :][:1])
        place[connection] += 1

    abuser.crowd(FEW, act)


def never_read(abuser):
    """Asks and asks, and takes no answer."""
    abuser.crowd(FEW, lambda connection: connection.send(request(GATEWAY) * 100), SO_RCVBUF=2048)


def noise(abuser):
    """Random bytes; some begin like a request."""

    def act(connection):
        abuser.drain(connection)
        head = request(UNROUTED)[: random.choice((0, 0, 4, 6, 8))]
        connection.send(head + random.randbytes(random.randrange(1, 600)))

    abuser.crowd(FEW, act)


def http(abuser):
    """Requests, half ones, large ones, nonsense; streams that nobody reads."""
    streams = set()

    def act(connection):
        if connection in streams:
            return
        kind = random.randrange(6)
        path = random.choice(HTTP_PATHS)
        head = f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\n"
        if kind == 0:
            connection.send(head.encode())
        elif kind == 1:
            connection.send((head + "X: " + "x" * 20_000 + "\r\n\r\n").encode())
        elif kind == 2:
            connection.send(random.randbytes(200))
        elif kind == 3:
            connection.send((head + "Origin: http://elsewhere\r\n\r\n").encode() * 50)
        else:
            abuser.drain(connection)
            connection.send((head + "\r\n").encode())
            if path.startswith(("/api/v1/trace", "/api/v1/events")):
                streams.add(connection)
        abuser.done["asked"] += 1

    abuser.crowd(MANY, act)


def http_endless(abuser):
    """Chunks with extensions, trailers and sizes that have no end."""
    ends = itertools.cycle((b"1;", b"0\r\na: ", b""))
    begun = set()

    def act(connection):
        if connection not in begun:
            begun.add(connection)
            connection.send(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nTransfer-Encoding: chunked\r\n\r\n" + next(ends))
        abuser.done["bytes sent"] += connection.send(b"0" * 65536)

    abuser.crowd(FEW, act)


def http_idle(abuser):
    """Connections that ask nothing."""
    abuser.crowd(MANY, abuser.drain)


def tls_hellos(abuser):
    """Handshakes without a certificate, one after the other: the other side has all its work, and then refuses."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    while True:
        connection = abuser.connect()
        if connection:
            connection.settimeout(1)
            try:
                with context.wrap_socket(connection) as secured:
                    secured.recv(1)
                abuser.done["shaken hands"] += 1
            except OSError:
                abuser.done["thrown out"] += 1
            connection.close()


def tls_silent(abuser):
    """Connections that say nothing, or begin a handshake."""
    hello = bytes.fromhex("16 03 01 02 00 01 00 01 fc 03 03")
    begun = set()

    def act(connection):
        abuser.drain(connection)
        if connection not in begun:
            begun.add(connection)
            connection.send(hello[: random.randrange(len(hello))])

    abuser.crowd(MANY, act)


def tls_noise(abuser):
    """Random bytes; some are records, some of them larger than any may be."""

    def act(connection):
        abuser.drain(connection)
        head = random.choice((b"", b"\x16\x03\x01\x02\x00", b"\x17\x03\x03\xff\xff", b"\x80\x2e\x01\x03"))
        connection.send(head + random.randbytes(random.randrange(1, 600)))

    abuser.crowd(FEW, act)


def tls_renegotiates(abuser):
    """A client with a certificate: asks for another handshake on its connection (TLS 1.2), or for new keys without end (1.3)."""
    where = ("-connect", f"127.0.0.1:{abuser.port}", "-bind", f"{abuser.address}:0")
    # A line with R or K is a command to openssl s_client.
    for version, line, what in itertools.cycle((("-tls1_2", b"R\n", "renegotiations"), ("-tls1_3", b"K\n", "new keys"))):
        command = ("openssl", "s_client", version, *where, *abuser.credentials)
        with subprocess.Popen(command, bufsize=0, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL) as client:  # fmt: skip
            try:
                if client.stdout.readline().startswith(b"CONNECTED"):
                    abuser.note_connected()
                for _ in range(LINES):
                    client.stdin.write(line)
                    abuser.done[what] += 1
                    time.sleep(PAUSE / 5)  # two lines read at once are one command
            except BrokenPipeError:
                abuser.done["thrown out"] += 1
            finally:
                client.kill()


def tls_without_data(abuser):
    """A client with a certificate: new keys (TLS 1.3) or empty handshakes (1.2), as many as the socket takes."""
    for version in itertools.cycle(VERSIONS):
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        context.check_hostname = False
        context.verify_mode = ssl.CERT_NONE
        context.minimum_version = context.maximum_version = version
        context.load_cert_chain(*abuser.credentials[1::2])
        connection = abuser.connect()
        if connection:
            connection.settimeout(1)
            try:
                records = Records(connection, context)
                while True:
                    connection.sendall(b"".join(records.without_data() for _ in range(LINES)))
                    abuser.done["records"] += LINES
            except OSError:
                abuser.done["thrown out"] += 1
            connection.close()


KINDS = {kind.__name__: kind for kind in (connects, refused, half_open, pipelines, asks, bytewise, never_read, noise)}
HTTP_KINDS = {kind.__name__: kind for kind in (http, http_endless, http_idle)}
TLS_KINDS = {kind.__name__: kind for kind in (tls_hellos, tls_silent, tls_noise, tls_renegotiates, tls_without_data)}


class Ended(BaseException):
    """SIGTERM has come."""


def end(*_):
    raise Ended


def main():
    options = argparse.ArgumentParser()
    options.add_argument("kind", choices=[*KINDS, *HTTP_KINDS, *TLS_KINDS])
    options.add_argument("--port", type=int, required=True)
    options.add_argument("--address", required=True)
    options.add_argument("--identity", help="the files of its certificate and key, without .crt and .key")
    chosen = options.parse_args()
    os.nice(19)
    abuser = Abuser(chosen)
    signal.signal(signal.SIGTERM, end)
    with contextlib.suppress(Ended):
        {**KINDS, **HTTP_KINDS, **TLS_KINDS}[chosen.kind](abuser)
    print(json.dumps(abuser.done), flush=True)


if __name__ == "__main__":
    sys.exit(main())
