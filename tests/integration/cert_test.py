#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""mbgate-cert, as OpenSSL, GnuTLS, Python's cryptography and a gateway see what it has made."""

import pathlib
import re
import stat
import subprocess
import tempfile
import unittest

from cryptography import x509

from demo_plant import PATIENCE, Process, program

ROLE = "1.3.6.1.4.1.50316.802.1"
OPERATOR = 'Operatör "1"'

CONFIGURATION = """
[gateway]
signer = "{folder}/signer"

[[listen]]
name = "secure"
port = 0
tls = "plant"
bus = "line-a"

[[rule]]
listeners = ["secure"]
roles = ['Operatör "1"']
access = "read"
action = "permit"

[[bus]]
name = "line-a"
device = "no-such-port"
"""


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
        addresses = ("192.0.2.7", "2001:db8::7", "gw.plant", "127.0.0.1")
        cls.made = [
            cls.cert("ca", "--name", "Plant 7/2 + Öl"),
            cls.cert("server", "gateway", *(f"--address={name}" for name in addresses)),
            cls.cert("client", "hmi", "--role", OPERATOR),
            cls.cert("client", "logger", "--rsa", 2048),
        ]

    @classmethod
    def cert(cls, *arguments, status=0):
        return run(program("mbgate-cert"), *arguments, folder=cls.folder, status=status)

    def run_there(self, *command, status=0):
        return run(*command, folder=self.folder, status=status)

    def certificate(self, name):
        return x509.load_pem_x509_certificate((self.folder / f"{name}.crt").read_bytes())


