#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The harness sees what it is there to see: a gateway that works, and one that does not."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

from demo_plant import program

BENCH = program("mbgate-bench")

# A gateway for one client that keeps no silence, and changes the last register of every tenth answer.
BAD_GATEWAY = """
import os, socket, sys, termios, tty
line = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY)
tty.setraw(line)
listening = socket.create_server(("127.0.0.1", int(sys.argv[2])))
def crc(data):
    value = 0xFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = (value >> 1) ^ 0xA001 if value & 1 else value >> 1
    return value.to_bytes(2, "little")
count = 0
while True:
    client, _ = listening.accept()
    while adu := client.recv(12):
        os.write(line, adu[6:] + crc(adu[6:]))
        response = b""
        while len(response) < 25:
            response += os.read(line, 300)
        count += 1
        body = bytearray(response[:-2])
        body[-1] ^= count % 10 == 0
        client.sendall(adu[:4] + len(body).to_bytes(2, "big") + body)
"""

# Whoever only looks whether there is a gateway says nothing.
ACCEPT = """
def accept():
    while True:
        try:
            return context.wrap_socket(listening.accept()[0], server_side=True)
        except OSError:
            pass
"""


def over_tls(gateway):
    """The same for a client over TLS, which keeps the silence and changes nothing."""
    context = """
import ssl, time
context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
context.load_cert_chain(sys.argv[3], sys.argv[4])
context.load_verify_locations(sys.argv[5])
context.verify_mode = ssl.CERT_REQUIRED
"""
    return (
        gateway.replace("termios, tty\n", "termios, tty" + context)
        .replace("    client, _ = listening.accept()", "    client = accept()")
        .replace("count = 0", ACCEPT + "count = 0")
        .replace("body[-1] ^= count % 10 == 0", "time.sleep(0.003)")
    )


def run_bench(*arguments, warm_up=0.3):
    """The contestants of the JSON that a run writes."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "figures.json"
        subprocess.run([BENCH, "--seconds", "0.5", "--warm-up", str(warm_up), "--json", file, *arguments],
                       check=True, stdout=subprocess.DEVNULL, timeout=120)
        return json.loads(file.read_text(encoding="utf-8"))["contestants"]


FAULTS = ("wrong", "lost", "unanswered", "bad_frames")


def run_undisturbed(*arguments, warm_up=0.3):
    """The harness measures time, so a busy machine shows faults now and then; what works is clean one time in ten."""
    for _ in range(10):
        contestants = run_bench(*arguments, warm_up=warm_up)
        medians = [contestant["median"] for contestant in contestants]
        if all(not median["violations"] and not any(median[fault] for fault in FAULTS) for median in medians):
            break
    return contestants


class Bench(unittest.TestCase):
    def check_clean(self, contestant):
        median = contestant["median"]
        self.assertGreater(median["answers_per_second"], 0, contestant)
        for fault in FAULTS:
            self.assertEqual(median[fault], 0, contestant)
        self.assertFalse(median["violations"], contestant)

    def test_all_that_it_brings_along_work(self):
        contestants = run_undisturbed("master", "relay", "mbgated", "mbgated:buses=2", "--pairs", "2")
        self.assertEqual([len(contestant["runs"]) for contestant in contestants], [2, 2, 2, 2])
        for contestant in contestants:
            self.check_clean(contestant)
            # No more than the wire can carry: 33 characters of ten bits at 115200 baud, and twice 1.75 ms.
            self.assertLessEqual(contestant["median"]["share_percent"], 102, contestant)
            self.assertAlmostEqual(contestant["scenario"]["exchange_us"], 33 * 10e6 / 115200 + 3500, places=0)

    def test_without_a_wire_to_wait_for(self):
        contestants = run_undisturbed("--baud", "0", "relay", "mbgated", "mbgated:idle=20,outstanding=4", "mbgated:flood=2")
        for contestant in contestants:
            self.check_clean(contestant)

    def test_dead_devices_are_exceptions(self):
        contestants = run_undisturbed("--clients", "4", "mbgated:dead=1", warm_up=1)
        self.check_clean(contestants[0])
        self.assertGreater(contestants[0]["median"]["exceptions"], 0)

    def test_the_same_registers_are_read_once(self):
        contestants = run_bench("--same", "--devices", "1", "--clients", "8", "mbgated")
        median = contestants[0]["median"]
        self.assertGreater(median["answers_per_second"], 4 * median["wire_per_second"])

    def test_a_bad_gateway_is_seen(self):
        with tempfile.TemporaryDirectory() as folder:
            script = pathlib.Path(folder) / "bad_gateway.py"
            script.write_text(BAD_GATEWAY, encoding="utf-8")
            contestants = run_bench("bad", "--clients", "1", "--command",
                                    f"bad={sys.executable} {script} {{device}} {{port}}")
        median = contestants[0]["median"]
        self.assertGreater(median["wrong"], 0)
        self.assertGreater(median["violations"], 0)

    def test_clients_speak_tls(self):
        with tempfile.TemporaryDirectory() as folder:
            script = pathlib.Path(folder) / "tls_gateway.py"
            script.write_text(over_tls(BAD_GATEWAY), encoding="utf-8")
            command = f"secure={sys.executable} {script} {{device}} {{port}} {{certificate}} {{key}} {{authorities}}"
            contestants = run_bench("secure:tls=1", "--clients", "1", "--command", command)
        self.assertTrue(contestants[0]["scenario"]["tls"])
        median = contestants[0]["median"]
        self.assertGreater(median["answers_per_second"], 0)
        self.assertEqual([0, 0, 0], [median[fault] for fault in ("wrong", "lost", "bad_frames")])

    def test_tls_is_compared_with_none(self):
        contestants = run_undisturbed("mbgated", "mbgated:tls=1", "mbgated:handshakes=1")
        for contestant in contestants:
            self.check_clean(contestant)
        self.assertIsNone(contestants[1]["median"]["handshakes_per_second"])
        # Who shakes hands runs only when nobody else does: on a busy machine perhaps never.
        self.assertGreaterEqual(contestants[2]["median"]["handshakes_per_second"], 0)

    def test_a_gateway_that_does_not_start(self):
        result = subprocess.run([BENCH, "absent", "--command", "absent=echo no such line {device}"],
                                capture_output=True, text=True, timeout=60, check=False)
        self.assertEqual(result.returncode, 1)
        self.assertIn("absent does not listen at 127.0.0.1:", result.stderr)
        self.assertIn("no such line /dev/pts/", result.stderr)

    def test_what_cannot_be_measured(self):
        for arguments, reason in (
                (["gateway"], '"gateway" is neither mbgated, master, relay nor a name of --command'),
                (["mbgated:bauds=1"], 'mbgated:bauds=1: unknown key "bauds"'),
                (["mbgated:baud=fast"], 'mbgated:baud=fast: "fast" is not a number'),
                (["mbgated", "--dead", "5"], "a bus has 1 to 247 devices, and not more dead ones"),
                (["relay", "--dead", "1"], "waits for every answer"),
                (["mbgated:clients=501"], "not more than 500 clients have registers of their own"),
                (["master:tls=1"], "master:tls=1: neither master nor relay speaks TLS"),
                (["relay:buses=2"], "only mbgated and master take several buses")):
            result = subprocess.run([BENCH, *arguments], capture_output=True, text=True, timeout=60,
                                    check=False)
            self.assertEqual(result.returncode, 1, arguments)
            self.assertIn(reason, result.stderr)


if __name__ == "__main__":
    unittest.main()
