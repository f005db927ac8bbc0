#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Access rules over real TLS: what clients of different roles may do, and that an address which may nothing gets no byte.
Python's ssl is the client."""

import socket
import ssl
import struct
import unittest

from demo_plant import PATIENCE
from tls_certificates import utf8
from tls_plant import READ, TlsCase, adu, answer_of, ask

VERSIONS = (ssl.TLSVersion.TLSv1_2, ssl.TLSVersion.TLSv1_3)
SECOND = struct.pack(">BHH", 4, 1, 1)  # the second register of the status unit
CLEAR = struct.pack(">BHH", 8, 10, 0)  # its counters begin anew: a write
WRITE = struct.pack(">BHH", 6, 0, 1)  # of a drive on the line, which is not there: 0A
WRITES = [CLEAR, WRITE] + list(map(bytes.fromhex, (
    "05 0000 FF00", "0F 0000 0008 01 FF", "10 0000 0001 02 0001", "16 0000 FFFF 0001", "17 0000 0001 0000 0001 02 0001",
    "15 09 06 0001 0000 0001 0001", "41 00 01")))  # fmt: skip
LINE = 1  # a unit on the line
RULES = """
[[group]]
name = "hall"
addresses = ["127.0.0.1"]

[[rule]]
name = "nobody-writes-the-last"
registers = ["holding 0xFFFF"]
any_role = true
action = "deny"

[[rule]]
name = "operators"
clients = ["hall"]
roles = ["Operator"]
action = "permit"

[[rule]]
name = "viewers"
clients = ["hall"]
roles = ["Viewer"]
access = "read"
action = "permit"

[[rule]]
name = "the-null-role"
clients = ["hall"]
roles = [""]
units = [255]
registers = ["input 0"]
action = "permit"
"""


def exception(pdu, code):
    return bytes([pdu[0] | 0x80, code])


def first_bytes():
    """What a client of TLS says before anybody else does."""
    incoming, outgoing = ssl.MemoryBIO(), ssl.MemoryBIO()
    client = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT).wrap_bio(incoming, outgoing, server_hostname="localhost")
    try:
        client.do_handshake()
    except ssl.SSLWantReadError:
        pass
    return outgoing.read()


class RulesCase(TlsCase):
    def change(self, old="", new="", rules=""):
        """Another configuration is in force, and it is another one."""
        self.reconfigure(old, new, 1, rules, "reload: done")

    def answers_of(self, address):
        """All that the TLS listener says to a client at this address which begins a handshake; b"" if it ends it."""
        here = (address, 0)
        with socket.create_connection(("127.0.0.1", self.plant.ports["secure"]), PATIENCE, source_address=here) as raw:
            try:
                raw.sendall(first_bytes())
                return raw.recv(4096)
            except ConnectionError:
                return b""


