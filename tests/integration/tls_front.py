# SPDX-License-Identifier: Apache-2.0
"""A server over TLS in front of a plain one: Python's ssl, which shares no code of ours with what is tested. And
certificates that mbgate-cert would not make."""

import contextlib
import datetime
import select
import socket
import ssl
import subprocess
import threading
import unittest

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization

from demo_plant import PATIENCE, program


ROLE = x509.ObjectIdentifier("1.3.6.1.4.1.50316.802.1")


class FrontCase(unittest.TestCase):
    """Certificates in cls.folder, and fronts of cls.plant with them."""

    @classmethod
    def cert(cls, *arguments, folder="."):
        (cls.folder / folder).mkdir(exist_ok=True)
        subprocess.run([program("mbgate-cert"), *arguments], cwd=cls.folder / folder, check=True, timeout=PATIENCE,
                       stdout=subprocess.DEVNULL)  # fmt: skip

    @classmethod
    def revoke(cls, name):
        for what in (("-revoke", name), ("-gencrl", "-out", "ca.crl")):
            subprocess.run(["openssl", "ca", "-config", "ca.cnf", *what], cwd=cls.folder, check=True, timeout=PATIENCE,
                           capture_output=True)  # fmt: skip

    def front(self, *arguments, **words):
        return self.enterContext(TlsFront(self.folder, self.plant.port, *arguments, **words))


class TlsFront:
    """with TlsFront(folder, plain_port) as front: front.port is where it listens on 127.0.0.1, with NAME.crt and
    NAME.key of the folder. Clients need a certificate that ca.crt has signed. front.errors: why handshakes failed; front.versions and
    front.clients: of TLS, and by their names, of those that did not."""

    def __init__(self, folder, plain_port, name="gateway", version=None, authorities="ca.crt"):
        self._plain_port = plain_port
        self._context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        self._context.load_cert_chain(folder / f"{name}.crt", folder / f"{name}.key")
        self._context.load_verify_locations(folder / authorities)
        self._context.verify_mode = ssl.CERT_REQUIRED
        if version is not None:
            self._context.minimum_version = self._context.maximum_version = version
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._threads = []
        self._stop, self._stopped = socket.socketpair()
        self.port = self._listener.getsockname()[1]
        self.errors = []
        self.versions = []
        self.clients = []
        self._open = set()

    def __enter__(self):
        self._start(self._accept)
        return self

    def __exit__(self, *_):
        self._stop.close()
        for thread in self._threads:
            thread.join()
        self._listener.close()
        self._stopped.close()

    def close_all(self):
        """Closes the connections that there are."""
        for secure in list(self._open):
            secure.shutdown(socket.SHUT_RDWR)

    def _start(self, work, *arguments):
        thread = threading.Thread(target=work, args=arguments)
        self._threads.append(thread)
        thread.start()

    def _accept(self):
        while self._stopped not in select.select([self._listener, self._stopped], [], [])[0]:
            client, _ = self._listener.accept()
            self._start(self._serve, client)

    def _serve(self, client):
        client.settimeout(10)
        with contextlib.closing(client):
            try:
                secure = self._context.wrap_socket(client, server_side=True)
            except OSError as error:
                self.errors.append(str(error))
                return
            self.versions.append(secure.version())
            self.clients.append(dict(part[0] for part in secure.getpeercert()["subject"])["commonName"])
            with secure, socket.create_connection(("127.0.0.1", self._plain_port)) as plain:
                self._open.add(secure)
                with contextlib.suppress(OSError):
                    self._carry(secure, plain)
                self._open.discard(secure)

    def _carry(self, secure, plain):
        other = {secure: plain, plain: secure}
        while True:
            ready = [secure] if secure.pending() else select.select([secure, plain, self._stopped], [], [])[0]
            if self._stopped in ready:
                return
            for end in ready:
                data = end.recv(4096)
                if not data:
                    return
                other[end].sendall(data)


def sign(folder, name, begins, ends, alike="gateway", role=None):
    """NAME.crt and NAME.key: the key, name and extensions of another certificate, and another validity in days from
    now. `role`: in DER, instead of the other's."""
    read = (folder / f"{alike}.crt").read_bytes()
    old = x509.load_pem_x509_certificate(read)
    authority = x509.load_pem_x509_certificate((folder / "ca.crt").read_bytes())
    key = serialization.load_pem_private_key((folder / "ca.key").read_bytes(), None)
    now = datetime.datetime.now(datetime.timezone.utc).replace(tzinfo=None)
    builder = x509.CertificateBuilder(
        issuer_name=authority.subject, subject_name=old.subject, public_key=old.public_key(),
        serial_number=x509.random_serial_number(), not_valid_before=now + datetime.timedelta(days=begins),
        not_valid_after=now + datetime.timedelta(days=ends), extensions=list(old.extensions),
    )  # fmt: skip
    if role is not None:
        builder._extensions = [
            x509.Extension(it.oid, it.critical, x509.UnrecognizedExtension(it.oid, role)) if it.oid == ROLE else it
            for it in builder._extensions
        ]
    made = builder.sign(key, hashes.SHA256())
    (folder / f"{name}.crt").write_bytes(made.public_bytes(serialization.Encoding.PEM))
    (folder / f"{name}.key").touch(0o600)
    (folder / f"{name}.key").write_bytes((folder / f"{alike}.key").read_bytes())
