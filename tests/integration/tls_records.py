# SPDX-License-Identifier: Apache-2.0
"""A connection over TLS whose records are made here, one by one: what no library would send. The handshake is Python's
ssl, which tells its secrets (the NSS key log); the records after it are RFC 5246 and RFC 8446 with AES-GCM."""

import hmac
import pathlib
import ssl
import struct
import tempfile

from cryptography.hazmat.primitives.ciphers.aead import AESGCM

HANDSHAKE, DATA = 22, 23
HELLO_REQUEST, CLIENT_HELLO = bytes(4), b"\x01\x00\x00\x00"  # empty ones
KEY_UPDATE = b"\x18\x00\x00\x01\x00"  # new keys of the sender, none are asked for
VERSIONS = (ssl.TLSVersion.TLSv1_2, ssl.TLSVersion.TLSv1_3)


def expand(secret, label, size, digest):
    """HKDF-Expand-Label of RFC 8446, 7.1, without a context; not more than the digest has."""
    label = b"tls13 " + label
    return hmac.digest(secret, struct.pack(">HB", size, len(label)) + label + b"\x00\x01", digest)[:size]


def prf(secret, seed, digest):
    """P_hash of RFC 5246, 5: enough for keys."""
    made, step = b"", seed
    for _ in range(3):
        step = hmac.digest(secret, step, digest)
        made += hmac.digest(secret, step + seed, digest)
    return made


class Records:
    """After the handshake over `raw` with a context of one version: `record(kind, payload)` is what `raw` may be sent."""

    def __init__(self, raw, context, server_side=False):
        self.raw = raw
        self._hello = HELLO_REQUEST if server_side else CLIENT_HELLO
        with tempfile.TemporaryDirectory() as folder:
            log = pathlib.Path(folder) / "secrets"
            context.keylog_filename = log
            if server_side:
                context.num_tickets = 0  # the first record after the handshake is the first of ours
            self._shake_hands(context, server_side)
            secrets = {line.split()[0]: line.split()[1:] for line in log.read_text("ascii").splitlines() if line[0] != "#"}
        suite = self._ssl.cipher()[0]
        self._digest = "sha384" if suite.endswith("SHA384") else "sha256"
        self._size = size = 32 if "256" in suite[:-6] else 16
        self.is_13 = self._ssl.version() == "TLSv1.3"
        if self.is_13:
            self._use(bytes.fromhex(secrets[f"{'SERVER' if server_side else 'CLIENT'}_TRAFFIC_SECRET_0"][1]))
        else:
            client_random, master = map(bytes.fromhex, secrets["CLIENT_RANDOM"])
            block = prf(master, b"key expansion" + self._server_random + client_random, self._digest)
            self._cipher = AESGCM(block[size : 2 * size] if server_side else block[:size])
            self._salt = block[2 * size :][4:8] if server_side else block[2 * size :][:4]
            self._number = 1  # Finished was 0

    def _shake_hands(self, context, server_side):
        incoming, outgoing = ssl.MemoryBIO(), ssl.MemoryBIO()
        self._ssl = context.wrap_bio(incoming, outgoing, server_side=server_side,
                                     server_hostname=None if server_side else "localhost")
        flights = []
        while True:
            try:
                self._ssl.do_handshake()
                break
            except ssl.SSLWantReadError:
                self.raw.sendall(sent := outgoing.read())
                got = self.raw.recv(65536)
                if not got:
                    raise ConnectionResetError from None
                flights += [sent] if server_side and sent else [] if server_side else [got]
                incoming.write(got)
        self.raw.sendall(outgoing.read())
        self._server_random = (flights or [b""])[0][11:43]  # of the ServerHello, which comes first

    def _use(self, secret):
        self._secret = secret
        self._cipher = AESGCM(expand(secret, b"key", self._size, self._digest))
        self._salt = expand(secret, b"iv", 12, self._digest)
        self._number = 0

    def record(self, kind, payload=b""):
        number = struct.pack(">Q", self._number)
        self._number += 1
        if not self.is_13:
            sealed = self._cipher.encrypt(self._salt + number, payload, number + struct.pack(">BHH", kind, 0x0303, len(payload)))
            return struct.pack(">BHH", kind, 0x0303, len(sealed) + 8) + number + sealed
        head = struct.pack(">BHH", DATA, 0x0303, len(payload) + 17)
        nonce = bytes(a ^ b for a, b in zip(self._salt, bytes(4) + number))
        return head + self._cipher.encrypt(nonce, payload + bytes([kind]), head)

    def new_keys(self):
        """The record that says so; what follows has them."""
        record = self.record(HANDSHAKE, KEY_UPDATE)
        self._use(expand(self._secret, b"traffic upd", len(self._secret), self._digest))
        return record

    def without_data(self):
        """A record that is right, and carries nothing: new keys, or (TLS 1.2) the wish for another handshake."""
        return self.new_keys() if self.is_13 else self.record(HANDSHAKE, self._hello)
