#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Other programs as clients of mbgated's listeners with TLS: openssl s_client asks for what MB-TCP-Security v36 forbids
and for what it asks for, gnutls-cli is of another implementation of TLS, and Wireshark finds the same Modbus in the
records. A program that is not installed is passed over, and said so."""

import re
import select
import shutil
import socket
import struct
import subprocess
import tempfile
import threading
import unittest

from demo_plant import PATIENCE
from tls_plant import READ, TlsCase, adu, ask

SECURE_PORT = 802
CLOSED = ("-no_ign_eof",)


def needs(name):
    return unittest.skipUnless(shutil.which(name), f"{name} is not installed")


@needs("openssl")
class OpenSsl(TlsCase):
    def s_client(self, *options, listener="secure", certificate=True, given=b""):
        """What openssl s_client prints, and whether it has shaken hands."""
        public, private = self.plant.operator.files(self.plant.folder)
        own = ("-cert", public, "-key", private) if certificate else ()
        command = ["openssl", "s_client", "-connect", f"127.0.0.1:{self.plant.ports[listener]}", "-CAfile",
                   self.plant.folder / "ca.crt", "-verify_return_error", *own, *CLOSED, *options]
        done = subprocess.run(list(map(str, command)), input=given, capture_output=True, timeout=PATIENCE, check=False)
        text = (done.stdout + done.stderr).decode(errors="replace")
        return text, done.returncode == 0 and "Verify return code: 0 (ok)" in text

    def assert_refused(self, *options, **arguments):
        text, done = self.s_client(*options, **arguments)
        self.assertFalse(done, text)
        return text

    def assert_shakes_hands(self, *options, **arguments):
        text, done = self.s_client(*options, **arguments)
        self.assertTrue(done, text)
        return text

    def test_nothing_older_than_1_2(self):
        for version in ("-tls1", "-tls1_1"):
            text = self.assert_refused(version, "-cipher", "DEFAULT:@SECLEVEL=0")
            self.assertIn("alert protocol version", text)

    def test_1_2_and_1_3_with_one_suite_each(self):
        text = self.assert_shakes_hands("-tls1_2")
        self.assertIn("Cipher is ECDHE-ECDSA-AES128-GCM-SHA256", text)
        text = self.assert_shakes_hands("-tls1_2", listener="secure-rsa")
        self.assertIn("Cipher is ECDHE-RSA-AES128-GCM-SHA256", text)
        self.assertIn("Cipher is TLS_AES_128_GCM_SHA256", self.assert_shakes_hands("-tls1_3"))
        self.assert_refused("-tls1_3", "-ciphersuites", "TLS_AES_256_GCM_SHA384")

    def test_no_suite_without_encryption_with_an_old_digest_or_without_a_fresh_key(self):
        for listener, suites in (
            ("secure-rsa", ("NULL-SHA256", "NULL-SHA", "NULL-MD5", "AES128-SHA", "AES128-GCM-SHA256",
                            "ECDHE-RSA-AES128-SHA", "ECDHE-RSA-AES128-SHA256", "ECDHE-RSA-AES256-GCM-SHA384")),
            ("secure", ("ECDHE-ECDSA-NULL-SHA", "ECDHE-ECDSA-AES128-SHA", "AECDH-AES128-SHA", "AECDH-NULL-SHA")),
        ):
            for suite in suites:
                with self.subTest(suite=suite):
                    text = self.assert_refused("-tls1_2", "-cipher", f"{suite}:@SECLEVEL=0", listener=listener)
                    self.assertIn("alert handshake failure", text)

    def test_no_signature_of_a_client_with_sha_1(self):
        self.assert_refused("-tls1_2", "-sigalgs", "ECDSA+SHA1", "-cipher", "DEFAULT:@SECLEVEL=0")

    def test_p_256_is_taken(self):
        for version in ("-tls1_2", "-tls1_3"):
            text = self.assert_shakes_hands(version, "-groups", "P-256")
            self.assertRegex(text, "(Server|Peer) Temp Key: ECDH, prime256v1")  # as OpenSSL 3.0 says it, and 3.5

    def test_a_certificate_is_asked_for_always(self):
        for version in ("-tls1_2", "-tls1_3"):
            text, _ = self.s_client(version, certificate=False)
            self.assertIn("Acceptable client certificate CA names", text)
            self.assertRegex(text, "CN ?= ?root")
        self.assertIn("alert handshake failure", self.s_client("-tls1_2", certificate=False)[0])

    def test_no_compression_and_no_renegotiation(self):
        text = self.assert_shakes_hands("-tls1_2", "-comp")
        self.assertIn("Compression: NONE", text)
        self.assertIn("Secure Renegotiation IS supported", text)
        public, private = self.plant.operator.files(self.plant.folder)
        # A line with R asks for a renegotiation.
        command = ["openssl", "s_client", "-connect", f"127.0.0.1:{self.plant.ports['secure']}", "-tls1_2", "-cert",
                   public, "-key", private]
        client = subprocess.Popen(list(map(str, command)), stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT)
        self.addCleanup(client.stdout.close)
        self.addCleanup(client.wait)
        self.addCleanup(client.kill)
        client.stdin.write(b"R\n")
        client.stdin.close()
        self.assertRegex(client.stdout.read().decode(errors="replace"), "RENEGOTIATING[^$]*no renegotiation")

    def test_no_ticket(self):
        self.assertNotIn("TLS session ticket:", self.assert_shakes_hands("-tls1_2"))

    def test_records_are_as_short_as_the_client_asks(self):
        with socket.create_server(("127.0.0.1", 0)) as listener:
            listener.settimeout(PATIENCE)
            said = []

            def relay():
                client, _ = listener.accept()
                with client, self.plant.plain("secure-rsa") as gateway:
                    client.settimeout(PATIENCE)
                    away = threading.Thread(target=lambda: pass_on(client, gateway, []))
                    away.start()
                    pass_on(gateway, client, said)
                    away.join()

            def pass_on(source, target, kept):
                try:
                    while data := source.recv(65536):
                        kept.append(data)
                        target.sendall(data)
                    target.shutdown(socket.SHUT_WR)
                except OSError:
                    pass

            relaying = threading.Thread(target=relay)
            relaying.start()
            ports = dict(self.plant.ports)
            self.plant.ports["relay"] = listener.getsockname()[1]
            # In TLS 1.2 the certificates are sent without encryption: records are as long as their contents.
            self.assert_shakes_hands("-tls1_2", "-maxfraglen", "512", listener="relay")
            relaying.join()
            self.plant.ports = ports
        stream, sizes = b"".join(said), []
        while stream:
            sizes.append(struct.unpack(">H", stream[3:5])[0])
            stream = stream[5 + sizes[-1]:]
        self.assertEqual(max(sizes), 512)
        self.assertGreater(sum(sizes), 1024)

    def test_modbus_goes_over_it(self):
        public, private = self.plant.operator.files(self.plant.folder)
        command = ["openssl", "s_client", "-quiet", "-connect", f"127.0.0.1:{self.plant.ports['secure']}", "-cert",
                   public, "-key", private]
        with subprocess.Popen(list(map(str, command)), stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL) as client:
            client.stdin.write(adu(READ))
            client.stdin.flush()
            self.assertEqual(client.stdout.read(7 + len(self.answer))[7:], self.answer)
            client.kill()


@needs("gnutls-cli")
class GnuTls(TlsCase):
    def test_another_implementation_shakes_hands(self):
        public, private = self.plant.operator.files(self.plant.folder)
        for version in ("1.2", "1.3"):
            with self.subTest(version=version):
                log = self.plant.folder / "gnutls.log"
                command = ["gnutls-cli", "--port", self.plant.ports["secure"], "--x509cafile",
                           self.plant.folder / "ca.crt", "--x509certfile", public, "--x509keyfile", private,
                           "--priority", f"NORMAL:-VERS-ALL:+VERS-TLS{version}", "--logfile", log, "localhost"]
                with subprocess.Popen(list(map(str, command)), stdin=subprocess.PIPE, stdout=subprocess.PIPE) as client:
                    client.stdin.write(adu(READ))
                    client.stdin.flush()
                    self.assertEqual(client.stdout.read(7 + len(self.answer))[7:], self.answer)
                    client.stdin.close()
                    self.assertEqual(client.wait(PATIENCE), 0)
                self.assertRegex(log.read_text(encoding="utf-8"), rf"TLS{re.escape(version)}.*AES-128-GCM")


@needs("tshark")
class Wireshark(TlsCase):
    def test_the_records_hold_the_same_modbus(self):
        from tshark_test import Recording

        recording = Recording()
        keys = self.plant.folder / "keys.log"
        context = self.plant.context(self.plant.operator)
        context.keylog_filename = str(keys)
        with socket.create_server(("127.0.0.1", 0)) as listener:
            listener.settimeout(PATIENCE)
            relaying = threading.Thread(target=self.relay, args=(listener, recording))
            relaying.start()
            self.plant.ports["relay"] = listener.getsockname()[1]
            with self.plant.connect(context, "relay") as client:
                self.assertEqual(ask(client), self.answer)
                client.unwrap().close()
            relaying.join()
        with tempfile.NamedTemporaryFile(suffix=".pcap") as capture:
            capture.write(recording.pcap)
            capture.flush()
            command = ["tshark", "-r", capture.name, "-o", f"tls.keylog_file:{keys}", "-d",
                       f"tcp.port=={SECURE_PORT},tls", "-d", f"tls.port=={SECURE_PORT},mbtcp", "-Y", "modbus", "-T", "fields", "-e", "modbus.func_code"]
            shown = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=True)
        self.assertEqual(shown.stdout.split(), ["4", "4"], shown.stderr)

    def relay(self, listener, recording):
        """Carries one connection, piece by piece in their order, and records each."""
        client, _ = listener.accept()
        with client, self.plant.plain("secure") as gateway:
            sent = {client: 1, gateway: 1}
            other = {client: gateway, gateway: client}
            ports = {client: (40000, SECURE_PORT), gateway: (SECURE_PORT, 40000)}
            ends = set()
            while len(ends) < 2:
                for source in select.select([it for it in other if it not in ends], [], [], PATIENCE)[0]:
                    data = source.recv(16384)
                    if not data:
                        ends.add(source)
                        other[source].shutdown(socket.SHUT_WR)
                        continue
                    recording.add(ports[source], sent[source], sent[other[source]], data)
                    sent[source] += len(data)
                    other[source].sendall(data)


if __name__ == "__main__":
    unittest.main()
