# SPDX-License-Identifier: Apache-2.0
"""Certificates for tests of TLS, made anew for each: an authority, those that it signs, its list of revoked ones."""

import datetime
import functools
import ipaddress
import sys

try:
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes, serialization
    from cryptography.hazmat.primitives.asymmetric import ec, rsa
    from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID
except ImportError:
    print("skipped: no python3-cryptography")
    sys.exit(77)

ROLE = x509.ObjectIdentifier("1.3.6.1.4.1.50316.802.1")
DAY = datetime.timedelta(days=1)
HALF_MINUTE = datetime.timedelta(seconds=30)


def utf8(text):
    """A UTF8String in DER, of less than 128 bytes."""
    data = text.encode()
    return bytes([0x0C, len(data)]) + data


@functools.cache
def rsa_key():
    """One for all of a program: to make one takes a processor half a second."""
    return rsa.generate_private_key(public_exponent=65537, key_size=2048)


def new_key(kind="ec"):
    return ec.generate_private_key(ec.SECP256R1()) if kind == "ec" else rsa_key()


def name_of(text):
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, text)])


def pem(certificate):
    return certificate.public_bytes(serialization.Encoding.PEM)


class Certificate:
    """A certificate and its key; `files(folder)` writes both, and says where."""

    def __init__(self, name, key, certificate, chain=()):
        self.name, self.key, self.certificate, self.chain = name, key, certificate, chain

    def files(self, folder):
        certificate, key = folder / f"{self.name}.crt", folder / f"{self.name}.key"
        certificate.write_bytes(b"".join(map(pem, (self.certificate, *self.chain))))
        key.write_bytes(self.key.private_bytes(
            serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()))
        key.chmod(0o600)
        return certificate, key


class Authority:
    def __init__(self, name="authority", signer=None):
        self.key, self.name = new_key(), name_of(name)
        self.revoked = []
        issuer = signer or self
        self.certificate = (
            self._builder(self.name, self.key, issuer.name, datetime.timedelta(days=365))
            .add_extension(x509.BasicConstraints(ca=True, path_length=None), critical=True)
            .add_extension(x509.KeyUsage(False, False, False, False, False, True, True, False, False), critical=True)
            .sign(issuer.key, hashes.SHA256()))

    @staticmethod
    def _builder(name, key, issuer, lasts):
        now = datetime.datetime.now(datetime.UTC)
        return (x509.CertificateBuilder().subject_name(name).issuer_name(issuer).public_key(key.public_key())
                .serial_number(x509.random_serial_number()).not_valid_before(now - DAY).not_valid_after(now + lasts))

    def issue(self, name, roles=(), kind="ec", server=False, lasts=90 * DAY, chain=()):
        """`roles`: the values of the extension of roles, in DER."""
        key = new_key(kind)
        usage = ExtendedKeyUsageOID.SERVER_AUTH if server else ExtendedKeyUsageOID.CLIENT_AUTH
        builder = self._builder(name_of(name), key, self.name, lasts)
        extensions = [(x509.BasicConstraints(ca=False, path_length=None), True)]
        extensions.append((x509.ExtendedKeyUsage([usage]), False))
        if server:
            address = x509.IPAddress(ipaddress.ip_address("127.0.0.1"))
            extensions.append((x509.SubjectAlternativeName([address, x509.DNSName("localhost")]), False))
        extensions += [(x509.UnrecognizedExtension(ROLE, value), False) for value in roles]
        # add_extension() would not take the same one twice.
        builder._extensions = [x509.Extension(value.oid, critical, value) for value, critical in extensions]
        return Certificate(name, key, builder.sign(self.key, hashes.SHA256()), chain)

    def crl(self, ends=DAY):
        """The list of self.revoked, in PEM. It was made a day ago."""
        now = datetime.datetime.now(datetime.UTC)
        builder = x509.CertificateRevocationListBuilder().issuer_name(self.name)
        builder = builder.last_update(now - DAY).next_update(now + ends)
        for certificate in self.revoked:
            builder = builder.add_revoked_certificate(
                x509.RevokedCertificateBuilder().serial_number(certificate.certificate.serial_number)
                .revocation_date(now - DAY).build())
        return builder.sign(self.key, hashes.SHA256()).public_bytes(serialization.Encoding.PEM)
