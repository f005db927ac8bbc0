#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Modbus/TCP Security over mbgated's own listeners, with Python's ssl (OpenSSL) as the client: handshakes, roles,
resumption, revocation, and what a reload does. README.md here says which clause of MB-TCP-Security v36 each shows."""

import contextlib
import datetime
import hashlib
import os
import signal
import socket
import ssl
import struct
import subprocess
import time
import tty
import unittest

from control_case import UnixConnection
from demo_plant import PATIENCE
from tls_certificates import Authority, pem, serialization, utf8
from tls_plant import READ, TlsCase, adu, answer_of, ask

VERSIONS = (ssl.TLSVersion.TLSv1_2, ssl.TLSVersion.TLSv1_3)
DENIED = b"\x84\x01"


@contextlib.contextmanager
def stopped(process):
    """What a program that runs maps and unmaps between two looks at it does not change here."""
    process.signal(signal.SIGSTOP)
    try:
        os.waitid(os.P_PID, process.pid, os.WSTOPPED)  # the signal is on its way until then
        yield
    finally:
        process.signal(signal.SIGCONT)


def has_in_memory(process, wanted):
    """Whether one of `wanted` is among what the program has written itself; the shadow of a sanitizer is terabytes, and
    no part of it."""
    found = False
    with stopped(process), open(f"/proc/{process.pid}/maps", encoding="utf-8") as maps, open(
            f"/proc/{process.pid}/mem", "rb", buffering=0) as memory:
        for line in maps:
            begin, end = (int(number, 16) for number in line.split()[0].split("-"))
            if line.split()[1].startswith("rw") and end - begin < 1 << 26:
                memory.seek(begin)
                held = memory.read(end - begin)
                assert len(held) == end - begin, f"only {len(held)} bytes can be read of {line}"
                found = found or any(form in held for form in wanted)
    return found


class Handshake(TlsCase):
    def test_both_versions_carry_what_a_plain_connection_carries(self):
        for listener in ("secure", "secure-rsa"):
            for version in VERSIONS:
                with self.subTest(listener=listener, version=version), self.plant.client(newest=version,
                                                                                          listener=listener) as client:
                    self.assertEqual(client.version(), version.name.replace("_", "."))
                    self.assert_served(client)
                    # Many at a time, and one a byte at a time.
                    client.sendall(b"".join(adu(READ, number) for number in range(12)))
                    self.assertEqual([answer_of(client) for _ in range(12)], [self.answer] * 12)
                    for byte in adu(READ):
                        client.sendall(bytes([byte]))
                    self.assertEqual(answer_of(client), self.answer)

    def test_the_cipher_suites_are_those_of_the_specification(self):
        expected = {
            ("secure", VERSIONS[0]): "ECDHE-ECDSA-AES128-GCM-SHA256",
            ("secure-rsa", VERSIONS[0]): "ECDHE-RSA-AES128-GCM-SHA256",
            ("secure", VERSIONS[1]): "TLS_AES_128_GCM_SHA256",
            ("secure-rsa", VERSIONS[1]): "TLS_AES_128_GCM_SHA256",
        }
        for (listener, version), name in expected.items():
            with self.plant.client(newest=version, listener=listener) as client:
                self.assertEqual(client.cipher()[0], name)

    def test_a_client_without_certificate_gets_an_alert(self):
        with self.assertRaisesRegex(ssl.SSLError, "alert"):
            self.plant.connect(self.plant.context(newest=VERSIONS[0]))
        client = self.use(self.plant.connect(self.plant.context(newest=VERSIONS[1])))
        with self.assertRaisesRegex(ssl.SSLError, "CERTIFICATE_REQUIRED"):
            client.sendall(adu(READ))
            client.recv(1)
        self.refusal("peer did not return a certificate")
        self.refusal("peer did not return a certificate")

    def test_a_certificate_of_another_authority_gets_an_alert(self):
        stranger = Authority("stranger").issue("stranger", [utf8("Operator")])
        with self.assertRaisesRegex(ssl.SSLError, "UNKNOWN_CA"):
            self.plant.client(stranger, VERSIONS[0])
        self.refusal("certificate verify failed: (unable to get local issuer|self-signed) certificate")

    def test_an_expired_certificate_and_one_of_a_server_are_refused(self):
        old = self.plant.authority.issue("old", [utf8("Operator")], lasts=-datetime.timedelta(hours=1))
        with self.assertRaisesRegex(ssl.SSLError, "CERTIFICATE_EXPIRED"):
            self.plant.client(old, VERSIONS[0])
        server = self.plant.authority.issue("server", server=True)
        with self.assertRaisesRegex(ssl.SSLError, "alert"):
            self.plant.client(server, VERSIONS[0])

    def test_who_speaks_no_tls_is_let_go(self):
        plain = self.use(self.plant.plain("secure"))
        plain.sendall(adu(READ))
        self.assert_ended(plain)
        self.refusal("no TLS handshake: ")
        with self.plant.client() as client:
            self.assert_served(client)
        connection = UnixConnection(self.plant.folder / "control")
        self.addCleanup(connection.close)
        connection.request("GET", "/metrics")
        self.assertIn('mbgate_listener_tls_failures_total{listener="secure"} 1\n', connection.getresponse().read().decode())

    def test_the_certificate_comes_with_those_up_to_the_root(self):
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        context.load_verify_locations(cadata=pem(self.plant.root.certificate).decode())
        context.load_cert_chain(*self.plant.operator.files(self.plant.folder))
        with self.plant.connect(context) as client:
            self.assert_served(client)


class Roles(TlsCase):
    def ask_as(self, roles):
        client = self.use(self.plant.client(self.plant.authority.issue("client", roles)))
        return client, ask(client)

    def test_a_role_and_the_null_role_shake_hands(self):
        self.assertEqual(self.ask_as([utf8("Operator")])[1], self.answer)
        self.assertEqual(self.ask_as([])[1], self.answer)

    def test_a_login_is_journaled(self):
        with self.plant.client():
            self.plant.gateway.wait_for(r'^notice: listener secure: client 127\.0\.0\.1 \(role "Operator", certificate "operator"\) '
                                        "has logged in with its certificate$")

    def test_a_role_that_cannot_be_read_shakes_hands_and_gets_01_for_every_request(self):
        for roles in ([utf8("")], [b"\x13\x08Operator"], [utf8("Operator"), utf8("Viewer")], [b"\x0c\x03ab"], [b""]):
            with self.subTest(roles=roles):
                client, answer = self.ask_as(roles)
                self.assertEqual(answer, DENIED)
                self.assertEqual(ask(client), DENIED)  # the session stays


class Endings(TlsCase):
    def test_a_client_that_has_said_all_gets_its_answers(self):
        client = self.use(self.plant.client())
        client.sendall(adu(READ))
        self.assertEqual(answer_of(client), self.answer)
        raw = client.unwrap()  # close_notify of both
        self.assertEqual(raw.recv(1), b"")

    def test_the_gateway_says_goodbye_when_it_ends(self):
        client = self.use(self.plant.client())
        self.assert_served(client)
        self.plant._processes.remove(self.plant.gateway)
        self.assertEqual(self.plant.gateway.end(), 0)
        self.assertEqual(client.recv(1), b"")  # a FIN without close_notify would raise

    def test_a_handshake_that_takes_too_long_is_ended(self):
        self.reconfigure('tls = "ec"', 'tls = "ec"\nhandshake_timeout = "100ms"')
        silent = self.use(self.plant.plain("secure"))
        self.assert_ended(silent)
        self.refusal(r"no TLS handshake: it took too long \(handshake_timeout\)")

    def greet(self, address):
        """A client whose ClientHello has come, and what it needs to go on."""
        raw = self.use(self.plant.plain("secure", address))
        incoming, outgoing = ssl.MemoryBIO(), ssl.MemoryBIO()
        client = self.plant.context(self.plant.operator).wrap_bio(incoming, outgoing, server_hostname="localhost")
        with self.assertRaises(ssl.SSLWantReadError):
            client.do_handshake()
        raw.sendall(outgoing.read())
        incoming.write(raw.recv(65536))
        return raw, client, incoming, outgoing

    def assert_goes_on(self, raw, client, incoming, outgoing):
        while True:
            try:
                client.do_handshake()
                break
            except ssl.SSLWantReadError:
                raw.sendall(outgoing.read())
                incoming.write(raw.recv(65536))
        client.write(adu(READ))
        raw.sendall(outgoing.read())
        while True:
            try:
                self.assertEqual(client.read(300)[7:], self.answer)
                break
            except ssl.SSLWantReadError:
                incoming.write(raw.recv(65536))

    def silent(self, address):
        """A client that has brought half of its ClientHello."""
        raw = self.use(self.plant.plain("secure", address))
        raw.sendall(bytes.fromhex("16 03 01 02 00 01 00 01 fc 03 03"))
        return raw

    def test_only_so_many_shake_hands_at_a_time(self):
        self.reconfigure('tls = "ec"', 'tls = "ec"\nmax_handshakes = 4\nmax_handshakes_per_client = 2\nhandshake_timeout = "2m"')
        waiting = [self.greet(f"127.0.0.{2 + number // 2}") for number in range(4)]
        for address, limit in (("127.0.0.2", "max_handshakes_per_client"), ("127.0.0.4", "max_handshakes")):
            # The second one at the latest comes after all that was said before.
            self.use(self.plant.plain("secure", address))
            self.use(self.plant.plain("secure", address))
            self.plant.gateway.wait_for(rf"client {address}: .*\({limit}\)")
        for client in waiting:
            self.assert_goes_on(*client)

    def test_who_is_silent_keeps_nobody_out(self):
        self.reconfigure('tls = "ec"', 'tls = "ec"\nhello_timeout = "2m"\nhandshake_timeout = "2m"')
        silent = [self.silent(f"127.0.0.{10 + number % 8}") for number in range(64)]
        for _ in range(5):
            with self.plant.client() as client:
                self.assert_served(client)
        self.plant.gateway.wait_for(
            r"client 127\.0\.0\.10: no TLS handshake: closed for another client, because no ClientHello had come \(max_handshakes\)")
        self.assert_ended(silent[0])
        connection = UnixConnection(self.plant.folder / "control")
        self.addCleanup(connection.close)
        connection.request("GET", "/metrics")
        self.assertRegex(connection.getresponse().read().decode(), r'tls_failures_total\{listener="secure"\} [1-9]')

    def test_who_is_silent_keeps_its_own_address_not_out(self):
        self.reconfigure('tls = "ec"', 'tls = "ec"\nhello_timeout = "2m"\nhandshake_timeout = "2m"')
        silent = [self.silent("127.0.0.1") for _ in range(8)]
        with self.plant.client() as client:
            self.assert_served(client)
        self.refusal(r"closed for another client, because no ClientHello had come \(max_handshakes_per_client\)")
        self.assert_ended(silent[0])

    def test_a_piece_of_a_client_hello_is_none(self):
        self.reconfigure('tls = "ec"', 'tls = "ec"\nhello_timeout = "100ms"')
        self.assert_ended(self.silent("127.0.0.1"))
        self.refusal(r"no TLS handshake: no ClientHello came in time \(hello_timeout\)")
        # Who has brought it has the time of a handshake.
        self.reconfigure('"100ms"', '"30s"')
        client = self.greet("127.0.0.1")
        self.assert_goes_on(*client)

    def test_only_so_many_begin_within_a_second(self):
        self.reconfigure("second_per_client = 0", "second_per_client = 1\nmax_handshakes_per_client = 60", 1)
        for _ in range(50):  # which takes less than 50 s
            self.use(self.plant.plain("secure"))
        self.refusal(r"too many handshakes of one client \(max_handshakes_per_second_per_client\)")

    def test_only_so_many_of_all_begin_within_a_second(self):
        self.reconfigure("max_handshakes_per_second = 0", "max_handshakes_per_second = 1\nmax_handshakes = 60", 1)
        for client in range(50):  # which takes less than 50 s
            self.use(self.plant.plain("secure", f"127.0.0.{client + 1}"))
        self.plant.gateway.wait_for(r"too many handshakes \(max_handshakes_per_second\)")


class Resumption(TlsCase):
    def resumed(self, context, session, listener="secure"):
        client = self.use(self.plant.connect(context, listener, session=session))
        self.assert_served(client)
        return client.session_reused

    def test_a_session_is_taken_up_again_without_a_ticket(self):
        for version in VERSIONS:
            with self.subTest(version=version):
                context = self.plant.context(self.plant.operator, version)
                first = self.use(self.plant.connect(context))
                self.assert_served(first)
                session = first.session
                first.unwrap()
                if version == VERSIONS[0]:
                    self.assertFalse(session.has_ticket)
                    self.assertEqual(len(session.id), 32)
                self.assertTrue(self.resumed(context, session))

    def test_a_certificate_that_has_ended_since_is_judged_again(self):
        for version in VERSIONS:
            with self.subTest(version=version):
                self.assert_judged_again(version)

    def assert_judged_again(self, version):
        for lasts in (3, 15, 60):  # seconds: a busy machine may need longer for a handshake
            ends = time.time() + lasts
            certificate = self.plant.authority.issue("short", [utf8("Viewer")], lasts=datetime.timedelta(seconds=lasts))
            context = self.plant.context(certificate, version)
            try:
                first = self.use(self.plant.connect(context))
                self.assert_served(first)
            except ssl.SSLError:
                continue
            self.assertTrue(self.resumed(context, first.session))
            time.sleep(max(0, ends + 1 - time.time()))
            with self.assertRaisesRegex(ssl.SSLError, "CERTIFICATE_EXPIRED"):
                self.use(self.plant.connect(context, session=first.session)).recv(1)
            self.refusal("no TLS handshake: .*certificate has expired")
            return
        self.fail("no handshake")

    def test_the_role_follows_a_session_that_is_taken_up_again(self):
        certificate = self.plant.authority.issue("two", [utf8("A"), utf8("B")])
        context = self.plant.context(certificate, VERSIONS[0])
        first = self.use(self.plant.connect(context))
        self.assertEqual(ask(first), DENIED)
        again = self.use(self.plant.connect(context, session=first.session))
        self.assertEqual(ask(again), DENIED)
        self.assertTrue(again.session_reused)

    def test_a_session_is_forgotten_after_a_fatal_alert(self):
        for version in VERSIONS:
            with self.subTest(version=version):
                context = self.plant.context(self.plant.operator, version)
                incoming, outgoing = ssl.MemoryBIO(), ssl.MemoryBIO()
                client = context.wrap_bio(incoming, outgoing, server_hostname="localhost")
                raw = self.use(self.plant.plain("secure"))

                def pump(step, *arguments):
                    while True:
                        try:
                            result = step(*arguments)
                        except ssl.SSLWantReadError:
                            result = None
                        raw.sendall(outgoing.read())
                        if result is not None or step == client.do_handshake and client.version():
                            return result
                        incoming.write(raw.recv(65536))

                try:
                    pump(client.do_handshake)
                    pump(client.write, adu(READ))
                    self.assertEqual(len(pump(client.read, 300)), 11)
                except ssl.SSLWantReadError:
                    self.fail("no handshake")
                session = client.session
                self.assertTrue(self.resumed(context, session))
                client.write(adu(READ))
                record = bytearray(outgoing.read())
                record[-1] ^= 1  # its tag is wrong: bad_record_mac
                raw.sendall(record)
                self.assert_ended(raw)
                self.assertFalse(self.resumed(context, session))


class Reload(TlsCase):
    def test_a_new_certificate_is_shown_and_no_session_is_lost(self):
        before = self.use(self.plant.client())
        self.assert_served(before)
        shown = before.getpeercert(binary_form=True)
        new = self.plant.authority.issue("ec", server=True, chain=[self.plant.authority.certificate])
        self.plant.install("ec", new)
        self.reload()
        after = self.use(self.plant.client())
        self.assert_served(after)
        self.assertNotEqual(after.getpeercert(binary_form=True), shown)
        self.assert_served(before)

    def test_clients_from_before_it_hold_no_connection_to_the_signer(self):
        for _ in range(40):  # a signer takes 32 connections
            self.assert_served(self.use(self.plant.client()))
            new = self.plant.authority.issue("ec", server=True, chain=[self.plant.authority.certificate])
            self.plant.install("ec", new)
            self.reload("reload: done")
        self.assert_served(self.use(self.plant.client()))

    def test_a_revoked_client_is_ended_and_cannot_come_again(self):
        other = self.plant.authority.issue("other", [utf8("Viewer")])
        context = self.plant.context(self.plant.operator, VERSIONS[0])
        revoked = self.use(self.plant.connect(context))
        stays = self.use(self.plant.client(other))
        for client in (revoked, stays):
            self.assert_served(client)
        self.plant.authority.revoked.append(self.plant.operator)
        self.plant.write_crl()
        self.reload()
        self.refusal("its certificate is not accepted any more: certificate revoked")
        self.assert_ended(revoked)
        self.assert_served(stays)
        with self.assertRaisesRegex(ssl.SSLError, "CERTIFICATE_REVOKED"):
            self.plant.connect(context, session=revoked.session)

    def test_a_reload_says_which_list_is_new(self):
        self.reload("reload: nothing has changed$")
        self.plant.authority.revoked.append(self.plant.operator)
        self.plant.write_crl()
        fingerprint = "(?:[0-9A-F]{2}:){7}[0-9A-F]{2}"
        before, after = (rf"[-0-9]{{10}} [:0-9]{{8}} UTC, {count} revoked, {fingerprint} and .*" for count in (0, 1))
        self.reload(rf"^notice: reload: \[\[tls\]\] ec: crl {before} -> {after}$")
        self.plant.gateway.wait_for("^info: reload: done$")
        shown = self.plant.authority.issue("ec", server=True, chain=[self.plant.authority.certificate])
        self.plant.install("ec", shown)
        said = self.reload(rf"^notice: reload: \[\[tls\]\] ec: certificate ({fingerprint}) -> ({fingerprint})$").group(2)
        digest = hashlib.sha256(shown.certificate.public_bytes(serialization.Encoding.DER)).hexdigest().upper()
        self.assertEqual(said, ":".join(digest[at : at + 2] for at in range(0, 16, 2)))

    def test_a_client_that_is_revoked_while_it_shakes_hands_is_refused(self):
        context = self.plant.context(self.plant.operator, VERSIONS[0])
        raw = self.use(self.plant.plain("secure"))
        incoming, outgoing = ssl.MemoryBIO(), ssl.MemoryBIO()
        client = context.wrap_bio(incoming, outgoing, server_hostname="localhost")

        def step():
            try:
                client.do_handshake()
            except ssl.SSLWantReadError:
                pass
            return outgoing.read()

        raw.sendall(step())
        held = b""  # its certificate and what comes after: sent after the reload
        while not held:
            incoming.write(raw.recv(65536))
            held = step()
        self.plant.authority.revoked.append(self.plant.operator)
        self.plant.write_crl()
        self.reload()
        raw.sendall(held)
        self.refusal("its certificate is not accepted any more: certificate revoked")
        self.assert_ended(raw)

    def test_a_listener_with_another_tls_judges_by_that(self):
        client = self.use(self.plant.client())
        self.assert_served(client)
        self.plant.authority.revoked.append(self.plant.operator)
        self.plant.write_crl()
        self.reconfigure('"ec"', '"other"')
        self.refusal("its certificate is not accepted any more: certificate revoked")
        self.assert_ended(client)

    def test_a_listener_that_has_tls_now_or_no_more_keeps_no_client(self):
        clients = [self.use(self.plant.plain()), self.use(self.plant.client())]
        for client in clients:
            self.assert_served(client)
        self.reconfigure('name = "plain"', 'name = "plain"\ntls = "ec"')
        self.assert_ended(clients[0])
        self.assert_served(clients[1])
        self.reconfigure('tls = "ec"\nmax_handshakes_per_second = 0\nmax_handshakes_per_second_per_client = 0', "")
        self.plant.gateway.wait_for(r"client 127\.0\.0\.1: its listener has no TLS any more")
        self.assert_ended(clients[1])

    def test_a_list_that_has_expired_is_told_and_still_counts(self):
        self.plant.authority.revoked.append(self.plant.operator)
        self.plant.write_crl(ends=-datetime.timedelta(minutes=1))
        self.reload(r"\[\[tls\]\] ec: the list of revoked certificates expired at .*: it is still used")
        with self.assertRaisesRegex(ssl.SSLError, "CERTIFICATE_REVOKED"):
            self.plant.client(newest=VERSIONS[0])
        with self.plant.client(self.plant.authority.issue("other")) as client:
            self.assert_served(client)

    def test_a_certificate_that_ends_soon_is_told(self):
        soon = self.plant.authority.issue("ec", server=True, lasts=datetime.timedelta(days=20),
                                          chain=[self.plant.authority.certificate])
        self.plant.install("ec", soon)
        self.reload(r"\[\[tls\]\] ec: the certificate expires at \d{4}-\d\d-\d\d \d\d:\d\d UTC$")

    def test_what_does_not_fit_changes_nothing(self):
        alien = self.plant.authority.issue("alien", server=True)
        alien.files(self.plant.folder)[1].rename(self.plant.keys / "ec.key")
        self.reload(r"\[\[tls\]\] ec: ec\.key: it is not the key of the certificate")
        self.plant.gateway.wait_for("the configuration stays as it is")
        (self.plant.folder / "ca.crt").unlink()
        self.reload(r"\[\[tls\]\] ec: .*/ca\.crt: No such file or directory")
        with self.plant.plain() as client:
            self.assertEqual(ask(client), self.answer)


class Revocation(TlsCase):
    def test_a_section_without_a_list_is_told_of_at_the_start(self):
        told = [line for line in self.plant.gateway.printed if "without crl a certificate that was lost" in line]
        self.assertEqual(len(told), 1, self.plant.gateway.printed)
        text = self.plant.configuration.read_text(encoding="utf-8").splitlines()
        section = text.index('name = "rsa"')
        self.assertIn(f"mbgate.toml:{section}:1: warning: [[tls]]: ", told[0])


class Signer(TlsCase):
    def test_keys_that_others_can_change_or_read_are_refused(self):
        for mode, why in ((0o660, "users other than its owner may write to it"), (0o604, "everybody may read it")):
            (self.plant.keys / "ec.key").chmod(mode)
            self.reload(rf"mbgate-signer: ec\.key: {why}: chmod ")
        (self.plant.keys / "ec.key").unlink()
        self.reload(r"mbgate-signer: ec\.key: No such file or directory")
        (self.plant.keys / "ec.key").symlink_to(self.plant.keys / "rsa.key")
        self.reload(r"mbgate-signer: ec\.key: it is a link")

    def test_a_signer_that_was_started_again_is_asked_again(self):
        self.plant._processes.remove(self.plant.signer)
        self.assertEqual(self.plant.signer.end(), 0)
        with self.assertRaises((ssl.SSLError, ConnectionError)):
            self.plant.client()
        self.refusal(r"no TLS handshake: mbgate-signer \(.*\): (Connection refused|No such file or directory)")
        self.plant.start_signer()
        self.assert_served_in_the_end()

    def test_a_signer_that_does_not_answer_is_named_and_holds_nobody(self):
        served = self.use(self.plant.client())
        with stopped(self.plant.signer):
            for _ in range(20):  # 80 s if each of them held the others for some seconds
                with self.assertRaises((ssl.SSLError, ConnectionError)):
                    self.plant.client()
                self.assert_served(served)
            self.refusal("no TLS handshake: mbgate-signer does not answer")
        self.assert_served_in_the_end()

    def assert_served_in_the_end(self):
        """A signer that took more than 200 ms, be it because the machine is busy, is not asked for a second."""
        for _ in range(50):
            try:
                with self.plant.client() as client:
                    self.assert_served(client)
                return
            except (ssl.SSLError, ConnectionError):
                time.sleep(0.1)
        self.fail("no handshake with a signer that answers again")

    @unittest.skipUnless(os.geteuid() == 0, "only root reads the memory of other programs")
    def test_the_gateway_has_no_key_in_its_memory(self):
        with self.plant.client() as client:
            self.assert_served(client)
        text = (self.plant.keys / "ec.key").read_bytes()
        secret = serialization.load_pem_private_key(text, None).private_numbers().private_value.to_bytes(32, "big")
        forms = (secret, secret[::-1], text.splitlines()[1])  # OpenSSL's numbers begin with their last bytes
        self.assertTrue(has_in_memory(self.plant.signer, forms))
        self.assertFalse(has_in_memory(self.plant.gateway, forms))


@unittest.skipUnless(os.geteuid() == 0, "only root can start programs as other users")
class Accounts(TlsCase):
    NOBODY = 65534

    def become_nobody(self):
        os.setgroups([])
        os.setgid(self.NOBODY)
        os.setuid(self.NOBODY)

    def test_the_user_of_the_gateway_cannot_open_a_key_and_serves(self):
        plant = self.plant
        plant._processes.remove(plant.gateway)
        self.assertEqual(plant.gateway.end(), 0)
        plant.keys.chmod(0o700)
        plant.folder.chmod(0o777)
        os.chown(plant.folder / "signer", self.NOBODY, self.NOBODY)
        for command in (["cat", plant.keys / "ec.key"], ["ls", plant.keys]):
            tried = subprocess.run(command, capture_output=True, text=True, preexec_fn=self.become_nobody, check=False)
            self.assertIn("Permission denied", tried.stderr)
        plant.start_gateway(prepare=self.become_nobody)
        self.assertRegex(plant.gateway.process_file("status"), rf"Uid:\s+{self.NOBODY}\s+{self.NOBODY}")
        with plant.client() as client:
            self.assert_served(client)


class Stopped(TlsCase):
    WRITE = struct.pack(">BHH", 6, 0, 1)

    def write(self, stream):
        stream.sendall(adu(self.WRITE, unit=1))
        return answer_of(stream)

    def write_until_sent(self, stream):
        """On a busy machine the process may stand still of itself, and say of a write that it is too old: 06."""
        answers = []
        for _ in range(5):
            answers.append(self.write(stream))
            if answers[-1] != b"\x86\x06":
                break
        self.assertEqual(answers[-1], b"\x86\x0b", answers)  # sent, and not answered

    def open_line(self):
        """The line of the configuration, on which nobody answers, is there from now on."""
        ours, theirs = os.openpty()
        self.addCleanup(os.close, ours)
        self.addCleanup(os.close, theirs)
        tty.setraw(ours)
        (self.plant.folder / "no-such-port").symlink_to(os.ttyname(theirs))
        self.plant.gateway.wait_for("bus line-a is open")

    def test_a_write_from_before_a_stop_is_too_old_as_without_tls(self):
        self.open_line()
        clients = [self.use(self.plant.client(newest=version)) for version in VERSIONS] + [self.use(self.plant.plain())]
        for client in clients:
            self.write_until_sent(client)
        with stopped(self.plant.gateway):
            for client in clients:
                client.sendall(adu(self.WRITE, unit=1))
            time.sleep(4)  # a write may wait for 3.5 s
        self.assertEqual([answer_of(client) for client in clients], [b"\x86\x06"] * 3)
        self.write_until_sent(clients[0])

    def test_what_was_sent_while_the_gateway_was_stopped_is_answered(self):
        client = self.use(self.plant.client())
        self.assert_served(client)
        with stopped(self.plant.gateway):
            client.sendall(adu(READ))
        self.assertEqual(answer_of(client), self.answer)


class ReadsNothing(TlsCase):
    def test_it_is_ended_soon_after_the_machine_has_closed_its_connection(self):
        before = self.plant.gateway.sockets()
        raw = self.use(self.plant.plain("secure"))
        raw.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        client = self.use(self.plant.context(self.plant.operator).wrap_socket(raw, server_hostname="localhost"))
        client.settimeout(1)
        with self.assertRaises(TimeoutError):  # nothing moves any more, in either direction
            while True:
                client.sendall(adu(READ) * 100)
        self.reconfigure('name = "secure"\n', 'name = "secure"\nallow = ["127.0.0.2"]\n')
        limit = time.monotonic() + PATIENCE / 2  # the kernel would give it up after PATIENCE
        while self.plant.gateway.sockets() > before:
            self.assertLess(time.monotonic(), limit, "its sockets are still open")
            time.sleep(0.05)


if __name__ == "__main__":
    unittest.main()
