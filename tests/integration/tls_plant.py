# SPDX-License-Identifier: Apache-2.0
"""mbgated with listeners that speak TLS, its mbgate-signer, and clients with certificates. The requests are for the
status unit, so no line is needed."""

import pathlib
import signal
import socket
import ssl
import struct
import unittest

from demo_plant import PATIENCE, Plant, Process
from tls_certificates import Authority, pem, utf8

CONFIGURATION = """
[gateway]
signer = "signer"

[http]
socket = "{folder}/control"

[[tls]]
name = "ec"
certificate = "ec.crt"
key = "ec.key"
authorities = "ca.crt"
crl = "ca.crl"

[[tls]]
name = "rsa"
certificate = "rsa.crt"
key = "rsa.key"
authorities = "ca.crt"

[[listen]]
name = "secure"
port = 0
tls = "ec"
max_handshakes_per_second = 0
max_handshakes_per_second_per_client = 0
bus = "line-a"

[[listen]]
name = "secure-rsa"
port = 0
tls = "rsa"
max_handshakes_per_second = 0
max_handshakes_per_second_per_client = 0
bus = "line-a"

[[listen]]
name = "plain"
port = 0
bus = "line-a"

[[bus]]
name = "line-a"
device = "no-such-port"
offline_after = 0
"""
OWN_UNIT = 255
READ = struct.pack(">BHH", 4, 0, 1)  # the first register of the status unit


def receive(stream, size):
    """As many bytes; fewer if the other end has ended before."""
    data = b""
    while len(data) < size:
        more = stream.recv(size - len(data))
        if not more:
            break
        data += more
    return data


def adu(pdu, transaction=1, unit=OWN_UNIT):
    return struct.pack(">HHHB", transaction, 0, len(pdu) + 1, unit) + pdu


def answer_of(stream):
    """The PDU of the next answer."""
    head = receive(stream, 7)
    if len(head) < 7:
        return b""
    return receive(stream, struct.unpack(">HHHB", head)[2] - 1)


def ask(stream, pdu=READ):
    stream.sendall(adu(pdu))
    return answer_of(stream)


class TlsPlant(Plant):
    """plant.ports has the ports by the names of listeners; plant.client(...) connects."""

    def _start(self):
        self.folder = pathlib.Path(self._folder.name)
        self.keys = self.folder / "keys"
        self.keys.mkdir()
        self.root = Authority("root")
        self.authority = Authority("authority", self.root)
        (self.folder / "ca.crt").write_bytes(self._authorities())
        self.write_crl()
        for kind in ("ec", "rsa"):
            self.install(kind, self.authority.issue(kind, server=True, kind=kind, chain=[self.authority.certificate]))
        self.operator = self.authority.issue("operator", [utf8("Operator")])
        self.configuration = self.folder / "mbgate.toml"
        text = CONFIGURATION.format(folder=self.folder).replace('signer = "', f'signer = "{self.folder}/')
        self.configuration.write_text(text, encoding="utf-8")
        self.signer = self.start_signer()
        self.start_gateway()

    def _authorities(self):
        return pem(self.root.certificate) + pem(self.authority.certificate)

    def install(self, name, certificate):
        """Certificate and key of a server in their places."""
        public, private = certificate.files(self.folder)
        private.rename(self.keys / f"{name}.key")
        if public.name != f"{name}.crt":
            public.rename(self.folder / f"{name}.crt")

    def write_crl(self, **arguments):
        (self.folder / "ca.crl").write_bytes(self.authority.crl(**arguments) + self.root.crl())

    def start_signer(self):
        signer = Process(self.folder, "mbgate-signer", "--keys", self.keys, "--certificates", self.folder,
                         "--socket", self.folder / "signer")
        self._processes.append(signer)
        signer.wait_for("^listening")
        return signer

    def start_gateway(self, prepare=None):
        self.gateway = Process(self.folder, "mbgated", "--config", self.configuration, prepare=prepare)
        self._processes.append(self.gateway)
        self.ports = {}
        for _ in range(3):
            name, port = self.gateway.wait_for(r"listening (\S+) 127\.0\.0\.1:(\d+)$").groups()
            self.ports[name] = int(port)

    def context(self, certificate=None, newest=None):
        """For clients: who they are, whom they trust, and up to which version."""
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        context.load_verify_locations(self.folder / "ca.crt")
        if certificate is not None:
            context.load_cert_chain(*certificate.files(self.folder))
        if newest is not None:
            context.maximum_version = newest
        return context

    def connect(self, context, listener="secure", **arguments):
        raw = socket.create_connection(("127.0.0.1", self.ports[listener]), PATIENCE)
        try:
            return context.wrap_socket(raw, server_hostname="localhost", **arguments)
        except BaseException:
            raw.close()
            raise

    def client(self, certificate=None, newest=None, listener="secure"):
        return self.connect(self.context(certificate or self.operator, newest), listener)

    def plain(self, listener="plain", address="127.0.0.1"):
        return socket.create_connection(("127.0.0.1", self.ports[listener]), PATIENCE, source_address=(address, 0))


class TlsCase(unittest.TestCase):
    def setUp(self):
        self.plant = self.enterContext(TlsPlant())
        with self.plant.plain() as plain:
            self.answer = ask(plain)  # what the same request gets without TLS
        self.assertEqual(self.answer[:2], b"\x04\x02", "the status unit answers")

    def use(self, stream):
        """The stream, closed when the test ends."""
        self.addCleanup(stream.close)
        return stream

    def reload(self, pattern="reload: (done|nothing)"):
        self.plant.gateway.signal(signal.SIGHUP)
        return self.plant.gateway.wait_for(pattern)

    def reconfigure(self, old, new, count=-1, more="", pattern="reload: (done|nothing)"):
        """Another configuration is in force: `new` stands for `old`, in so many places or in all, and `more` at the end."""
        text = self.plant.configuration.read_text(encoding="utf-8")
        self.assertIn(old, text)
        self.plant.configuration.write_text(text.replace(old, new, count) + more, encoding="utf-8")
        self.reload(pattern)

    def assert_served(self, stream):
        self.assertEqual(ask(stream), self.answer)

    def assert_ended(self, stream):
        """The gateway has ended the connection: by a FIN, a reset, or an alert."""
        try:
            while stream.recv(4096):
                pass
        except (ssl.SSLError, ConnectionError):
            pass

    def refusal(self, pattern):
        """What the journal says of a client that was let go."""
        return self.plant.gateway.wait_for(r"client 127\.0\.0\.1: .*" + pattern)
