#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Connections without an end to the HTTP interface of the demo's gateway: whoever opens them takes places from itself, and
others are served. And what browsers ask for pages from elsewhere, and requests that name no host, or two."""

import os
import socket
import subprocess
import sys
import threading
import unittest

from control_case import EVENTS, RELOAD, TRACE, HttpCase, UnixConnection
from demo_plant import PATIENCE, program

STATUS = "/api/v1/status"
CROWD = 70  # more than there are places
ASK = b"GET /api/v1/status HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"


class HttpPlaces(HttpCase):
    def crowd(self, connect, say=b""):
        """So many connections."""
        for _ in range(CROWD):
            connection = connect()
            self.addCleanup(connection.close)
            connection.sendall(say)

    def connect_from(self, address):
        return lambda: socket.create_connection(self.address, PATIENCE, source_address=(address, 0))

    def connect_to_socket(self):
        connection = socket.socket(socket.AF_UNIX)
        connection.connect(str(self.plant.control))
        connection.settimeout(PATIENCE)
        return connection

    def test_idle_connections_of_one_address_shut_nobody_else_out(self):
        self.listen()
        kept = self.tcp()  # idle for longer than all of them
        self.assertEqual(self.ask("GET", STATUS, kept)[0], 200)
        own = kept.sock.getsockname()
        for say in (b"", b"GET / HT", b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"):
            self.crowd(self.connect_from("127.0.0.2"), say)
            self.assertEqual(self.ask("GET", STATUS, self.tcp("127.0.0.3"))[0], 200)
            self.assertEqual(self.ask("GET", STATUS, self.tcp("127.0.0.2"))[0], 200)
        self.assertEqual(self.ask("GET", STATUS, kept)[0], 200)
        self.assertEqual(kept.sock.getsockname(), own)

    def test_idle_connections_to_the_socket_do_not_keep_a_reload_out(self):
        for say in (b"", b"POST /api", ASK):
            self.crowd(self.connect_to_socket, say)
            shown = self.mbgatectl("reload", "--control", self.plant.control)
            self.assertEqual((shown.returncode, shown.stdout.splitlines()[:1]), (0, ["reload: nothing has changed"]), shown.stderr)

    def test_connections_that_ask_without_a_pause_do_not_keep_a_reload_out(self):
        ended = threading.Event()

        def flood():
            while not ended.is_set():
                try:
                    with self.connect_to_socket() as connection:
                        connection.settimeout(1)
                        while not ended.is_set():
                            connection.sendall(ASK)
                            if not connection.recv(1 << 20):
                                break
                except OSError:
                    pass  # another one has its place

        crowd = [threading.Thread(target=flood) for _ in range(20)]
        for one in crowd:
            one.start()
        try:
            codes = [self.mbgatectl("reload", "--control", self.plant.control).returncode for _ in range(5)]
        finally:
            ended.set()
            for one in crowd:
                one.join()
        self.assertEqual(codes, [0] * 5)

    @unittest.skipIf(os.getuid() != 0, "only root can be another user")
    def test_another_user_has_places_of_its_own(self):
        folder = self.plant.control.parent
        folder.chmod(0o755)
        os.chown(self.plant.control, 0, 12345)
        code = ("import socket, sys\nkept = []\nfor _ in range(70):\n kept.append(socket.socket(socket.AF_UNIX))\n"
                " kept[-1].connect(sys.argv[1])\nprint('connected', flush=True)\nsys.stdin.read()")  # fmt: skip
        waiting = UnixConnection(self.plant.control)
        self.assertEqual(self.ask("GET", STATUS, waiting)[0], 200)
        other = subprocess.Popen(["/usr/bin/python3", "-c", code, str(self.plant.control)], user=12345, group=12345,
                                 extra_groups=[], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)  # fmt: skip
        with other:
            self.assertEqual(other.stdout.readline(), "connected\n")
            self.assertEqual(self.ask("POST", RELOAD)[0], 200)
            waiting.auto_open = False
            self.assertEqual(self.ask("GET", STATUS, waiting)[0], 200)

    def test_what_a_browser_asks_for_another_page_is_refused(self):
        self.listen()
        for path in (STATUS, EVENTS, TRACE, "/healthz", "/"):
            for site in ("cross-site", "same-site"):
                headers = {"Sec-Fetch-Site": site, "Sec-Fetch-Mode": "no-cors", "Sec-Fetch-Dest": "image"}
                code, body = self.ask("GET", path, self.tcp(), headers)
                why = f"the request comes from a page of another origin, \"{site}\" (Sec-Fetch-Site)"
                self.assertEqual((code, body["error"]), (403, why))
        for site in ("same-origin", "none"):
            self.assertEqual(self.ask("GET", STATUS, self.tcp(), {"Sec-Fetch-Site": site})[0], 200)
        # A link leads to the page, and to nothing else.
        link = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate", "Sec-Fetch-Dest": "document"}
        connection = self.tcp()
        connection.request("GET", "/", headers=link)
        self.assertEqual(connection.getresponse().status, 200)
        connection.close()
        self.assertEqual(self.ask("GET", EVENTS, self.tcp(), link)[0], 403)
        self.assertEqual(self.ask("GET", "/", self.tcp(), link | {"Sec-Fetch-Dest": "iframe"})[0], 403)
        self.assertEqual(self.ask("GET", STATUS, headers={"Sec-Fetch-Site": "cross-site"})[0], 403)

    def test_a_browser_follows_a_stream_as_an_event_source_alone(self):
        self.listen()
        browser = {"User-Agent": "Mozilla/5.0 (X11; Linux x86_64)"}
        for path in (EVENTS, TRACE):
            code, body = self.ask("GET", path, self.tcp(), browser | {"Accept": "image/avif,*/*;q=0.8"})
            self.assertEqual(code, 406)
            self.assertIn("text/event-stream", body["error"])
            connection = self.tcp()
            connection.request("GET", path, headers=browser | {"Accept": "text/event-stream"})
            with connection.getresponse() as stream:
                self.assertEqual(stream.status, 200)
            connection.close()

    def test_a_request_names_one_host(self):
        self.listen()
        for connect in (self.connect_from("127.0.0.1"), self.connect_to_socket):
            for head, code in ((b"1.1\r\n", 400), (b"1.1\r\nHost: localhost\r\nHost: localhost\r\n", 400),
                               (b"1.0\r\nHost: localhost\r\nHost: x\r\n", 400), (b"1.1\r\nHost: localhost\r\n", 200),
                               (b"1.0\r\n", 200)):  # fmt: skip
                with connect() as connection:
                    connection.sendall(b"GET /healthz HTTP/" + head + b"\r\n")
                    self.assertEqual(int(connection.recv(12)[9:]), code, head)

    def test_curl_and_mbgatectl_are_served_over_the_socket(self):
        shown = subprocess.run(["curl", "-sS", "--unix-socket", self.plant.control, "http://mbgated/healthz"],
                               capture_output=True, text=True, check=False)  # fmt: skip
        self.assertEqual((shown.returncode, shown.stdout), (0, '{"status":"ok"}\n'), shown.stderr)
        shown = subprocess.run([program("mbgatectl"), "status", "--control", self.plant.control], capture_output=True,
                               check=False)  # fmt: skip
        self.assertEqual(shown.returncode, 0)


if __name__ == "__main__":
    sys.exit(unittest.main())
