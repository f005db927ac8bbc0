#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""mbgatectl read and write over TLS, with a server of Python's ssl in front of the demo's gateway."""

import pathlib
import socket
import ssl
import subprocess
import tempfile
import unittest

from demo_plant import PATIENCE, DemoPlant, program
from tls_front import FrontCase, sign

USER_REGISTERS = 60  # of the MOONS' drive: any value


class Requests(FrontCase):
    @classmethod
    def setUpClass(cls):
        cls.plant = cls.enterClassContext(DemoPlant())
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        for arguments in (("ca",), ("server", "gateway", "--address", "127.0.0.1"), ("client", "hmi", "--role", "eng"),
                          ("server", "other", "--address", "gw.plant", "--rsa", "2048")):  # fmt: skip
            cls.cert(*arguments)
        (cls.folder / "elsewhere").mkdir()
        cls.cert("ca", "--directory", "elsewhere")
        cls.cert("client", "stranger", "--directory", "elsewhere")
        sign(cls.folder, "expired", -30, -1)
        sign(cls.folder, "early", 1, 30)
        sign(cls.folder, "late", -30, -1, "hmi")
        sign(cls.folder, "bad", -1, 30, "hmi", b"\x16\x03eng")  # an IA5String

    def ask(self, port, *arguments, name="read", client="hmi", **files):
        files = {"certificate": f"{client}.crt", "key": f"{client}.key", "authorities": "ca.crt", **files}
        words = [program("mbgatectl"), name, *map(str, arguments), "--port", str(port), "--tls",
                 *(f"--{option}={file}" for option, file in files.items())]  # fmt: skip
        return subprocess.run(words, cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE, check=False)

    def printed(self, *arguments, **words):
        done = self.ask(*arguments, **words)
        self.assertEqual((0, ""), (done.returncode, done.stderr))
        return done.stdout

    def refused(self, *arguments, **words):
        done = self.ask(*arguments, **words)
        self.assertEqual((1, ""), (done.returncode, done.stdout))
        return done.stderr

    def cannot(self, port, why):
        return f"mbgatectl: cannot connect to 127.0.0.1:{port}: {why}\n"

    def test_are_answered_over_each_version(self):
        for version in (ssl.TLSVersion.TLSv1_2, ssl.TLSVersion.TLSv1_3):
            front = self.front(version=version)
            place = ("holding", USER_REGISTERS, "--type", "i32")
            self.printed(front.port, *place, -70000 - version, name="write")
            self.assertEqual(f"{-70000 - version}\n", self.printed(front.port, *place, "--quiet"))
            self.assertEqual([{"TLSv1_2": "TLSv1.2", "TLSv1_3": "TLSv1.3"}[version.name]] * 2, front.versions)
        self.assertNotIn("60: ", self.printed(self.front().port, "holding", 0, "--count", 60))

    def test_are_repeated_on_one_connection(self):
        front = self.front()
        self.printed(front.port, "holding", 0, "--every", "10ms", "--times", 20, "--quiet")
        self.assertEqual(1, len(front.versions))

    def test_are_sent_to_no_server_of_another_name(self):
        front = self.front("other")
        why = "certificate verify failed: IP address mismatch: the server's certificate is not for 127.0.0.1; " \
              "if this is the right server, give --server-name"  # fmt: skip
        self.assertEqual(self.cannot(front.port, why), self.refused(front.port, "holding", 0))
        self.printed(front.port, "holding", 0, "--server-name", "gw.plant")
        why = "certificate verify failed: hostname mismatch: the server's certificate is not for plant; " \
              "if this is the right server, give --server-name"  # fmt: skip
        told = self.refused(front.port, "holding", 0, "--server-name", "plant")
        self.assertEqual(self.cannot(front.port, why).lower(), told.lower())

    def test_are_sent_to_no_server_out_of_its_time(self):
        for name, why in (("expired", "certificate has expired"), ("early", "certificate is not yet valid")):
            front = self.front(name)
            told = self.refused(front.port, "holding", 0)
            self.assertEqual(self.cannot(front.port, f"certificate verify failed: {why}"), told)

    def test_are_sent_to_no_server_of_another_authority(self):
        front = self.front()
        told = self.refused(front.port, "holding", 0, authorities="elsewhere/ca.crt")
        self.assertIn(f"cannot connect to 127.0.0.1:{front.port}: certificate verify failed: ", told)
        self.assertIn(": no authority in elsewhere/ca.crt has signed the server's certificate\n", told)

    def test_tell_why_our_certificate_is_refused(self):
        for version in (ssl.TLSVersion.TLSv1_2, ssl.TLSVersion.TLSv1_3):
            front = self.front(version=version)
            told = self.refused(front.port, "holding", 0, client="late")
            self.assertIn("the server refused our certificate: certificate expired", told)
            told = self.refused(front.port, "holding", 0, client="elsewhere/stranger")
            self.assertRegex(told, "the server refused our certificate: (unknown CA|decrypt error|bad certificate)")

    def test_tell_where_there_is_no_tls(self):
        with socket.create_server(("127.0.0.1", 0)) as silent:
            told = self.refused(silent.getsockname()[1], "holding", 0, "--timeout", "200ms")
            self.assertIn("the server did not answer the TLS handshake in time", told)
        told = self.refused(self.plant.port, "holding", 0)
        why = "the server closed the connection: does it speak TLS at this port?"
        self.assertEqual(self.cannot(self.plant.port, why), told)
        told = self.refused(1, "holding", 0)
        self.assertEqual(self.cannot(1, "Connection refused"), told)

    def test_that_are_not_allowed_name_the_role(self):
        front = self.front()
        for client, role in (("hmi", '"eng"'), ("bad", "unreadable: a gateway answers every request with exception 01")):
            told = self.refused(front.port, "holding", 0, 1, name="write", client=client, *("--unit", 255))
            self.assertIn(f"the role in {client}.crt is {role}", told)

    def test_need_files(self):
        for files, why in (
            ({"key": "gateway.key"}, "gateway.key: key values mismatch"),
            ({"certificate": "none.crt"}, "none.crt: No such file or directory"),
            ({"authorities": "hmi.key"}, "hmi.key: no certificate or crl found"),
        ):
            self.assertEqual(self.cannot(1, why), self.refused(1, "holding", 0, **files))


if __name__ == "__main__":
    unittest.main()
