#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""mbgatectl cert, as OpenSSL, GnuTLS and Python's cryptography see what it has made."""

import pathlib
import re
import shutil
import stat
import subprocess
import tempfile
import unittest

from cryptography import x509

from demo_plant import PATIENCE, program

ROLE = "1.3.6.1.4.1.50316.802.1"


def run(*command, folder, status=0):
    words = [*map(str, command)]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=PATIENCE, check=False)
    if done.returncode != status:
        raise AssertionError(f"{command}: status {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout + done.stderr


class Plant(unittest.TestCase):
    """An authority, a gateway and two clients in a folder."""

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        cls.made = [
            cls.cert("ca", "--name", "Plant 7"),
            cls.cert("server", "gateway", *(f"--address={name}" for name in ("192.0.2.7", "2001:db8::7", "gw.plant"))),
            cls.cert("client", "hmi", "--role", "Operatör \"1\""),
            cls.cert("client", "logger", "--rsa", 2048),
        ]

    @classmethod
    def cert(cls, *arguments, status=0, folder=None):
        return run(program("mbgatectl"), "cert", *arguments, folder=folder or cls.folder, status=status)

    def run_there(self, *command, status=0):
        return run(*command, folder=self.folder, status=status)

    def certificate(self, name):
        return x509.load_pem_x509_certificate((self.folder / f"{name}.crt").read_bytes())


class Files(Plant):
    def test_have_their_modes(self):
        for path in sorted(self.folder.iterdir()):
            wanted = 0o600 if path.suffix == ".key" else 0o644
            self.assertEqual(oct(wanted), oct(stat.S_IMODE(path.stat().st_mode)), path)

    def test_are_told_where_they_go(self):
        authority, server, client, _ = self.made
        self.assertIn("keep it off the gateway", authority)
        self.assertIn("install -o root -g mbgate-tls -m 0640 gateway.key /etc/mbgate/tls/", server)
        self.assertIn("install -m 0644 gateway.crt ca.crt ca.crl /etc/mbgate/certs/", server)
        self.assertIn("--tls --certificate hmi.crt --key hmi.key --authorities ca.crt", client)

    def test_are_replaced_only_on_demand(self):
        before = {path: path.read_bytes() for path in self.folder.iterdir()}
        for arguments, there in (
            (("ca",), "ca.key"),
            (("server", "gateway", "--address", "192.0.2.7"), "gateway.key"),
            (("client", "hmi"), "hmi.key"),
        ):
            told = self.cert(*arguments, status=1)
            self.assertEqual(f"mbgatectl: ./{there} is there already: nothing was made; --force replaces it\n", told)
        self.assertEqual(before, {path: path.read_bytes() for path in self.folder.iterdir()})
        self.cert("client", "again")
        old = (self.folder / "again.key").read_bytes()
        self.cert("client", "again", "--force")
        self.assertNotEqual(old, (self.folder / "again.key").read_bytes())
        self.assertEqual(0o600, stat.S_IMODE((self.folder / "again.key").stat().st_mode))
        self.assertEqual([], list(self.folder.glob("*.new")))

    def test_of_an_authority_come_together(self):
        other = tempfile.TemporaryDirectory()
        self.addCleanup(other.cleanup)
        self.cert("ca", folder=other.name)
        shutil.copy(self.folder / "ca.key", other.name)
        told = self.cert("client", "x", folder=other.name, status=1)
        self.assertEqual("mbgatectl: ./ca.key is not the key of ./ca.crt\n", told)


class Certificates(Plant):
    def test_are_good_for_openssl(self):
        for name, purpose in (("gateway", "sslserver"), ("hmi", "sslclient"), ("logger", "sslclient")):
            told = self.run_there(
                "openssl", "verify", "-x509_strict", "-crl_check", "-CRLfile", "ca.crl", "-CAfile", "ca.crt",
                "-purpose", purpose, f"{name}.crt",
            )  # fmt: skip
            self.assertEqual(f"{name}.crt: OK\n", told)
        self.run_there("openssl", "verify", "-CAfile", "ca.crt", "-purpose", "sslserver", "hmi.crt", status=2)
        self.run_there("openssl", "verify", "-CAfile", "ca.crt", "-purpose", "sslclient", "gateway.crt", status=2)

    def test_of_a_server_are_for_its_addresses(self):
        for option, value, status in (
            ("-verify_ip", "192.0.2.7", 0), ("-verify_ip", "2001:db8::7", 0), ("-verify_hostname", "gw.plant", 0),
            ("-verify_ip", "192.0.2.8", 2), ("-verify_hostname", "gateway", 2),
        ):  # fmt: skip
            self.run_there("openssl", "verify", "-CAfile", "ca.crt", option, value, "gateway.crt", status=status)

    def test_are_good_for_gnutls(self):
        for name in ("gateway", "hmi", "logger"):
            told = self.run_there("certtool", "--verify", "--load-ca-certificate=ca.crt", f"--infile={name}.crt")
            self.assertIn("The certificate is trusted.", told)
        self.assertIn("1.3.6.1.4.1.50316.802.1", self.run_there("certtool", "-i", "--infile=hmi.crt"))
        self.assertIn("Subject Public Key Algorithm: RSA", self.run_there("certtool", "-i", "--infile=logger.crt"))

    def test_have_the_role_as_one_utf8_string(self):
        role = self.certificate("hmi").extensions.get_extension_for_oid(x509.ObjectIdentifier(ROLE))
        text = 'Operatör "1"'.encode()
        self.assertEqual(bytes([0x0C, len(text)]) + text, role.value.value)
        self.assertFalse(role.critical)
        with self.assertRaises(x509.ExtensionNotFound):
            self.certificate("logger").extensions.get_extension_for_oid(x509.ObjectIdentifier(ROLE))
        parsed = self.run_there("openssl", "asn1parse", "-in", "hmi.crt")
        self.assertRegex(parsed, ROLE.replace(".", r"\.") + r"\n.*OCTET STRING +\[HEX DUMP\]:0C0D4F")

    def test_have_keys_as_asked_for(self):
        self.assertEqual("secp256r1", self.certificate("hmi").public_key().curve.name)
        self.assertEqual(2048, self.certificate("logger").public_key().key_size)
        for name in ("ca", "gateway", "hmi", "logger"):
            public = self.run_there("openssl", "pkey", "-in", f"{name}.key", "-pubout")
            self.assertEqual(public, self.run_there("openssl", "x509", "-in", f"{name}.crt", "-noout", "-pubkey"))

    def test_come_with_their_chain(self):
        for name in ("gateway", "hmi", "logger"):
            text = (self.folder / f"{name}.crt").read_text(encoding="ascii")
            own, authority = re.findall(r"-+BEGIN CERTIFICATE-+.*?-+END CERTIFICATE-+\n", text, re.DOTALL)
            self.assertEqual(own + authority, text)
            self.assertEqual((self.folder / "ca.crt").read_text(encoding="ascii"), authority)

    def test_do_not_outlive_their_authority(self):
        told = self.cert("client", "late", "--days", 3651, status=1)
        self.assertRegex(told, r"^mbgatectl: the authority ends on .* UTC, before the certificate would: "
                               r"give --days 36\d\d or less\n$")  # fmt: skip
        self.assertFalse((self.folder / "late.key").exists())

    def test_are_shown(self):
        shown, authority = self.cert("show", "hmi.crt").split("hmi.crt\n")[1:]
        self.assertIn("  subject    CN=Plant 7\n  for        authority\n", authority)
        shown = re.sub(r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d UTC", "TIME", shown)
        shown = shown.replace("824 days", "825 days")  # as soon as a second is over
        shown = re.sub(r"(serial +|SHA-256 +)[0-9a-f]+", r"\1HEX", shown)
        self.assertEqual(
            "  subject    CN=hmi\n"
            "  for        client\n"
            '  role       "Operatör \\"1\\""\n'
            "  issuer     CN=Plant 7\n"
            "  valid      TIME to TIME (825 days left)\n"
            "  key        EC, 256 bits\n"
            "  serial     HEX\n"
            "  SHA-256    HEX\n",
            shown,
        )
        self.assertIn('  role       none: the NULL role, which rules write as ""\n', self.cert("show", "logger.crt"))
        self.assertIn("names      IP Address:192.0.2.7, IP Address:2001:DB8:0:0:0:0:0:7, DNS:gw.plant\n",
                      self.cert("show", "gateway.crt"))  # fmt: skip
        self.assertNotIn("role", self.cert("show", "ca.crt"))
        serial = self.run_there("openssl", "x509", "-in", "hmi.crt", "-noout", "-serial").strip().partition("=")[2]
        self.assertIn(f"serial     {serial.lower()}\n", self.cert("show", "hmi.crt"))
        told = self.cert("show", "hmi.key", status=1)
        self.assertEqual("mbgatectl: hmi.key: is no certificate in PEM: no start line\n", told)
        told = self.cert("show", "nobody.crt", status=1)
        self.assertEqual("mbgatectl: nobody.crt: cannot be read: No such file or directory\n", told)

    def test_with_a_bad_role_are_shown_as_such(self):
        for number, value in enumerate(("ASN1:UTF8String:", "ASN1:IA5String:operator", "DER:0C:02:C3:28")):
            self.run_there("openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes",
                           "-keyout", "bad.pem", "-out", f"bad{number}.pem", "-subj", "/CN=bad",
                           "-addext", "basicConstraints=CA:FALSE", "-addext", f"{ROLE}={value}")  # fmt: skip
            self.assertIn("  role       unreadable: a gateway answers every request with exception 01\n",
                          self.cert("show", f"bad{number}.pem"))  # fmt: skip
        (self.folder / "bad.pem").unlink()


class Revocation(Plant):
    def test_is_seen_by_openssl_and_by_whoever_asks(self):
        told = self.cert("revoke", "logger.crt")
        self.assertRegex(told, r"^Revoked CN=logger\. \./ca\.crl has 1 and must be renewed before ")
        self.assertIn("install -m 0644 ca.crl /etc/mbgate/certs/ && systemctl reload mbgated", told)
        checked = ("openssl", "verify", "-crl_check", "-CRLfile", "ca.crl", "-CAfile", "ca.crt")
        self.assertIn("certificate revoked", self.run_there(*checked, "logger.crt", status=2))
        self.run_there(*checked, "hmi.crt")
        self.assertRegex(self.cert("revoke", "logger.crt", status=1),
                         r"^mbgatectl: logger.crt has been revoked since .* UTC\n$")  # fmt: skip
        text = self.run_there("openssl", "crl", "-in", "ca.crl", "-noout", "-text")
        self.assertIn("CRL Number: \n                2\n", text)
        self.run_there("certtool", "--verify-crl", "--load-ca-certificate=ca.crt", "--infile=ca.crl")
        self.cert("revoke", "hmi.crt")
        self.cert("crl", "--days", 30)
        listed = x509.load_pem_x509_crl((self.folder / "ca.crl").read_bytes())
        self.assertEqual({self.certificate(name).serial_number for name in ("hmi", "logger")},
                         {entry.serial_number for entry in listed})  # fmt: skip
        self.assertEqual(30, (listed.next_update - listed.last_update).days)
        self.assertEqual(4, listed.extensions.get_extension_for_class(x509.CRLNumber).value.crl_number)
        self.assertIn("  valid ", self.cert("show", "ca.crl"))
        self.assertEqual(2, self.cert("show", "ca.crl").count("  revoked "))

    def test_is_the_authoritys_own(self):
        other = tempfile.TemporaryDirectory()
        self.addCleanup(other.cleanup)
        self.cert("ca", folder=other.name)
        self.cert("client", "stranger", folder=other.name)
        path = pathlib.Path(other.name) / "stranger.crt"
        told = self.cert("revoke", path, status=1)
        self.assertEqual(f"mbgatectl: {path} was not signed by ./ca.key: only its own authority can revoke it\n", told)
        self.assertIn("is the authority itself", self.cert("revoke", "ca.crt", status=1))
        shutil.copy(self.folder / "ca.crl", other.name)
        told = self.cert("revoke", "stranger.crt", folder=other.name, status=1)
        self.assertEqual("mbgatectl: ./ca.crl was not signed by ./ca.key\n", told)
        (pathlib.Path(other.name) / "ca.crl").unlink()
        told = self.cert("crl", folder=other.name, status=1)
        self.assertIn("(mbgatectl cert crl --force makes an empty one)", told)
        self.cert("crl", "--force", folder=other.name)


class Usage(Plant):
    def test_is_told(self):
        role = ("client", "x", "--role")
        server = ("server", "x", "--address")
        no_address = "is neither an IP address nor a host name"
        for arguments, told in (
            (("client", "ca"), '"ca" is the authority\'s own name: choose another'),
            ((*role, ""), "a role is a text of at least one character; without --role the certificate has the NULL "
                          'role, which rules write as ""'),
            ((*role, "a\nb"), "a role is UTF-8 text without control characters, of at most 255 bytes"),
            ((*server, "192.0.2.777"), f'"192.0.2.777" {no_address}'),
            ((*server, "a,DNS:b"), f'"a,DNS:b" {no_address}'),
        ):  # fmt: skip
            self.assertEqual(f"mbgatectl: {told}\n", self.cert(*arguments, status=2))


if __name__ == "__main__":
    unittest.main()