class Roles(RulesCase):
    def setUp(self):
        super().setUp()
        self.change(rules=RULES)

    def answers_to(self, roles, version):
        """Whether each of the requests was permitted: "+", or "-" for exception 01."""
        client = self.use(self.plant.client(self.plant.authority.issue("client", roles), version))
        said = ""
        for pdu, permitted in ((READ, self.answer), (SECOND, None), (CLEAR, CLEAR)):
            answer = ask(client, pdu)
            if answer != exception(pdu, 1):
                self.assertEqual(answer, permitted or answer)
                self.assertEqual(answer[0], pdu[0])
            said += "-" if answer == exception(pdu, 1) else "+"
        client.sendall(adu(WRITE, unit=LINE))
        answer = answer_of(client)
        self.assertIn(answer, (exception(WRITE, 1), exception(WRITE, 10)))
        return said + ("-" if answer == exception(WRITE, 1) else "+")

    def test_decide_what_a_client_may_do(self):
        for version in VERSIONS:
            for roles, expected in (([utf8("Operator")], "++++"), ([utf8("Viewer")], "++--"), ([], "+---"),
                                    ([utf8("Guest")], "----"), ([utf8("operator")], "----")):  # fmt: skip
                with self.subTest(version=version, roles=roles):
                    self.assertEqual(self.answers_to(roles, version), expected)
        self.plant.gateway.wait_for(r'client 127\.0\.0\.1 \(role "Viewer".*\): function 8 at unit 255, sub-function 10, denied by '
                                    "the access rules: no rule permits it$")

    def test_a_denied_request_gets_01_alone_and_the_session_goes_on(self):
        permitted = struct.pack(">BHH", 4, 1, 1)
        for version in VERSIONS:
            client = self.use(self.plant.client(self.plant.authority.issue("client", [utf8("Viewer")]), version))
            for pdu in WRITES:
                with self.subTest(version=version, pdu=pdu.hex(" ")):
                    client.sendall(adu(pdu, unit=LINE))
                    self.assertEqual(answer_of(client), exception(pdu, 1))
                    self.assertEqual(ask(client, permitted)[0], 4)

    def test_no_role_is_built_in(self):
        permitted = "++++"
        self.change('"Operator"', '"Schichtf\u00fchrer 2"')
        for role in ("Operator", "Engineer", "Administrator", "admin", "root"):
            self.assertEqual(self.answers_to([utf8(role)], VERSIONS[1]), "----", role)
        self.assertEqual(self.answers_to([utf8("Schichtf\u00fchrer 2")], VERSIONS[1]), permitted)
        self.change('"Schichtf\u00fchrer 2"', '"Operator"')
        self.assertEqual(self.answers_to([utf8("Schichtf\u00fchrer 2")], VERSIONS[1]), "----")
        self.assertEqual(self.answers_to([utf8("Operator")], VERSIONS[1]), permitted)

    def test_the_role_follows_a_session_that_is_taken_up_again(self):
        for version in VERSIONS:
            with self.subTest(version=version):
                context = self.plant.context(self.plant.authority.issue("client", [utf8("Viewer")]), version)
                first = self.use(self.plant.connect(context))
                self.assert_served(first)
                again = self.use(self.plant.connect(context, session=first.session))
                self.assert_served(again)
                self.assertTrue(again.session_reused)
                self.assertEqual(ask(again, CLEAR), exception(CLEAR, 1))

    def test_any_role_denies_it_to_all(self):
        last = struct.pack(">BHH", 6, 0xFFFF, 1)
        client = self.use(self.plant.client())
        client.sendall(adu(last, unit=LINE))
        self.assertEqual(answer_of(client), exception(last, 1))
        self.plant.gateway.wait_for(r'denied by rule "nobody-writes-the-last" \(')

    def test_a_reload_holds_for_sessions_that_are_open(self):
        client = self.use(self.plant.client())
        self.assertEqual(ask(client, CLEAR), CLEAR)
        self.change('roles = ["Operator"]', 'roles = ["Operator"]\naccess = "read"')
        self.assertEqual(ask(client, CLEAR), exception(CLEAR, 1))
        self.assert_served(client)

    def test_without_a_certificate_there_is_no_role(self):
        plain = self.use(self.plant.plain())
        self.assert_ended(plain)  # its address stands only beside roles
        self.plant.gateway.wait_for(r"client 127\.0\.0\.1 refused: no access rule permits its address anything")


class Doors(RulesCase):
    def test_an_address_outside_allow_gets_no_byte(self):
        self.change('tls = "ec"', 'tls = "ec"\nallow = ["127.0.0.1"]')
        self.assertEqual(self.answers_of("127.0.0.2"), b"")
        self.plant.gateway.wait_for(r"client 127\.0\.0\.2 refused: not in the allow list")
        self.assertEqual(self.answers_of("127.0.0.1")[:1], b"\x16")  # ServerHello

    def test_an_address_that_no_rule_permits_anything_gets_no_byte(self):
        self.change(rules=RULES)
        self.assertEqual(self.answers_of("127.0.0.2"), b"")
        self.plant.gateway.wait_for(r"client 127\.0\.0\.2 refused: no access rule permits its address anything")
        self.assertEqual(self.answers_of("127.0.0.1")[:1], b"\x16")


if __name__ == "__main__":
    unittest.main()
