#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The HTTP interface of the demo's gateway over TCP: it reads, for those who may, and changes nothing."""

import json
import re
import socket
import sys
import time
import unittest

from control_case import EVENTS, MOONS, RELOAD, TRACE, HttpCase, UnixConnection
from demo_plant import PATIENCE
from events_test import EventStream

STATUS = "/api/v1/status"


class Http(HttpCase):
    def server(self):
        """As mbgatectl names it."""
        return f"tcp://{self.address[0]}:{self.address[1]}"

    def events(self, connection):
        stream = EventStream(connection)
        self.addCleanup(stream.close)
        return stream

    def test_what_is_read_over_tcp_is_what_the_socket_says(self):
        self.listen()
        code, body = self.ask("GET", STATUS, self.tcp())
        self.assertEqual(code, 200)
        here = self.status()
        self.assertEqual(body.keys(), here.keys())
        for key in ("version", "configuration", "diagnoses"):
            self.assertEqual(body[key], here[key])
        self.assertEqual([bus["name"] for bus in body["buses"]], ["line-a", "line-b"])
        self.assertEqual(self.ask("GET", "/healthz", self.tcp()), (200, {"status": "ok"}))
        self.assertEqual(self.ask("GET", "/page/none", self.tcp())[0], 404)
        stream = self.events(self.tcp())
        self.assertEqual(self.ask("POST", RELOAD)[0], 200)
        self.assertEqual(stream.find("nothing has changed")[-1]["data"]["text"], "reload: nothing has changed")

    def test_mbgatectl_reads_over_tcp(self):
        self.listen()
        shown = self.mbgatectl("status", "--json", "--control", self.server())
        self.assertEqual(shown.returncode, 0, shown.stderr)
        self.assertEqual(json.loads(shown.stdout).keys(), self.status().keys())
        following, line = self.follow(self.server())
        self.assertRegex(line, r"^\d\d:\d\d:\d\d (notice reload: asked for by|info reload: nothing has changed\n$)")
        self.plant.end_gateway()
        self.assertEqual(following.wait(PATIENCE), 1)
        self.assertIn("mbgated has ended", following.stderr.read())
        shown = self.mbgatectl("status", "--control", self.server())
        self.assertEqual((shown.returncode, shown.stdout), (1, ""))
        self.assertIn(f"no program listens at {self.server()}", shown.stderr)

    def test_nothing_is_changed_over_tcp(self):
        self.listen()
        self.edit("baud = 9600", "baud = 19200")
        only = {"error": "expected the Unix socket ([http] socket): nothing can be changed over TCP"}
        self.assertEqual(self.ask("POST", RELOAD, self.tcp()), (403, only))
        self.assertEqual(self.ask("POST", STATUS, self.tcp()), (403, only))
        self.assertEqual(self.ask("POST", "/", self.tcp()), (403, only))
        self.assertEqual(self.ask("GET", RELOAD, self.tcp())[0], 405)
        shown = self.mbgatectl("reload", "--control", self.server())
        self.assertEqual((shown.returncode, shown.stdout, shown.stderr), (1, "", f"mbgatectl: {only['error']}\n"))
        self.assertEqual(self.status()["buses"][1]["baud"], 9600)

    def test_only_addresses_that_are_allowed_may_read(self):
        self.listen('allow = ["127.0.0.1/32"]')
        for _ in range(3):
            refused = {"error": "this address may not read: it is not in [http] allow"}
            self.assertEqual(self.ask("GET", STATUS, self.tcp("127.0.0.2")), (403, refused))
        self.assertEqual(self.ask("GET", STATUS, self.tcp())[0], 200)
        self.plant.wait_for(r"^warning: http: client 127\.0\.0\.2 refused: not in \[http\] allow$")
        self.configure('listen = ["127.0.0.1:0"]', 'allow = ["127.0.0.2"]')
        self.plant.wait_for("reload: done$")
        self.assertEqual(self.ask("GET", STATUS, self.tcp())[0], 403)
        self.assertEqual(self.ask("GET", STATUS, self.tcp("127.0.0.2"))[0], 200)
        # Once of an address, though it came three times.
        self.assertEqual(sum("127.0.0.2 refused" in line for line in self.plant.printed()), 1)

    def test_what_is_meant_for_another_name_is_refused(self):
        self.listen()
        for own in ("127.0.0.1", "localhost:80", "[::1]:8080"):
            self.assertEqual(self.ask("GET", STATUS, self.tcp(), {"Host": own})[0], 200, own)
        for path in (STATUS, EVENTS, "/healthz"):
            code, body = self.ask("GET", path, self.tcp(), {"Host": "gateway.plant"})
            self.assertEqual(code, 421)
            self.assertIn('"gateway.plant"', body["error"])
        # The Unix socket is reached by no browser.
        self.assertEqual(self.ask("GET", STATUS, headers={"Host": "gateway.plant"})[0], 200)
        self.configure('listen = ["127.0.0.1:0"]', 'hosts = ["Gateway.Plant"]')
        self.assertEqual(self.ask("GET", STATUS, self.tcp(), {"Host": "gateway.plant:8080"})[0], 200)

    def test_what_a_page_from_elsewhere_asks_is_refused(self):
        self.listen()
        own = f"http://{self.address[0]}:{self.address[1]}"
        self.assertEqual(self.ask("GET", STATUS, self.tcp(), {"Origin": own})[0], 200)
        for path in (STATUS, EVENTS, TRACE, "/healthz", "/"):
            for origin in ("http://evil.example", "null", "http://127.0.0.1"):
                code, body = self.ask("GET", path, self.tcp(), {"Origin": origin})
                self.assertEqual((code, body["error"]), (403, f'the request comes from a page of another origin, "{origin}" (Origin)'))
        # No page comes from a Unix socket; one from elsewhere could come to it through a tunnel.
        self.assertEqual(self.ask("GET", STATUS, headers={"Origin": "http://mbgated"})[0], 403)
        self.assertEqual(self.ask("POST", RELOAD, headers={"Origin": "http://mbgated"})[0], 403)

    def test_the_page_is_served_over_both_and_changes_nothing(self):
        self.listen()
        pages = []
        for connection in (self.tcp(), UnixConnection(self.plant.control)):
            connection.request("GET", "/")
            answer = connection.getresponse()
            pages.append(answer.read())
            self.assertEqual((answer.status, answer.headers["Content-Type"]), (200, "text/html; charset=utf-8"))
            self.assertIn("default-src 'none'", answer.headers["Content-Security-Policy"])
            for name in set(re.findall(r'"(/page/[a-z.]+)"', pages[-1].decode())):
                connection.request("HEAD", name)
                answer = connection.getresponse()
                self.assertEqual((answer.status, answer.read()), (200, b""), name)
            connection.request("HEAD", "/healthz")  # what is refused has no content for HEAD either
            self.assertEqual(connection.getresponse().read(), b"")
            connection.request("GET", "/healthz")
            self.assertEqual(connection.getresponse().status, 200)
            connection.close()
        self.assertEqual(pages[0], pages[1])
        self.assertEqual(self.ask("POST", "/")[0], 405)
        self.assertEqual(self.ask("POST", "/", self.tcp())[0], 403)
        self.assertEqual(self.ask("DELETE", "/page/main.js", self.tcp())[0], 405)

    def test_streams_of_all_sockets_are_counted_together(self):
        self.listen("max_streams = 2")
        streams = [self.events(UnixConnection(self.plant.control)), self.events(self.tcp())]
        self.assertEqual([stream.status for stream in streams], [200, 200])
        self.assertEqual(self.ask("GET", EVENTS)[0], 503)
        code, body = self.ask("GET", EVENTS, self.tcp())
        why = "2 clients already follow events or the trace; [http] max_streams allows 2"
        self.assertEqual((code, body["error"]), (503, why))
        self.assertEqual(self.ask("GET", STATUS, self.tcp())[0], 200)
        streams.pop().close()
        limit = time.monotonic() + PATIENCE
        while self.events(self.tcp()).status != 200:
            self.assertLess(time.monotonic(), limit, "the place of a stream that has ended is not free")

    def test_streams_over_tcp_leave_places_to_the_socket(self):
        self.listen("max_streams = 4")
        clients = (self.tcp(f"127.0.0.{last}") for last in range(1, 5))
        self.assertEqual([self.events(client).status for client in clients], [200, 200, 200, 503])
        code, body = self.ask("GET", TRACE, self.tcp())
        why = "3 clients already follow events or the trace over TCP; [http] max_streams = 4 allows 3 there"
        self.assertEqual((code, body["error"]), (503, why))
        self.assertEqual(self.events(UnixConnection(self.plant.control)).status, 200)

    def test_streams_of_one_address_leave_places_to_others(self):
        self.listen("max_streams = 8")
        self.assertEqual([self.events(self.tcp()).status for _ in range(3)], [200, 200, 503])
        self.assertEqual(self.events(self.tcp("127.0.0.2")).status, 200)

    def test_a_reload_ends_streams_of_those_who_may_not_read_any_more(self):
        self.listen('allow = ["127.0.0.1", "127.0.0.2"]')
        ended, stays = self.events(self.tcp()), self.events(self.tcp("127.0.0.2"))
        waiting = self.tcp()
        self.assertEqual(self.ask("GET", "/healthz", waiting)[0], 200)
        self.configure('listen = ["127.0.0.1:0"]', 'allow = ["127.0.0.2"]')
        self.assertTrue(ended.has_ended())
        self.assertEqual(waiting.sock.recv(1), b"")
        self.assertEqual(self.ask("POST", RELOAD)[0], 200)
        stays.find("nothing has changed")

    def test_a_reload_ends_streams_of_an_address_that_goes(self):
        self.listen()
        ended, stays = self.events(self.tcp()), self.events(UnixConnection(self.plant.control))
        self.configure()
        self.assertTrue(ended.has_ended())
        stays.find("reload: done")

    def add_listener(self, port):
        """A second one for Modbus clients, at this port, when the configuration is read again."""
        text = self.plant.configuration.read_text(encoding="utf-8")
        listener = f'[[listen]]\nname = "second"\naddress = "127.0.0.1"\nport = {port}\n\n'
        self.plant.configuration.write_text(text.replace("[[listen]]", f"{listener}[[listen]]", 1), encoding="utf-8")

    def listen_at_a_port_of_ours(self):
        with socket.create_server(("127.0.0.1", 0)) as chosen:
            self.address = chosen.getsockname()
        self.configure(f'listen = ["127.0.0.1:{self.address[1]}"]')
        self.plant.wait_for(rf"^listening http 127\.0\.0\.1:{self.address[1]}$")

    def test_an_address_that_it_leaves_can_be_a_listeners_at_once(self):
        self.listen_at_a_port_of_ours()
        ended = self.events(self.tcp())
        self.add_listener(self.address[1])
        self.configure('listen = ["127.0.0.1:0"]')
        self.plant.wait_for(rf"^listening second 127\.0\.0\.1:{self.address[1]}$")
        shown = self.mbgatectl("read", "holding", 0, "--unit", MOONS, "--port", self.address[1])
        self.assertEqual(shown.returncode, 0, shown.stderr)
        self.assertTrue(ended.has_ended())

    def test_a_reload_that_is_refused_leaves_it_as_it_was(self):
        self.listen_at_a_port_of_ours()
        stays = self.events(self.tcp())
        with socket.create_server(("127.0.0.1", 0)) as other:
            self.add_listener(other.getsockname()[1])
            self.edit(f"127.0.0.1:{self.address[1]}", "127.0.0.1:0")
            code, body = self.ask("POST", RELOAD)
            self.assertEqual(code, 422)
            self.assertRegex(body["messages"][0], "^listener \"second\": cannot listen on .*: Address already in use$")
        stays.find("the configuration stays as it is")
        self.assertEqual(self.ask("GET", "/healthz", self.tcp())[0], 200)

    def test_an_error_that_names_no_text_is_text(self):
        code, body = self.ask("GET", f"{TRACE}?client=%FF")
        self.assertEqual((code, body["error"]), (400, "client=\ufffd: expected an IP address"))

    def test_clients_over_tcp_keep_nobody_from_the_socket(self):
        self.listen()
        for _ in range(80):
            silent = socket.create_connection(self.address, PATIENCE)
            self.addCleanup(silent.close)
        self.status()
        self.assertEqual(self.read(MOONS).returncode, 0)

    def test_addresses_come_and_go_with_a_reload(self):
        self.listen()
        self.configure('listen = ["127.0.0.1:0"]', "max_streams = 3")
        self.assertEqual(self.ask("GET", "/healthz", self.tcp())[0], 200)  # it has stayed as it was
        self.configure()
        limit = time.monotonic() + PATIENCE
        while True:
            try:
                socket.create_connection(self.address, PATIENCE).close()
            except ConnectionRefusedError:
                break
            self.assertLess(time.monotonic(), limit, "it still listens")
        self.assertEqual(self.ask("GET", "/healthz")[0], 200)

    def test_a_port_that_somebody_has_is_tried_again(self):
        with socket.create_server(("127.0.0.1", 0)) as other:
            self.address = other.getsockname()
            self.configure(f'listen = "127.0.0.1:{self.address[1]}"')
            self.plant.wait_for("cannot listen on .*: Address already in use; it is tried again$")
            self.assertEqual(self.read(MOONS).returncode, 0)
        self.plant.wait_for(rf"^listening http 127\.0\.0\.1:{self.address[1]}$")
        self.assertEqual(self.ask("GET", "/healthz", self.tcp())[0], 200)

    def test_a_socket_of_systemd_takes_the_place_of_listen(self):
        self.plant.end_gateway()
        with socket.create_server(("127.0.0.1", 0)) as given:
            self.address = given.getsockname()
            self.plant.start_gateway(given)
        self.plant.wait_for(rf"^listening http 127\.0\.0\.1:{self.address[1]}$")
        self.assertEqual(self.ask("GET", "/healthz", self.tcp())[0], 200)
        self.assertEqual(self.ask("POST", RELOAD, self.tcp())[0], 403)
        # It stays, whatever the file says.
        self.configure('listen = ["127.0.0.1:0"]')
        self.assertEqual(self.ask("GET", "/healthz", self.tcp())[0], 200)

    def test_there_is_ipv6(self):
        try:
            socket.create_server(("::1", 0), family=socket.AF_INET6).close()
        except OSError as error:
            self.skipTest(f"no IPv6: {error}")
        self.listen(host="::1", shown="[::1]")
        self.assertEqual(self.ask("GET", STATUS, self.tcp())[0], 200)


if __name__ == "__main__":
    sys.exit(unittest.main())