class Files(Plant):
    def test_have_their_modes(self):
        for path in (self.folder / f"{name}.{end}" for name in ("ca", "gateway", "hmi") for end in ("key", "crt")):
            wanted = 0o600 if path.suffix == ".key" else 0o644
            self.assertEqual(oct(wanted), oct(stat.S_IMODE(path.stat().st_mode)), path)
        self.assertEqual([], list(self.folder.glob(".*")))

    def test_are_told_where_they_go(self):
        authority, server, client, other = self.made
        self.assertIn("keep it off\n    the gateway", authority)
        self.assertIn("install -o root -g mbgate-tls -m 0640 gateway.key /etc/mbgate/tls/", server)
        self.assertIn("install -m 0644 gateway.crt ca.crt ca.crl /etc/mbgate/certs/", server)
        self.assertIn(f'Its role is "{OPERATOR}"', client)
        self.assertIn("--tls --certificate hmi.crt --key hmi.key --authorities ca.crt", client)
        self.assertIn('It has the NULL role, ""', other)

    def test_are_replaced_only_on_demand(self):
        before = {path: path.read_bytes() for path in self.folder.iterdir()}
        for arguments, name in ((("ca",), "ca"), (("server", "gateway", "--address", "192.0.2.7"), "gateway"),
                                (("client", "hmi"), "hmi")):
            told = self.cert(*arguments, status=1)
            self.assertEqual(f"mbgate-cert: {name}.key or {name}.crt already exists; --force replaces both\n", told)
        self.assertEqual(before, {path: path.read_bytes() for path in self.folder.iterdir()})
        self.cert("client", "again")
        old = (self.folder / "again.key").read_bytes()
        self.cert("client", "again", "--force")
        self.assertNotEqual(old, (self.folder / "again.key").read_bytes())
        self.assertEqual(0o600, stat.S_IMODE((self.folder / "again.key").stat().st_mode))

    def test_go_where_it_is_said(self):
        (self.folder / "elsewhere").mkdir()
        self.cert("ca", "--directory", "elsewhere")
        self.cert("client", "x", "--directory", "elsewhere")
        self.run_there("openssl", "verify", "-CAfile", "elsewhere/ca.crt", "elsewhere/x.crt")
        self.assertEqual("subject=CN = mbgate plant authority\n",
                         self.run_there("openssl", "x509", "-in", "elsewhere/ca.crt", "-noout", "-subject"))
        (self.folder / "elsewhere/ca.key").write_bytes((self.folder / "ca.key").read_bytes())
        told = self.cert("client", "y", "--directory", "elsewhere", status=1)
        self.assertIn("mbgate-cert: openssl ca: CA certificate and CA private key do not match", told)
        self.assertFalse((self.folder / "elsewhere/y.key").exists())


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
        self.assertIn(ROLE, self.run_there("certtool", "-i", "--infile=hmi.crt"))

    def test_have_what_a_certificate_needs_and_nothing_else(self):
        usage = {"ca": "Certificate Sign, CRL Sign", "gateway": "Digital Signature", "hmi": "Digital Signature"}
        purpose = {"gateway": "TLS Web Server Authentication", "hmi": "TLS Web Client Authentication"}
        for name, wanted in (("ca", {"basicConstraints", "keyUsage", "subjectKeyIdentifier"}),
                             ("gateway", {"basicConstraints", "keyUsage", "subjectKeyIdentifier", "authorityKeyIdentifier",
                                          "extendedKeyUsage", "subjectAltName"}),
                             ("hmi", {"basicConstraints", "keyUsage", "subjectKeyIdentifier", "authorityKeyIdentifier",
                                      "extendedKeyUsage", "Unknown OID"})):
            extensions = self.certificate(name).extensions
            self.assertEqual(wanted, {extension.oid._name for extension in extensions})
            self.assertEqual({"basicConstraints", "keyUsage"}, {it.oid._name for it in extensions if it.critical})
            text = self.run_there("openssl", "x509", "-in", f"{name}.crt", "-noout", "-text")
            self.assertIn("CA:TRUE, pathlen:0" if name == "ca" else "CA:FALSE", text)
            self.assertIn(f"X509v3 Key Usage: critical\n                {usage[name]}\n", text)
            self.assertIn(purpose.get(name, ""), text)
            self.assertIn("Signature Algorithm: ecdsa-with-SHA256", text)
        self.assertEqual("CN=Plant 7/2 \\+ Öl", self.certificate("ca").subject.rfc4514_string())

    def test_are_valid_from_an_hour_ago(self):
        for name, days in (("ca", 3650), ("hmi", 825)):
            lasts = self.certificate(name).not_valid_after - self.certificate(name).not_valid_before
            self.assertEqual((days, 3600), (lasts.days, lasts.seconds // 60 * 60))

    def test_have_the_role_as_one_utf8_string(self):
        for name, role, head in (("hmi", OPERATOR, [0x0C, 13]), ("most", "r" * 255, [0x0C, 0x81, 255]),
                                 ("less", "r" * 127, [0x0C, 127]), ("more", "r" * 128, [0x0C, 0x81, 128])):
            if name != "hmi":
                self.cert("client", name, "--role", role)
            extension = self.certificate(name).extensions.get_extension_for_oid(x509.ObjectIdentifier(ROLE))
            self.assertEqual(bytes(head) + role.encode(), extension.value.value)
            self.assertFalse(extension.critical)
        with self.assertRaises(x509.ExtensionNotFound):
            self.certificate("logger").extensions.get_extension_for_oid(x509.ObjectIdentifier(ROLE))

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

    def test_need_an_authority(self):
        with tempfile.TemporaryDirectory() as empty:
            told = self.cert("client", "hmi", "--directory", empty, status=1)
            self.assertEqual(f"mbgate-cert: there is no ca.crt with ca.key in {empty}: make an authority first "
                             "(mbgate-cert ca)\n", told)

    def test_do_not_outlive_their_authority(self):
        told = self.cert("client", "late", "--days", 3651, status=1)
        self.assertEqual("mbgate-cert: ca.crt does not last for 3651 days: give fewer --days, or make an authority "
                         "(mbgate-cert ca)\n", told)
        self.assertFalse((self.folder / "late.key").exists())


class Revocation(Plant):
    def test_is_as_the_documents_say(self):
        guide = (pathlib.Path(__file__).parents[2] / "docs/tls.md").read_text(encoding="utf-8")
        for command in re.findall(r"^openssl .*", guide, re.MULTILINE):
            self.run_there(*command.partition("#")[0].split())
        checked = ("openssl", "verify", "-crl_check", "-CRLfile", "ca.crl", "-CAfile", "ca.crt")
        self.assertIn("certificate revoked", self.run_there(*checked, "hmi.crt", status=2))
        self.run_there(*checked, "logger.crt")
        self.run_there("certtool", "--verify-crl", "--load-ca-certificate=ca.crt", "--infile=ca.crl")
        listed = x509.load_pem_x509_crl((self.folder / "ca.crl").read_bytes())
        self.assertEqual([self.certificate("hmi").serial_number], [entry.serial_number for entry in listed])
        self.assertEqual(365, (listed.next_update - listed.last_update).days)
        self.assertEqual(2, listed.extensions.get_extension_for_class(x509.CRLNumber).value.crl_number)


class Gateway(Plant):
    """A gateway whose files stand where the script has said, and clients with certificates that it has made."""

    def setUp(self):
        etc = self.folder / "mbgate"
        for name in ("certs", "tls"):
            (etc / name).mkdir(parents=True, exist_ok=True)
        for command in re.findall(r"^  (install .*)", self.made[1], re.MULTILINE):
            self.run_there(*command.replace(" -o root -g mbgate-tls", "").replace("/etc", str(self.folder)).split())
        _, section, rest = self.made[1].partition("  [[tls]]\n")
        text = section + rest.partition("and tls")[0] + CONFIGURATION.format(folder=self.folder)
        (etc / "mbgate.toml").write_text(text, encoding="utf-8")
        signer = Process(self.folder, "mbgate-signer", "--keys", etc / "tls", "--certificates", etc / "certs",
                         "--socket", self.folder / "signer")
        self.addCleanup(signer.end)
        signer.wait_for("^listening")
        gateway = Process(self.folder, "mbgated", "--config", etc / "mbgate.toml")
        self.addCleanup(gateway.end)
        self.port = gateway.wait_for(r"listening secure 127\.0\.0\.1:(\d+)$").group(1)

    def ask(self, client, status):
        return self.run_there(
            program("mbgatectl"), "read", "input", 0, "--unit", 255, "--port", self.port, "--tls", "--certificate",
            f"{client}.crt", "--key", f"{client}.key", "--authorities", "ca.crt", status=status,
        )  # fmt: skip

    def test_takes_them(self):
        for client in ("hmi", "logger"):
            told = self.run_there(
                "openssl", "s_client", "-connect", f"127.0.0.1:{self.port}", "-CAfile", "ca.crt", "-cert", f"{client}.crt",
                "-key", f"{client}.key", "-verify_return_error", "-verify_ip", "127.0.0.1", "-no_ign_eof",
            )  # fmt: skip
            self.assertIn("Verify return code: 0 (ok)", told)

    def test_goes_by_their_roles(self):
        self.ask("hmi", 0)
        self.assertIn('the role in logger.crt is none: the NULL role, which rules write as ""', self.ask("logger", 1))


class Usage(Plant):
    def test_is_told(self):
        role, server = ("client", "x", "--role"), ("server", "x", "--address")
        no_address = "is neither an IP address nor a host name"
        no_role = "is no role, which is UTF-8 text without control characters"
        no_name = "names no certificate: that is letters, digits, '-', '.' and '_', once, such as hmi-1, and not ca"
        more = "mbgate-cert --help says more"
        for arguments, told in (
            ((), f'"" is not ca, server or client: {more}'),
            (("show",), f'"show" is not ca, server or client: {more}'),
            (("client", "ca"), f'"ca" {no_name}'),
            (("client", ".hidden"), f'".hidden" {no_name}'),
            (("client", "a", "b"), f'"b" {no_name}'),
            (("client",), f"client lacks a name or --address: {more}"),
            (("server", "x"), f"server lacks a name or --address: {more}"),
            (("client", "x", "--address", "gw"), f'client does not take "--address": {more}'),
            (("ca", "--days"), '"" is no number of days'),
            (("ca", "--rsa", "1024"), '"1024" is not 2048, 3072 or 4096 bits'),
            ((*role, ""), f'"" {no_role}'),
            ((*role, "a\nb"), f'"a\nb" {no_role}'),
            ((*role, "a\u0085b"), f'"a\u0085b" {no_role}'),
            ((*role, "ö" * 128), "a role has at most 255 bytes"),
            ((*server, "a,DNS:b"), f'"a,DNS:b" {no_address}'),
            ((*server, "a..b"), f'"a..b" {no_address}'),
        ):
            self.assertEqual(f"mbgate-cert: {told}\n", self.cert(*arguments, status=2))
        self.assertIn("bad ip address", self.cert(*server, "192.0.2.777", status=1))
        self.assertEqual(self.cert("--help"), self.cert("client", "x", "--help"))


if __name__ == "__main__":
    unittest.main()
