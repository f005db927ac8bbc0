#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A bus that is a Modbus TCP server over TLS: Python's ssl in front of the demo's gateway, and a gateway in front of
that. The private key is with mbgate-signer."""

import contextlib
import pathlib
import socket
import ssl
import subprocess
import tempfile
import threading
import time
import unittest

from demo_plant import PATIENCE, DemoPlant, Process, program
from tls_front import FrontCase, sign
from tls_records import VERSIONS, Records

USER_REGISTERS = 60  # of the MOONS' drive: any value
NEAR = """
[gateway]
signer = "{folder}/signer"
[http]
socket = ""
[[tls]]
name = "plant"
certificate = "{client}.crt"
key = "{client}.key"
authorities = "ca.crt"
crl = "ca.crl"
[[listen]]
name = "near"
address = "127.0.0.1"
port = 0
bus = "far"
[[bus]]
name = "far"
mode = "tcp"
host = "127.0.0.1"
port = {port}
tls = "plant"
connect_timeout = "2s"
"""


class Bus(FrontCase):
    @classmethod
    def setUpClass(cls):
        cls.plant = cls.enterClassContext(DemoPlant())
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        for arguments in (("ca",), ("server", "gateway", "--address", "127.0.0.1"), ("client", "near", "--role", "gw"),
                          ("client", "near-rsa", "--rsa", "2048"), ("server", "other", "--address", "gw.plant"),
                          ("server", "revoked", "--address", "127.0.0.1")):  # fmt: skip
            cls.cert(*arguments)
        cls.revoke("revoked.crt")
        sign(cls.folder, "expired", -30, -1)
        sign(cls.folder, "late", -30, -1, "near")
        cls.signer = cls.enterClassContext(Signer(cls.folder))

    def near(self, port, client="near", more=""):
        """A gateway whose only bus is at this port, and where it listens."""
        file = self.folder / "near.toml"
        file.write_text(NEAR.format(folder=self.folder, client=client, port=port) + more, encoding="utf-8")
        gateway = Process(self.folder, "mbgated", "--config", file)
        self.addCleanup(lambda: self.assertEqual(0, gateway.end()))
        gateway.port = int(gateway.wait_for(r"listening near 127\.0\.0\.1:(\d+)$").group(1))
        return gateway

    def ask(self, gateway, *arguments):
        words = [program("mbgatectl"), *map(str, arguments), "--port", str(gateway.port)]
        done = subprocess.run(words, capture_output=True, text=True, timeout=PATIENCE, check=False)
        self.assertEqual((0, ""), (done.returncode, done.stderr))
        return done.stdout

    def lost(self, gateway):
        """Why the bus is lost, by the journal."""
        return gateway.wait_for(r"far.*cannot connect to tcp://127\.0\.0\.1:\d+: (.*)$").group(1)

    def test_carries_reads_and_writes(self):
        for version in (ssl.TLSVersion.TLSv1_2, ssl.TLSVersion.TLSv1_3):
            for client in ("near", "near-rsa"):
                front = self.front(version=version)
                gateway = self.near(front.port, client)
                place = ("holding", USER_REGISTERS, "--type", "i32")
                self.ask(gateway, "write", *place, version)
                self.assertEqual(f"{int(version)}\n", self.ask(gateway, "read", *place, "--quiet"))
                self.ask(gateway, "read", "holding", 0, "--count", 60, "--every", "10ms", "--times", 20)
                self.assertEqual(1, len(front.versions))
                self.assertEqual([client], front.clients)

    def test_is_opened_again(self):
        front = self.front()
        gateway = self.near(front.port)
        self.ask(gateway, "read", "holding", 0)
        front.close_all()
        self.ask(gateway, "read", "holding", 0)
        self.assertEqual(2, len(front.versions))

    def test_keeps_no_connection_to_the_signer(self):
        gateway = self.near(self.front().port)
        self.ask(gateway, "read", "holding", 0)
        limit = time.monotonic() + PATIENCE
        while self.signer.process.sockets() > 1:  # the one that listens
            self.assertLess(time.monotonic(), limit)
            time.sleep(0.05)
        self.ask(gateway, "read", "holding", 0)

    def test_says_why_the_server_is_not_trusted(self):
        for name, why in (
            ("expired", "certificate verify failed: certificate has expired"),
            ("revoked", "certificate verify failed: certificate revoked"),
            ("other", "certificate verify failed: IP address mismatch: it is not for 127.0.0.1"),
        ):
            self.assertEqual(why, self.lost(self.near(self.front(name).port)))

    def test_does_not_trust_another_authority(self):
        for arguments in (("ca", "--name", "Strangers"), ("server", "gateway", "--address", "127.0.0.1")):
            self.cert(*arguments, folder="strangers")
        front = self.front("strangers/gateway")
        why = self.lost(self.near(front.port))
        self.assertEqual("certificate verify failed: self-signed certificate in certificate chain", why)
        self.assertEqual([], front.clients)

    def test_expects_another_name_where_it_is_told_to(self):
        gateway = self.near(self.front("other").port, more='server_name = "gw.plant"\n')
        self.ask(gateway, "read", "holding", 0)

    def test_says_why_it_is_not_trusted(self):
        gateway = self.near(self.front(version=ssl.TLSVersion.TLSv1_2).port, "late")
        self.assertRegex(self.lost(gateway), "alert certificate expired")
        gateway = self.near(self.front(version=ssl.TLSVersion.TLSv1_3).port, "late")
        gateway.wait_for("far.*alert certificate expired")
        self.assertRegex("".join(gateway.printed), r"\[\[tls\]\] plant: the certificate expired at ")

    def test_says_which_file_is_wrong(self):
        self.assertRegex(self.lost(self.near(self.front().port, "nobody")), f"^{self.folder}/nobody.crt: ")
        words = [program("mbgated"), "--check", "--config", self.folder / "near.toml"]
        checked = subprocess.run(words, capture_output=True, text=True, timeout=PATIENCE, check=False)
        self.assertIn(f"[[tls]] plant: {self.folder}/nobody.crt: ", checked.stdout + checked.stderr)

    def test_says_that_there_is_no_tls(self):
        gateway = self.near(self.plant.port)
        self.assertEqual("the server closed the connection during the TLS handshake", self.lost(gateway))

    def pump(self, version):
        """The port of a server that sends its first client records without data, as many as it can."""
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(self.folder / "gateway.crt", self.folder / "gateway.key")
        context.minimum_version = context.maximum_version = version
        listener = self.enterContext(socket.create_server(("127.0.0.1", 0)))
        listener.settimeout(PATIENCE)

        def serve():
            with listener.accept()[0] as client, contextlib.suppress(OSError):
                client.settimeout(PATIENCE)
                records = Records(client, context, server_side=True)
                client.sendall(b"".join(records.without_data() for _ in range(5000)))

        thread = threading.Thread(target=serve)
        thread.start()
        self.addCleanup(thread.join)
        return listener.getsockname()[1]

    def test_a_server_that_sends_records_without_data_is_left(self):
        for version in VERSIONS:
            gateway = self.near(self.pump(version))
            gateway.wait_for("far.*TLS: the server sends more than 100 records without data within a second")


class Signer:
    """with Signer(folder): mbgate-signer has the keys of the folder."""

    def __init__(self, folder):
        self._folder = folder

    def __enter__(self):
        socket = self._folder / "signer"
        self.process = Process(self._folder, "mbgate-signer", "--keys", self._folder, "--socket", socket)
        self.process.wait_for("^listening ")
        return self

    def __exit__(self, *_):
        self.process.end()


if __name__ == "__main__":
    unittest.main()
