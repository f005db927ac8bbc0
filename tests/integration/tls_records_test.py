#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A client of a TLS listener sends records that carry nothing, as many as it can: it is ended, the journal says why, and
nobody else notices."""

import struct
import threading
import unittest

from tls_certificates import utf8
from tls_plant import READ, TlsCase, adu, receive
from tls_records import CLIENT_HELLO, DATA, HANDSHAKE, VERSIONS, Records
from tls_test import stopped

MANY = 3000
FEW = 60
TOO_MANY = "more than 100 records without data within a second"


class WithoutData(TlsCase):
    def setUp(self):
        super().setUp()
        self.viewer = self.plant.authority.issue("viewer", [utf8("Viewer")])
        self.other = self.use(self.plant.client())

    def records(self, version):
        context = self.plant.context(self.viewer, version)
        context.minimum_version = version
        return Records(self.use(self.plant.plain("secure")), context)

    def pump(self, raw, sent):
        """Sends, and takes what comes, on threads of their own."""

        def send():
            try:
                raw.sendall(sent)
            except OSError:
                pass

        for work, arguments in ((send, ()), (self.assert_ended, (raw,))):
            thread = threading.Thread(target=work, args=arguments)
            thread.start()
            self.addCleanup(thread.join)

    def assert_only_it_is_ended(self, raw, sent, why=f"its TLS was ended: {TOO_MANY}"):
        self.pump(raw, sent)
        for _ in range(100):
            self.assert_served(self.other)
        self.refusal(why)
        self.assert_served(self.other)

    def receive_record(self, raw):
        """Its kind and size."""
        kind, size = struct.unpack(">BxxH", receive(raw, 5))
        self.assertEqual(len(receive(raw, size)), size)
        return kind, size

    def test_new_keys_and_renegotiations_without_end(self):
        for version in VERSIONS:
            with self.subTest(version=version):
                client = self.records(version)
                self.assert_only_it_is_ended(client.raw, b"".join(client.without_data() for _ in range(MANY)))

    def test_empty_records_without_end(self):
        """A read between them does not make them fewer."""
        for version in VERSIONS:
            with self.subTest(version=version):
                client = self.records(version)
                sent = b""
                for _ in range(MANY // 10):
                    sent += b"".join(client.record(DATA) for _ in range(10)) + client.record(DATA, adu(READ))
                self.assert_only_it_is_ended(client.raw, sent)

    def test_a_handshake_in_pieces_needs_no_certificate(self):
        hello = CLIENT_HELLO[:1] + struct.pack(">I", 2 * MANY)[1:] + bytes(MANY)
        sent = b"".join(struct.pack(">BHHB", HANDSHAKE, 0x0301, 1, byte) for byte in hello)
        self.assert_only_it_is_ended(self.use(self.plant.plain("secure")), sent, f"no TLS handshake: {TOO_MANY}")

    def test_broken_records_are_told(self):
        client = self.records(VERSIONS[1])
        client.raw.sendall(client.record(DATA, adu(READ))[:-1] + b"x")
        self.refusal("its TLS was ended: decryption failed or bad record mac")

    def test_a_few_do_no_harm(self):
        for version in VERSIONS:
            with self.subTest(version=version):
                client = self.records(version)
                sent = b"".join(client.without_data() for _ in range(FEW))
                client.raw.sendall(sent + client.record(DATA, adu(READ)))
                # TLS 1.2: an alert for each. TLS 1.3: the number of the session. Then the answer.
                for _ in range(FEW if version == VERSIONS[0] else 1):
                    self.receive_record(client.raw)
                seal = 24 if version == VERSIONS[0] else 17
                self.assertEqual(self.receive_record(client.raw), (DATA, 7 + len(self.answer) + seal))

    def test_what_has_come_while_the_gateway_was_stopped(self):
        client = self.records(VERSIONS[1])
        with stopped(self.plant.gateway):
            self.pump(client.raw, b"".join(client.without_data() for _ in range(MANY)))
            self.other.sendall(adu(READ))
        self.refusal(TOO_MANY)
        self.assertEqual(receive(self.other, 11)[7:], self.answer)

    def test_the_gateway_ends_beside_them(self):
        for client in [self.records(version) for version in VERSIONS]:
            self.pump(client.raw, b"".join(client.without_data() for _ in range(MANY)))
        self.plant._processes.remove(self.plant.gateway)
        self.assertEqual(self.plant.gateway.end(), 0)


if __name__ == "__main__":
    unittest.main()
