#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""mbgate-signer, asked by somebody who has taken over mbgated: what it signs, and with which keys."""

import hashlib
import os
import pathlib
import socket
import struct
import unittest

from demo_plant import PATIENCE, Plant, Process
from tls_certificates import Authority, new_key, pem, rsa_key

from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec, padding, utils
from cryptography.hazmat.primitives.serialization import (Encoding, NoEncryption, PrivateFormat, load_der_public_key)

HASHES = {"sha256": hashes.SHA256(), "sha384": hashes.SHA384(), "sha512": hashes.SHA512()}
MESSAGE = b"what was said in a handshake"


def digest_info(name, digest):
    """RFC 8017, 9.2, note 1, in DER."""
    if name == "sha1":
        algorithm = bytes.fromhex("06052b0e03021a0500")
    else:
        algorithm = bytes.fromhex("06096086480165030402") + bytes([list(HASHES).index(name) + 1]) + b"\x05\x00"
    algorithm = bytes([0x30, len(algorithm)]) + algorithm
    text = algorithm + bytes([4, len(digest)]) + digest
    return bytes([0x30, len(text)]) + text


def mgf1(name, seed, size):
    made = b"".join(hashlib.new(name, seed + struct.pack(">I", count)).digest() for count in range(size // 20 + 1))
    return made[:size]


def pss(name, message, bits=2048, salt=None, trailer=b"\xbc"):
    """RFC 8017, 9.1.1."""
    digest = hashlib.new(name, message).digest()
    salt = os.urandom(len(digest)) if salt is None else salt
    hashed = hashlib.new(name, bytes(8) + digest + salt).digest()
    block = bytes(bits // 8 - len(salt) - len(hashed) - 2) + b"\x01" + salt
    masked = bytearray(a ^ b for a, b in zip(block, mgf1(name, hashed, len(block))))
    masked[0] &= 0x7F
    return bytes(masked) + hashed + trailer


class SignerPlant(Plant):
    def _start(self):
        self.folder = pathlib.Path(self._folder.name)
        self.keys, self.certificates = self.folder / "tls", self.folder / "certs"
        self.keys.mkdir()
        self.certificates.mkdir()
        self.authority = Authority("plant authority")
        self.write("rsa.key", rsa_key())
        self.write("ec.key", new_key())
        (self.certificates / "ca.crt").write_bytes(pem(self.authority.certificate))

    def write(self, name, key):
        path = self.keys / name
        path.write_bytes(key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()))
        path.chmod(0o600)

    def start(self, *more):
        self.signer = Process(self.folder, "mbgate-signer", "--keys", self.keys, "--certificates", self.certificates,
                              "--socket", self.folder / "signer", *more)
        self._processes.append(self.signer)
        self.signer.wait_for("^listening")


class Case(unittest.TestCase):
    OPTIONS = ()

    def setUp(self):
        self.plant = self.enterContext(SignerPlant())
        self.plant.start(*self.OPTIONS)

    def connect(self):
        asker = self.enterContext(socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET))
        asker.settimeout(PATIENCE)
        asker.connect(str(self.plant.folder / "signer"))
        return asker

    @staticmethod
    def ask(asker, question, content):
        asker.send(question + content)
        answer = asker.recv(4096)
        return answer[:1], answer[1:]

    def opened(self, name):
        """A connection that has this key, and the key's public half."""
        asker = self.connect()
        kind, public = self.ask(asker, b"K", name.encode())
        self.assertEqual(kind, b"K", public)
        return asker, load_der_public_key(public)

    def assert_not_opened(self, name, why):
        kind, text = self.ask(self.connect(), b"K", name.encode())
        self.assertEqual(kind, b"F", "opened")
        self.assertRegex(text.decode(), why)
        self.plant.signer.wait_for(why)

    def assert_refused(self, asker, question, content, why):
        """It is not signed, and the journal says what was asked for and why not."""
        kind, text = self.ask(asker, question, content)
        self.assertEqual(kind, b"F", "signed")
        self.assertRegex(text.decode(), why)
        self.plant.signer.wait_for(rf"not signed: {len(content)} bytes, {why}")


class Rsa(Case):
    def setUp(self):
        super().setUp()
        self.asker, self.public = self.opened("rsa.key")

    def test_signs_what_is_padded_for_pss(self):
        for name, algorithm in HASHES.items():
            kind, signature = self.ask(self.asker, b"N", pss(name, MESSAGE))
            self.assertEqual(kind, b"S", signature)
            padded = padding.PSS(padding.MGF1(algorithm), padding.PSS.DIGEST_LENGTH)
            self.public.verify(signature, MESSAGE, padded, algorithm)

    def test_signs_digests_for_pkcs1(self):
        for name, algorithm in HASHES.items():
            kind, signature = self.ask(self.asker, b"P", digest_info(name, hashlib.new(name, MESSAGE).digest()))
            self.assertEqual(kind, b"S", signature)
            self.public.verify(signature, MESSAGE, padding.PKCS1v15(), algorithm)

    def test_decrypts_nothing(self):
        """A private key that is used on bytes of the asker's choice decrypts, and signs whatever hides in them."""
        hidden = self.public.encrypt(b"a key of a session that was recorded", padding.PKCS1v15())
        self.assert_refused(self.asker, b"N", hidden, "expected a digest .* in the padding of PSS")

    def test_signs_nothing_that_only_looks_padded(self):
        good = pss("sha256", MESSAGE)
        other = {
            "another trailer": pss("sha256", MESSAGE, trailer=b"\xcc"),
            "the highest bit": bytes([good[0] | 0x80]) + good[1:],
            "an octet more": good + b"\xbc",
            "an octet less": good[1:],
            "no salt": pss("sha256", MESSAGE, salt=b""),
            "a long salt": pss("sha256", MESSAGE, salt=bytes(40)),
            "SHA-1": pss("sha1", MESSAGE),
            "one bit": good[:40] + bytes([good[40] ^ 1]) + good[41:],
            "all zero": bytes(256),
            "nothing": b"",
        }
        # PKCS#1 v1.5, padded by the asker: would be a signature with any digest it likes.
        info = digest_info("sha1", hashlib.sha1(MESSAGE).digest())
        other["PKCS#1"] = b"\x00\x01" + b"\xff" * (256 - 3 - len(info)) + b"\x00" + info
        for what, content in other.items():
            with self.subTest(what):
                self.assert_refused(self.asker, b"N", content, "expected a digest")

    def test_signs_no_other_digests_for_pkcs1(self):
        good = digest_info("sha256", hashlib.sha256(MESSAGE).digest())
        other = {
            "SHA-1": digest_info("sha1", hashlib.sha1(MESSAGE).digest()),
            "MD5 and SHA-1, as before TLS 1.2": hashlib.md5(MESSAGE).digest() + hashlib.sha1(MESSAGE).digest(),
            "a bare digest": hashlib.sha256(MESSAGE).digest(),
            "anything": b"anything",
            "another length inside": good[:18] + b"\x21" + good[19:],
            "an octet more": good + b"\x00",
            "nothing": b"",
        }
        for what, content in other.items():
            with self.subTest(what):
                self.assert_refused(self.asker, b"P", content, "expected the DigestInfo of SHA-256")

    def test_answers_no_question_for_another_kind_of_key(self):
        self.assert_refused(self.asker, b"E", bytes(32), "the key is one of RSA")


class Ec(Case):
    def setUp(self):
        super().setUp()
        self.asker, self.public = self.opened("ec.key")

    def test_signs_digests(self):
        for name, algorithm in HASHES.items():
            kind, signature = self.ask(self.asker, b"E", hashlib.new(name, MESSAGE).digest())
            self.assertEqual(kind, b"S", signature)
            self.public.verify(signature, hashlib.new(name, MESSAGE).digest(), ec.ECDSA(utils.Prehashed(algorithm)))
            with self.assertRaises(InvalidSignature):
                self.public.verify(signature, b"another message", ec.ECDSA(algorithm))

    def test_signs_nothing_else(self):
        for size in (0, 1, 20, 28, 31, 33, 36, 63, 65, 256):
            with self.subTest(size):
                self.assert_refused(self.asker, b"E", bytes(size), "expected a digest of 32, 48 or 64 bytes")

    def test_answers_no_question_for_another_kind_of_key(self):
        for question in (b"N", b"P"):
            self.assert_refused(self.asker, question, bytes(32), "the key is one of EC")


class Keys(Case):
    def test_are_those_that_end_so_unless_it_is_told_which(self):
        for name in ("old.key.bak", "another.pem", "key"):
            self.plant.write(name, new_key())
            self.assert_not_opened(name, rf"{name}: mbgate-signer may use \*\.key: give --key {name} in its unit")
        self.opened("ec.key")

    def test_are_not_those_of_an_authority(self):
        self.plant.write("ca.key", self.plant.authority.key)
        self.assert_not_opened("ca.key", r"ca\.key: is the key of an authority, whose certificate is .*/certs/ca\.crt: "
                                         "it does not belong on a gateway")

    def test_are_not_those_of_an_authority_whose_certificate_lies_beside_them(self):
        inner = Authority("inner", self.plant.authority)
        self.plant.write("inner.key", inner.key)
        self.opened("inner.key")  # nobody knows
        certificate = self.plant.authority.issue("gateway", server=True)
        chain = self.plant.keys / "gateway.pem"
        chain.write_bytes(b"no certificate\n" + pem(certificate.certificate) + pem(inner.certificate))
        self.assert_not_opened("inner.key", r"is the key of an authority, whose certificate is .*/tls/gateway\.pem")
        self.plant.write("gateway.key", certificate.key)
        self.opened("gateway.key")

    def test_are_not_those_of_an_authority_that_has_its_certificate_in_the_same_file(self):
        inner = Authority("inner", self.plant.authority)
        self.plant.write("inner.key", inner.key)
        with (self.plant.keys / "inner.key").open("ab") as file:
            file.write(pem(inner.certificate))
        self.assert_not_opened("inner.key", r"is the key of an authority, whose certificate is .*/tls/inner\.key")

    def test_a_connection_whose_key_is_refused_signs_nothing(self):
        asker, _ = self.opened("ec.key")
        self.assertEqual(self.ask(asker, b"K", b"other.pem")[0], b"F")
        self.assertEqual(self.ask(asker, b"E", bytes(32)), (b"F", b"no key was opened"))


class Named(Case):
    OPTIONS = ("--key", "rsa.key", "--key", "axis-*.pem")

    def test_only_they_are_used(self):
        self.plant.write("axis-1.pem", new_key())
        self.opened("rsa.key")
        self.opened("axis-1.pem")
        self.assert_not_opened("ec.key", r"ec\.key: mbgate-signer may use rsa\.key, axis-\*\.pem: give --key ec\.key")


class Socket(Case):
    def test_is_for_its_owner_alone(self):
        self.assertEqual((self.plant.folder / "signer").stat().st_mode & 0o777, 0o600)


if __name__ == "__main__":
    unittest.main()
